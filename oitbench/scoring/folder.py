"""Scoring the cells of a results folder anew."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from pathlib import Path

from oitbench.results.records import parts
from oitbench.results.schema import Record
from oitbench.results.store import Store
from oitbench.scoring.scorer import Findings, Scorer


def score_folder(
    folder: Path,
    scorer: Scorer,
    *,
    built_in: bool,
    watch: Callable[[list[Record]], Iterable[Record]] = iter,
) -> Findings:
    """Score all cells of a folder that have an image, and store their records.

    Parameters
    ----------
    folder : Path
        A results folder, or a merged one.
    scorer : Scorer
    built_in : bool
        Compute the suite's metrics, too.
    watch : callable
        Wraps the cells, to show progress.

    Raises
    ------
    UsageError
        The folder holds no results, or another process writes to it.
    StorageError
        It cannot be written to. Cells that were scored before are stored.
    """
    findings = Findings()
    for part in parts(folder):
        with Store.open(part) as store:
            for record in watch(store.records()):
                score_cell(store, record, scorer, findings, built_in=built_in)
            store.compact()
    return findings


def score_cell(
    store: Store, record: Record, scorer: Scorer, findings: Findings, *, built_in: bool = False
) -> None:
    """Score one cell, and store its record if it has changed."""
    changed = scorer.score(record, store.folder, findings, built_in=built_in)
    if changed != record:
        store.append(changed)

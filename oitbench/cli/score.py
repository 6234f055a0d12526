"""`oitbench score`: recompute metrics from stored images."""

from __future__ import annotations

import sys
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING

import click

from oitbench.cli import options
from oitbench.scoring.scorer import SECONDS

if TYPE_CHECKING:
    from oitbench.results.schema import Record


@click.command()
@click.argument("results", type=click.Path(path_type=Path))
@options.metrics("File of a metric. Repeatable. Default: the metrics of the suite.")
@click.option("--all", "built_in", is_flag=True, help="Recompute the suite's metrics, too.")
@options.timeout(SECONDS, "Seconds that each metric of two images may take.")
@options.memory
def command(
    results: Path,
    metrics: tuple[Path, ...],
    built_in: bool,
    timeout: float | None,
    memory_gib: float | None,
) -> None:
    """Recompute the metrics of RESULTS from the stored images; nothing is rendered.

    Images are stored in single precision, so the suite's metrics of unchanged images stay the same.
    Noise floors and times are kept. A cell whose images are damaged keeps its numbers.

    The exit code is 1 if an image is damaged, or if a metric failed.
    """
    from rich.console import Console
    from rich.progress import track

    from oitbench.scoring.folder import score_folder
    from oitbench.scoring.scorer import Scorer
    from oitbench.workers import memory

    console = Console(stderr=True)

    def watch(records: list[Record]) -> Iterable[Record]:
        hidden = not console.is_terminal
        return track(records, "cells", console=console, transient=True, disable=hidden)

    with Scorer(metrics, memory.limit(memory_gib, 1), timeout) as scorer:
        names = ", ".join(scorer.metrics)
        found = score_folder(results, scorer, built_in=built_in or not metrics, watch=watch)
    for line in found.lines:
        click.echo(line, err=True)
    cells = f"{found.scored} cell{'' if found.scored == 1 else 's'}"
    click.echo(f"{results}: {cells} scored{f' by {names}' if names else ''}")
    sys.exit(1 if found.lines else 0)

"""Made-up results of the cells that figures need."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from oitbench.catalog.needs import Need
from oitbench.crops import Crop
from oitbench.report import ReportContext
from oitbench.results.records import Results
from oitbench.results.schema import Record
from tests.report.made_up import FACTS, finished


def made(folder: Path, need: Need, error: float = 0.1, **fields: Any) -> Record:
    """Return the record of a needed cell, whose picture is darker than the truth by `error`."""
    place = {"view": need.view, "effects": need.effects, "shading": need.shading}
    return finished(folder, need.scene, need.method, error, **(place | fields))


def context(
    folder: Path,
    records: Iterable[Record],
    crops: Mapping[str, Mapping[str, Crop]] | None = None,
    variants: Mapping[str, str] | None = None,
) -> ReportContext:
    """Return the context of figures of those records, whose pictures are in `folder`."""
    results = Results(folder, tuple(records), FACTS)
    return ReportContext(results, folder / "out", crops=crops or {}, variants=variants or {})

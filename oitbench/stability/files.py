"""The results as files: typed JSON, and CSV for spreadsheets."""

from __future__ import annotations

import csv
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import msgspec

from oitbench.atomic import replacing
from oitbench.results.documents import read_document
from oitbench.results.schema import Renderer
from oitbench.results.table import shielded
from oitbench.stability.result import VERSION, CheckResult, StabilityFile

JSON, CSV = "stability.json", "stability.csv"
_NONFINITE = ("nan", "inf", "negative")


def write(folder: Path, results: Sequence[CheckResult], gl: Renderer) -> None:
    """Write `stability.json` and `stability.csv` into `folder`.

    Parameters
    ----------
    folder : Path
        Created if it does not exist.
    results : sequence of CheckResult
    gl : Renderer

    Raises
    ------
    UsageError
        The folder cannot be written to.
    """
    content = msgspec.to_builtins(StabilityFile(gl, list(results)))
    for row, result in zip(content["results"], results, strict=True):
        row["failed"] = result.failed
    with replacing(folder / JSON) as partial:
        text = msgspec.json.format(msgspec.json.encode(content), indent=1)
        partial.write_bytes(text + b"\n")
    with (
        replacing(folder / CSV) as partial,
        partial.open("w", newline="", encoding="utf-8") as file,
    ):
        writer = csv.DictWriter(file, _columns())
        writer.writeheader()
        writer.writerows(map(_flat, content["results"]))


def find(results: Path) -> Path | None:
    """Return the `stability.json` of a results folder or of its folder `stability`, or None."""
    places = (results / "stability" / JSON, results / JSON)
    return next((place for place in places if place.is_file()), None)


def read(path: Path) -> list[CheckResult]:
    """Read the results in a `stability.json`.

    Raises
    ------
    UsageError
        The file cannot be read, holds something else, or another version of the suite wrote it.
    """
    return read_document(path, StabilityFile, VERSION, "stability").results


def _columns() -> list[str]:
    """Return the fields of a result; the counts of invalid pixels have a column each."""
    columns: list[str] = []
    for field in CheckResult.__struct_fields__:
        columns += _NONFINITE if field == "nonfinite" else (field,)
    return [*columns, "failed"]


def _flat(row: dict[str, Any]) -> dict[str, Any]:
    """Return a result of the JSON file as a row of the CSV file."""
    fields = {key: item for key, item in row.items() if key != "nonfinite"}
    return {key: shielded(value) for key, value in {**fields, **row["nonfinite"]}.items()}

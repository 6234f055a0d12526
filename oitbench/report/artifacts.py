"""What a report hands to the page: figures, tables, grids of pictures, and notes."""

from __future__ import annotations

import csv
import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

Value = str | int | float | None


@dataclass(frozen=True)
class Figure:
    """A figure, once for the screen and once for print."""

    title: str
    caption: str
    png: Path
    pdf: Path
    width: int
    """Width on the page in CSS pixels."""


@dataclass(frozen=True)
class Column:
    """One column of a table.

    Parameters
    ----------
    key : str
        Heading in the CSV file; carries unit or metric name.
    title, unit : str
        Heading on the page.
    kind : str
        `number`, `text`, `method` (with its color) or `status`.
    digits : int
        Significant digits on the page; the CSV file keeps all.
    decimals : int, optional
        Digits after the point instead, for columns whose values are of one magnitude.
    help : str
        Shown when the pointer rests on the heading.
    """

    key: str
    title: str
    unit: str = ""
    kind: str = "number"
    digits: int = 3
    decimals: int | None = None
    help: str = ""

    def text(self, value: Value) -> str:
        """Return `value` as the page shows it; a dash if there is none."""
        if value is None or value == "":
            return "–"
        if isinstance(value, str):
            return value
        if self.decimals is None or isinstance(value, int):
            return decimal(value, self.digits)
        return fixed(value, self.decimals)


@dataclass(frozen=True)
class Table:
    """A sortable table; `collapsed` ones wait behind a click."""

    title: str
    caption: str
    csv: Path
    columns: tuple[Column, ...]
    rows: tuple[tuple[Value, ...], ...]
    collapsed: bool = False

    @property
    def visible(self) -> list[int]:
        """Places of the columns that hold anything; the page leaves out the others."""
        return [
            place
            for place in range(len(self.columns))
            if any(row[place] not in (None, "") for row in self.rows)
        ]


@dataclass(frozen=True)
class Tile:
    """One picture of a grid with its error map beneath; `note` stands in for what is missing."""

    label: str
    picture: Path | None
    error_map: Path | None
    values: tuple[str, ...] = ()
    note: str = ""
    truth: bool = False


@dataclass(frozen=True)
class ImageGrid:
    """Pictures side by side, and the same as a figure for print."""

    title: str
    caption: str
    tiles: tuple[Tile, ...]
    figure: Figure


@dataclass(frozen=True)
class Note:
    """A sentence where a figure or table would have been."""

    text: str


Artifact = Figure | Table | ImageGrid | Note


def decimal(value: float, digits: int = 3) -> str:
    """Return `value` with that many significant digits and no exponent while it is readable."""
    if isinstance(value, int) or value == 0:
        return f"{value:,.0f}"
    magnitude = math.floor(math.log10(abs(value)))
    if magnitude < -5:
        return f"{value:.{digits - 1}e}"
    return f"{value:,.{max(0, digits - 1 - magnitude)}f}"


def fixed(value: float, decimals: int) -> str:
    """Return `value` with that many decimals; "0" means zero, and what is merely small says so."""
    if value == 0:
        return "0"
    least = 10.0**-decimals
    if abs(value) < least / 2:
        return f"<{least:.{decimals}f}" if value > 0 else f">−{least:.{decimals}f}"
    return f"{value:,.{decimals}f}"


def write_table(
    path: Path,
    columns: Sequence[Column],
    rows: Iterable[Sequence[Value]],
    *,
    title: str,
    caption: str,
    collapsed: bool = False,
) -> Table:
    """Write `rows` as CSV with all digits and return the table for the page."""
    kept = tuple(tuple(row) for row in rows)
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow([column.key for column in columns])
        writer.writerows(kept)
    return Table(title, caption, path, tuple(columns), kept, collapsed)

"""The parts of a report on the page: figures, tables, grids of pictures, and notes."""

from __future__ import annotations

import csv
import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from oitbench.crops import Crop
from oitbench.errors import UsageError
from oitbench.results.table import shielded
from oitbench.results.times import SIGN

_NOTHING = {"status": (None, "", "ok")}
"""Values that are no news, by the kind of a column."""
Value = str | int | float | None
Row = Sequence[Value]


class Marked(float):
    """A number that the page shows with `SIGN`."""


@dataclass(frozen=True)
class Figure:
    """A figure as PNG for the screen and as PDF for print; `width` is in CSS pixels."""

    title: str
    caption: str
    png: Path
    pdf: Path
    width: int


@dataclass(frozen=True)
class Column:
    """One column of a table.

    Parameters
    ----------
    key : str
        Heading in the CSV file; includes the unit or the name of the metric.
    title, unit : str
        Heading on the page.
    kind : str
        `number`, `rank`, `text` in one line, `prose` in several, `method` (with its color),
        `status`, or `section` (a link to it).
    digits : int
        Significant digits on the page; the CSV file has all.
    decimals : int, optional
        Digits after the point instead, for columns whose values have similar magnitudes.
    help : str
        Tooltip of the heading.
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
        if isinstance(value, Marked):
            return f"{self.text(float(value))} {SIGN}"
        if self.decimals is None or isinstance(value, int):
            return decimal(value, self.digits)
        return fixed(value, self.decimals)


@dataclass(frozen=True)
class Table:
    """A table that readers can sort and filter; a `collapsed` one opens with a click.

    `stem` is the name of its LaTeX file without suffix, by default that of the CSV file.
    """

    title: str
    caption: str
    csv: Path
    columns: tuple[Column, ...]
    rows: tuple[Row, ...]
    collapsed: bool = False
    stem: str = ""

    @property
    def tex(self) -> Path:
        """The LaTeX file, which `latex.write_all` writes."""
        return self.csv.with_name(f"{self.stem or self.csv.stem}.tex")

    @property
    def visible(self) -> list[int]:
        """Indices of the columns that have a value; the page omits the others.

        A status that is "ok" says nothing.
        """
        return [
            place
            for place, column in enumerate(self.columns)
            if any(row[place] not in _NOTHING.get(column.kind, (None, "")) for row in self.rows)
        ]


@dataclass(frozen=True)
class Tile:
    """A picture of a grid with its error map below.

    Parameters
    ----------
    label : str
    picture, error_map : Path, optional
        PNG files.
    values : tuple of str
        Lines below the pictures.
    note : str
        Reason why there is no picture, or why its cell is not "ok".
    truth : bool
        Whether the picture is a truth, and not that of a method.
    """

    label: str
    picture: Path | None
    error_map: Path | None
    values: tuple[str, ...] = ()
    note: str = ""
    truth: bool = False


@dataclass(frozen=True)
class ImageGrid:
    """Pictures side by side, and the same as one figure for print."""

    tiles: tuple[Tile, ...]
    figure: Figure


@dataclass(frozen=True)
class Layer:
    """One picture of a stack.

    Parameters
    ----------
    label : str
    truth : str
        Key of the truth that the picture is; empty for that of a method.
    values : tuple of str
        Lines below its previews.
    note : str
        Reason why there is no picture, or why its cell is not "ok".
    errors : mapping of str to float
        Mean error by the truth that the picture is compared with.
    picture, error_map : str
        Addresses of the previews; empty without a picture, or without a map.
    key : str
        Name of the pixels in the script of the stack; empty without a picture.
    maps : mapping of str to str
        Names of the error maps there, by truth.
    """

    label: str
    truth: str
    values: tuple[str, ...]
    note: str
    errors: Mapping[str, float]
    picture: str
    error_map: str
    key: str
    maps: Mapping[str, str]


@dataclass(frozen=True)
class Stack:
    """All pictures of a panel for the viewer.

    Parameters
    ----------
    name : str
        Part of addresses; other stacks have other names.
    layers : tuple of Layer
        Truths first.
    against : str
        Key of the truth that error maps compare with at first.
    radiance : bool
        Whether the pixels are linear radiance, and the errors HDR-FLIP; else they are display
        levels, and FLIP.
    exposure : float
        Stops.
    size : (int, int)
        Pixels of the pictures.
    crops : mapping of str to Crop
    pixels : Path
        The script that holds all pixels.
    title, caption : str
    sheet : Figure, optional
        The same pictures as one figure for print.
    """

    name: str
    layers: tuple[Layer, ...]
    against: str
    radiance: bool
    exposure: float
    size: tuple[int, int]
    crops: Mapping[str, Crop]
    pixels: Path
    title: str
    caption: str
    sheet: Figure | None = None


@dataclass(frozen=True)
class Note:
    """A sentence."""

    text: str


@dataclass(frozen=True)
class Statement:
    """Sentences that answer the question of a section."""

    sentences: tuple[str, ...]


@dataclass(frozen=True)
class Chosen:
    """A method that a criterion chooses; its numbers; and others that are as good."""

    method: str
    numbers: str
    equal: tuple[str, ...] = ()


@dataclass(frozen=True)
class SubjectRow:
    """The choices for one subject: one, or None, for each criterion.

    `remark` says how many scenes they come from; `scenes` are the titles of those.
    """

    subject: str
    remark: str
    scenes: tuple[str, ...]
    chosen: tuple[Chosen | None, ...]


@dataclass(frozen=True)
class Choices:
    """A table of methods that criteria choose for subjects.

    Each criterion has words and a tooltip.
    """

    title: str
    caption: str
    csv: Path
    criteria: tuple[tuple[str, str], ...]
    rows: tuple[SubjectRow, ...]


@dataclass(frozen=True)
class Shade:
    """A cell of a heat table: its text, its color as "#rrggbb", and whether it ties for the best.

    An empty color is that of the page.
    """

    text: str
    color: str = ""
    best: bool = False


@dataclass(frozen=True)
class HeatTable:
    """Numbers of rows by columns, shaded by value; a row has a name and a remark."""

    title: str
    caption: str
    csv: Path
    columns: tuple[str, ...]
    rows: tuple[tuple[str, str, tuple[Shade, ...]], ...]


@dataclass(frozen=True)
class Part:
    """HTML that opens with a click; `anchor` is its id."""

    anchor: str
    title: str
    html: str


@dataclass(frozen=True)
class Parts:
    """Parts of a section, each of which opens with a click."""

    parts: tuple[Part, ...]


@dataclass(frozen=True)
class Reference:
    """A source: its key, a sentence, those that cite it, and its BibTeX entry."""

    key: str
    text: str
    cited_by: tuple[str, ...]
    bibtex: str


@dataclass(frozen=True)
class References:
    """A bibliography, and the BibTeX file of all its entries."""

    entries: tuple[Reference, ...]
    bib: Path


Artifact = (
    Figure | Table | ImageGrid | Stack | Note | Statement | Choices | HeatTable | Parts | References
)


def decimal(value: float, digits: int = 3) -> str:
    """Return `value` with significant digits; values below 1e-5 get an exponent."""
    if isinstance(value, int) or value == 0:
        return f"{value:,.0f}"
    magnitude = math.floor(math.log10(abs(value)))
    if magnitude < -5:
        return f"{value:.{digits - 1}e}"
    return f"{value:,.{max(0, digits - 1 - magnitude)}f}"


def fixed(value: float, decimals: int) -> str:
    """Return `value` with a fixed number of decimals.

    Only zero becomes "0"; a value that would be rounded to zero becomes, for example, "<0.001".
    """
    if value == 0:
        return "0"
    least = 10.0**-decimals
    if abs(value) < least / 2:
        return f"<{least:.{decimals}f}" if value > 0 else f">−{least:.{decimals}f}"
    return f"{value:,.{decimals}f}"


@contextmanager
def writing_to(folder: Path) -> Iterator[None]:
    """Create `folder`, and report a failure to write files inside the block.

    Raises
    ------
    UsageError
        If the folder or a file cannot be written.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        yield
    except OSError as error:
        raise UsageError(
            f"{folder} cannot be written to ({error.strerror}); give -o DIR"
        ) from error


def write_csv(path: Path, heading: Sequence[str], rows: Iterable[Sequence[object]]) -> None:
    """Write a CSV file in an existing folder; None becomes an empty field.

    Texts that a spreadsheet would take for formulas begin with an apostrophe. Bytes of file names
    that are not UTF-8 become escapes.
    """
    with path.open("w", newline="", encoding="utf-8", errors="backslashreplace") as file:
        writer = csv.writer(file)
        writer.writerow(map(shielded, heading))
        writer.writerows([shielded(value) for value in row] for row in rows)


def write_table(
    path: Path,
    columns: Sequence[Column],
    rows: Iterable[Row],
    *,
    title: str,
    caption: str,
    collapsed: bool = False,
) -> Table:
    """Write `rows` as a CSV file with all digits, and return the table for the page."""
    kept = tuple(tuple(row) for row in rows)
    path.parent.mkdir(parents=True, exist_ok=True)
    write_csv(path, [column.key for column in columns], kept)
    return Table(title, caption, path, tuple(columns), kept, collapsed)

"""Figures with one look, legible at printed size, as PDF and PNG."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from importlib import resources
from pathlib import Path
from typing import TYPE_CHECKING, Any

from oitbench.report import fonts
from oitbench.report.artifacts import Figure
from oitbench.truths import EXACT, FULL, MATCHED

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure as Canvas

WIDTH = 9.4
"""Inches of a figure that fills the column of the page."""
DOTS_PER_INCH = 180
INK = "#222222"
QUIET = "#6b6b6b"
_CSS_PIXELS_PER_INCH = 118
_POINTS_PER_INCH = 72
_COMPRESSION = 3  # a third of the time of the default level, for a tenth more bytes
# Marker, fill and size of each truth; those of methods have other forms and colors.
_TRUTHS = {EXACT: ("o", "none", 7.0), MATCHED: ("o", INK, 4.2), FULL: ("|", INK, 7.5)}


@dataclass(frozen=True)
class Margins:
    """Room for texts around the axes of a grid, and between its columns and rows, in inches."""

    left: float
    right: float
    top: float
    bottom: float
    columns: float
    rows: float


@contextmanager
def canvas(width: float, height: float, *, by_hand: bool = False) -> Iterator[Canvas]:
    """Yield an empty figure; save it before the block ends.

    Parameters
    ----------
    width, height : float
        Inches.
    by_hand : bool
        The caller places all axes. Default: matplotlib's constrained layout.
    """
    import matplotlib.style
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure as Canvas

    fonts.add_family()
    look = resources.files("oitbench.report") / "look.mplstyle"
    with resources.as_file(look) as path, matplotlib.style.context(path):
        figure = Canvas(
            figsize=(width, height),
            dpi=DOTS_PER_INCH,
            layout=None if by_hand else "constrained",
        )
        FigureCanvasAgg(figure)
        yield figure


def grid(
    figure: Canvas,
    down: int,
    across: int,
    margins: Margins,
    *,
    share: bool = False,
) -> list[Axes]:
    """Return the axes of a grid, row by row, in a figure that is laid out by hand.

    To measure all texts of many axes takes matplotlib as long as to draw them.

    Parameters
    ----------
    figure : Figure
        From `canvas(…, by_hand=True)`.
    down, across : int
        Rows and columns.
    margins : Margins
    share : bool
        Whether all share both axes.
    """
    width, height = figure.get_size_inches()
    wide = (width - margins.left - margins.right - (across - 1) * margins.columns) / across
    high = (height - margins.top - margins.bottom - (down - 1) * margins.rows) / down
    axes = figure.subplots(
        down,
        across,
        sharex=share,
        sharey=share,
        squeeze=False,
        gridspec_kw={
            "left": margins.left / width,
            "right": 1 - margins.right / width,
            "bottom": margins.bottom / height,
            "top": 1 - margins.top / height,
            "wspace": margins.columns / wide,
            "hspace": margins.rows / high,
        },
    )
    return list(axes.flat)


def save(figure: Canvas, path: Path, *, title: str, caption: str) -> Figure:
    """Write a figure to `path` with the suffixes .png and .pdf, and return it for the page."""
    from pypdfium2 import PdfDocument

    path.parent.mkdir(parents=True, exist_ok=True)
    png, pdf = path.with_name(path.name + ".png"), path.with_name(path.name + ".pdf")
    _write_plain_powers(figure)
    engine = figure.get_layout_engine()
    if engine is not None:
        # With an engine, or the word "none", matplotlib draws the figure twice.
        engine.execute(figure)
        figure.set_layout_engine(None)
    # A file with a date would differ between runs with equal results.
    figure.savefig(pdf, metadata={"CreationDate": None})
    with PdfDocument(pdf) as document:
        # A tenth of the time that matplotlib takes to draw the same pixels. Pictures in the PDF
        # have the resolution of the PNG already, and must not be blurred once more.
        page = document[0].render(scale=figure.dpi / _POINTS_PER_INCH, no_smoothimage=True)
        page.to_pil().save(png, compress_level=_COMPRESSION)
    width = round(figure.get_figwidth() * _CSS_PIXELS_PER_INCH)
    return Figure(title, caption, png, pdf, width)


def _write_plain_powers(figure: Canvas) -> None:
    """Write the numbers of logarithmic axes as text: the formulas of matplotlib are not parsed."""
    from matplotlib.ticker import LogFormatterMathtext

    for axes in figure.axes:
        for axis in (axes.xaxis, axes.yaxis):
            if isinstance(axis.get_major_formatter(), LogFormatterMathtext):
                axis.set_major_formatter("{x:g}")
            if isinstance(axis.get_minor_formatter(), LogFormatterMathtext):
                axis.set_minor_formatter("")


def share_rows(panels: Sequence[Axes], across: int) -> None:
    """Give the panels of each row of a grid, `across` panels wide, one vertical scale."""
    for first in range(0, len(panels), across):
        row = panels[first : first + across]
        ends = [axes.get_ylim() for axes in row]
        for axes in row:
            axes.set_ylim(min(low for low, _ in ends), max(high for _, high in ends))


def truth_mark(truth: str) -> dict[str, Any]:
    """Return the look of the mark of a truth, as matplotlib names it."""
    marker, fill, size = _TRUTHS[truth]
    return {
        "marker": marker,
        "color": INK,
        "markerfacecolor": fill,
        "markersize": size,
        "markeredgewidth": 1.5 if marker == "|" else 0.9,
        "linestyle": "none",
    }


def add_mark(
    axes: Axes,
    point: tuple[float, float],
    interval: tuple[float, float] | None,
    *,
    marker: str,
    size: float,
    color: str,
    fill: str,
    edge: str,
    edge_width: float,
) -> None:
    """Draw a marker, in data coordinates, with the interval of its x as an error bar."""
    x, y = point
    axes.errorbar(
        x,
        y,
        xerr=None if interval is None else [[x - interval[0]], [interval[1] - x]],
        marker=marker,
        markersize=size,
        color=color,
        markerfacecolor=fill,
        markeredgecolor=edge,
        markeredgewidth=edge_width,
        elinewidth=1,
        capsize=2,
        zorder=4,
    )


def add_band(axes: Axes, low: float, high: float, text: str, *, at_top: bool) -> None:
    """Shade the values from `low` to `high` of y, and explain it in a corner at the right."""
    axes.axhspan(low, high, color="#000000", alpha=0.07, linewidth=0)
    axes.annotate(
        text,
        (1, 1 if at_top else 0),
        xycoords="axes fraction",
        xytext=(-3, -3 if at_top else 3),
        textcoords="offset points",
        fontsize=7.5,
        color=QUIET,
        horizontalalignment="right",
        verticalalignment="top" if at_top else "bottom",
    )

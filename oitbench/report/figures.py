"""Figures of one look: restrained, legible at printed size, as PNG and PDF."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from importlib import resources
from pathlib import Path
from typing import TYPE_CHECKING

from oitbench.report.artifacts import Figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure as Canvas

DOTS_PER_INCH = 180
INK = "#222222"
QUIET = "#6b6b6b"
# Wider than printed, so that 9.4 inches fill the column.
_CSS_PIXELS_PER_INCH = 118


@contextmanager
def canvas(width: float, height: float, *, by_hand: bool = False) -> Iterator[Canvas]:
    """Yield an empty figure of that many inches; save it before the block ends.

    Parameters
    ----------
    width, height : float
        Inches.
    by_hand : bool
        The caller places all axes; without, they are laid out so that nothing is cut off.
    """
    import matplotlib.style
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure as Canvas

    look = resources.files("oitbench.report") / "look.mplstyle"
    with resources.as_file(look) as path, matplotlib.style.context(path):
        figure = Canvas(
            figsize=(width, height),
            dpi=DOTS_PER_INCH,
            layout=None if by_hand else "constrained",
        )
        FigureCanvasAgg(figure)
        yield figure


def save(figure: Canvas, path: Path, *, title: str, caption: str) -> Figure:
    """Write `path` with the suffixes .png and .pdf and return the figure for the page."""
    path.parent.mkdir(parents=True, exist_ok=True)
    png, pdf = path.with_name(path.name + ".png"), path.with_name(path.name + ".pdf")
    figure.draw_without_rendering()
    # One layout for both files, which also saves time.
    figure.set_layout_engine("none")
    figure.savefig(png)
    # Without a date, equal results give equal files.
    figure.savefig(pdf, metadata={"CreationDate": None})
    width = round(figure.get_figwidth() * _CSS_PIXELS_PER_INCH)
    return Figure(title, caption, png, pdf, width)


def quiet_axis(axes: Axes) -> None:
    """Remove what a category axis does not need: its line and tick marks."""
    axes.tick_params(axis="y", length=0)
    axes.spines["left"].set_visible(False)

"""Error of random methods over the number of frames whose mean is the image.

A curve joins cells that differ in `frames` alone. Independent frames divide the error by the root
of their number, a slope of −1/2 on these axes; the dotted lines have it. A curve that flattens has
a bias, which no number of frames removes. A grid of sub-pixels multiplies the samples of a pixel:
with `ssaa 2` the noise is half of that with `ssaa 1`. `oitbench run --preset noise` renders cells.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from oitbench import parameters
from oitbench.image import metrics
from oitbench.parameters import natural
from oitbench.report import (
    Artifact,
    Column,
    Note,
    ReportContext,
    columns,
    figures,
    palette,
    write_table,
)
from oitbench.report.palette import Style
from oitbench.results.schema import Record
from oitbench.truths import EXACT, TRUTHS

if TYPE_CHECKING:
    from matplotlib.axes import Axes

title = "Noise over frames"
order = 37

_FRAMES = "frames"
_ACROSS = 2
# Inches of the axes of one scene with their labels.
_WIDTH, _HEIGHT = 4.7, 4.2
_DECADE = 12
_LINES = ("-", "--", "-.", ":")


@dataclass(frozen=True)
class Curve:
    """Cells of one method by the number of frames, with sub-pixels of one grid.

    `method` is the label without `frames`.
    """

    method: str
    ssaa: int
    cells: Mapping[int, Record]

    @property
    def errors(self) -> dict[int, float]:
        """The RMSE of linear radiance by the number of frames."""
        found = {n: self.cells[n].metric(EXACT, metrics.RMSE) for n in sorted(self.cells)}
        return {n: error for n, error in found.items() if error}

    @property
    def slope(self) -> float:
        """The slope of the regression line of log error over log frames."""
        known = self.errors
        return float(np.polyfit(np.log([*known]), np.log([*known.values()]), 1)[0])


Place = tuple[str, tuple[int, int], str, str]
"""Scene with its view, size, effects and settings of shading: the cells of one plot."""


def build(context: ReportContext) -> list[Artifact]:
    """Draw one plot for each scene, and list all points."""
    plots = _plots(context.results.records)
    if not plots:
        return [
            Note("No method ran with two numbers of frames; 'oitbench run --preset noise' does.")
        ]
    return [_figure(context, plots), _table(context, plots)]


def _plots(records: Sequence[Record]) -> dict[Place, list[Curve]]:
    """Return the curves of at least two points with an error."""
    found: dict[Place, dict[tuple[str, int], dict[int, Record]]] = {}
    for record in records:
        frames = record.outcome.parameters.get(_FRAMES) if record.outcome else None
        if frames is not None:
            place = record.seen, record.size, record.effects, record.shading
            curves = found.setdefault(place, {})
            method = parameters.without(record.method, _FRAMES)
            curves.setdefault((method, record.ssaa), {})[int(frames)] = record
    plots = {
        place: [
            curve
            for key in sorted(curves, key=lambda key: (natural(key[0]), key[1]))
            for curve in [Curve(*key, curves[key])]
            if len(curve.errors) > 1
        ]
        for place, curves in found.items()
    }
    return {place: curves for place, curves in plots.items() if curves}


def _figure(context: ReportContext, plots: Mapping[Place, Sequence[Curve]]) -> Artifact:
    across = min(_ACROSS, len(plots))
    down = -(-len(plots) // across)
    methods = sorted({c.method for curves in plots.values() for c in curves}, key=natural)
    looks = palette.tinted(_family_style(context, method) for method in methods)
    styles = dict(zip(methods, looks, strict=True))
    with figures.canvas(_WIDTH * across, _HEIGHT * down) as figure:
        grid = list(figure.subplots(down, across, squeeze=False).flat)
        for axes in grid[len(plots) :]:
            axes.remove()
        for axes, (place, curves) in zip(grid, plots.items(), strict=False):
            _draw(axes, place, curves, styles)
        figures.share_rows(grid[: len(plots)], across)
        caption = (
            f"{metrics.RMSE} against {TRUTHS[EXACT]} over the number of frames. Each curve names "
            "the grid of sub-pixels of its cells, and its slope. Dotted: slope −1/2."
        )
        path = context.out / "over-time"
        return figures.save(figure, path, title="Error over frames", caption=caption)


def _family_style(context: ReportContext, method: str) -> Style:
    """Return the look of the family of a method; its label has no number of frames."""
    family = context.families.get(parameters.parse(method).name, "")
    return Style(*palette.family_look(family), "-")


def _draw(axes: Axes, place: Place, curves: Sequence[Curve], styles: Mapping[str, Style]) -> None:
    axes.grid(True, axis="both")
    axes.set_xscale("log", base=2)
    axes.set_yscale("log")
    grids = sorted({curve.ssaa for curve in curves})
    for curve in curves:
        known = curve.errors
        style = styles[curve.method]
        axes.plot(
            [*known],
            [*known.values()],
            color=style.color,
            linestyle=_LINES[grids.index(curve.ssaa) % len(_LINES)],
            marker=style.marker,
            markersize=5,
            markerfacecolor="none",
            linewidth=1.2,
            label=f"{curve.method}, ssaa {curve.ssaa}: {_signed(curve.slope)}",
        )
    # Expected lines of curves that hardly fall must not stretch the axis; a power of ten is on it.
    low, high = axes.get_ylim()
    axes.set_ylim(min(low, high / _DECADE), high)
    for curve in curves:
        known = curve.errors
        first = min(known)
        expected = [known[first] * math.sqrt(first / n) for n in known]
        axes.plot([*known], expected, color=figures.QUIET, linewidth=0.7, linestyle=":", zorder=1)
    axes.set_title(place[0])
    axes.set_xlabel("frames whose mean is the picture (logarithmic)")
    axes.set_ylabel(f"RMSE to {TRUTHS[EXACT]}, lower is better (logarithmic)")
    axes.legend(
        fontsize=6.5, frameon=False, ncols=2, loc="upper center", bbox_to_anchor=(0.45, -0.16)
    )


def _signed(slope: float) -> str:
    """Return a slope with two decimals and a true minus, and no sign of zero."""
    return f"{round(slope, 2) + 0.0:.2f}".replace("-", "−")


def _table(context: ReportContext, plots: Mapping[Place, Sequence[Curve]]) -> Artifact:
    heading = (
        columns.SCENE,
        columns.METHOD,
        Column("ssaa", "ssaa", help="sub-pixel grid of the picture"),
        Column("frames", "Frames"),
        Column(metrics.RMSE, "RMSE", decimals=5, help=f"{metrics.RMSE} against {TRUTHS[EXACT]}"),
        Column(context.flip, "FLIP", decimals=4, help=f"mean {context.flip}, likewise"),
        Column("slope", "Slope", decimals=3, help="of log RMSE over log frames, of the curve"),
    )
    rows = [
        (place[0], curve.cells[n].method, curve.ssaa, n, error,
         curve.cells[n].metric(EXACT, context.flip), curve.slope)
        for place, curves in plots.items()
        for curve in curves
        for n, error in curve.errors.items()
    ]  # fmt: skip
    caption = "The points of the figure above."
    return write_table(
        context.out / "over-time.csv", heading, rows, title="All points over frames",
        caption=caption, collapsed=True,
    )  # fmt: skip

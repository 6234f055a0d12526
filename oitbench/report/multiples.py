"""Errors over times or bytes for all scenes: small multiples with shared axes."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

from oitbench.image.ties import Errors
from oitbench.method.families import FAMILIES
from oitbench.report import error_axis, figures, fronts, palette
from oitbench.report.artifacts import Figure
from oitbench.results.schema import Record

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.lines import Line2D

_ACROSS = 5
# Inches: a pane, with its title above and the numbers below it; texts around all; a legend's line.
_HEIGHT = 1.72
_MARGINS = figures.Margins(left=0.69, right=0.04, top=0.34, bottom=0.44, columns=0.14, rows=0.42)
_LEGEND_LINE = 0.17
_LEGEND_COLUMNS = 4
_LEAST_VALUES = 3


@dataclass(frozen=True)
class Point:
    """A method in one scene: its family, its time or bytes, and its error."""

    method: str
    family: str
    cost: float
    errors: Errors

    @property
    def y(self) -> float:
        """The place on the axis of errors."""
        return error_axis.place(self.errors.error)


@dataclass(frozen=True)
class Pane:
    """One scene: its title, the name of its truth, its points, and sweeps of one parameter."""

    title: str
    truth: str
    points: tuple[Point, ...]
    sweeps: tuple[tuple[Point, ...], ...]


def sweeps(points: Iterable[tuple[Record, Point]]) -> tuple[tuple[Point, ...], ...]:
    """Return the points that differ in one numeric parameter alone, in the order of its values."""
    groups: dict[tuple[object, ...], dict[float, Point]] = {}
    for record, point in points:
        values = record.outcome.parameters if record.outcome else {}
        for key, value in values.items():
            if isinstance(value, (int, float)) and not isinstance(value, bool):
                rest = tuple(sorted((k, repr(v)) for k, v in values.items() if k != key))
                groups.setdefault((record.name, key, rest), {})[float(value)] = point
    return tuple(
        tuple(found[value] for value in sorted(found))
        for found in groups.values()
        if len(found) >= _LEAST_VALUES
    )


def draw(
    panes: Sequence[Pane], path: Path, *, x: str, metric: str, title: str, caption: str
) -> Figure:
    """Draw a pane for each scene.

    Parameters
    ----------
    panes : sequence of Pane
        At least one, each with at least one point.
    path : Path
        File without its suffix.
    x : str
        Label of the horizontal axis, with its unit.
    metric : str
        Name of the metric of errors for readers.
    title, caption : str
    """
    points = [point for pane in panes for point in pane.points]
    return small_multiples(
        [_drawing(pane) for pane in panes],
        [(point.cost, point.y) for point in points],
        _handles(points),
        path,
        x=x,
        metric=metric,
        title=title,
        caption=caption,
    )


def small_multiples(
    panes: Sequence[Callable[[Axes], None]],
    points: Sequence[tuple[float, float]],
    handles: Sequence[Line2D],
    path: Path,
    *,
    x: str,
    metric: str,
    title: str,
    caption: str,
) -> Figure:
    """Draw panes that share a logarithmic axis of x and the axis of errors.

    Parameters
    ----------
    panes : sequence of callable
        Each draws one pane.
    points : sequence of (float, float)
        All that must be inside of the axes.
    handles : sequence of Line2D
        Of the legend.
    path, x, metric, title, caption
        As in `draw`.
    """
    down = math.ceil(len(panes) / _ACROSS)
    across = math.ceil(len(panes) / down)
    legend = _LEGEND_LINE * math.ceil(len(handles) / _LEGEND_COLUMNS)
    margins = replace(_MARGINS, top=_MARGINS.top + legend)
    height = _HEIGHT * down + margins.top + margins.bottom - margins.rows
    with figures.canvas(figures.WIDTH, height, by_hand=True) as figure:
        grid = figures.grid(figure, down, across, margins, share=True)
        _set_scales(grid[0], points)
        for axes, draw_pane in zip(grid, panes, strict=False):
            axes.grid(True, axis="both", linewidth=0.4)
            axes.tick_params(labelsize=6.5)
            error_axis.draw_break(axes)
            draw_pane(axes)
        for place in range(len(panes), len(grid)):
            grid[place].set_visible(False)
            grid[place - across].xaxis.set_tick_params(labelbottom=True)
        figure.supxlabel(x, fontsize=8.5, y=0.06 / height)
        figure.supylabel(error_axis.label(metric), fontsize=8.5, x=0.06 / figures.WIDTH)
        figure.legend(
            handles=handles,
            loc="upper center",
            borderaxespad=0.3,
            ncols=_LEGEND_COLUMNS,
            fontsize=7.5,
        )
        return figures.save(figure, path, title=title, caption=caption)


def _set_scales(axes: Axes, points: Sequence[tuple[float, float]]) -> None:
    from matplotlib.ticker import LogLocator, NullLocator

    axes.set_xscale("log")
    xs = [x for x, _ in points]
    axes.set_xlim(min(xs) / 1.6, max(xs) * 1.6)
    axes.xaxis.set_major_locator(LogLocator(numticks=5))
    axes.xaxis.set_minor_locator(NullLocator())
    error_axis.set_scale(axes, max(y for _, y in points))


def _drawing(pane: Pane) -> Callable[[Axes], None]:
    return lambda axes: _draw_pane(axes, pane)


def _draw_pane(axes: Axes, pane: Pane) -> None:
    best = fronts.front(pane.points)
    xs, ys = [best[0].cost], [axes.get_ylim()[1]]
    for point in best:
        xs += [point.cost] * 2
        ys += [ys[-1], point.y]
    axes.plot(
        [*xs, axes.get_xlim()[1]], [*ys, ys[-1]], color=figures.QUIET, linewidth=0.9, zorder=1.5
    )
    for curve in pane.sweeps:
        color, _ = palette.family_look(curve[0].family)
        axes.plot(
            [p.cost for p in curve], [p.y for p in curve], color=color, linewidth=0.9, zorder=2
        )
    groups: dict[tuple[str, bool], list[Point]] = {}
    for point in pane.points:
        groups.setdefault((point.family, point in best), []).append(point)
    for (family, front), points in groups.items():
        color, marker = palette.family_look(family)
        axes.plot(
            [point.cost for point in points],
            [point.y for point in points],
            marker=marker,
            markersize=6 if marker == "*" else 4.2,
            color=color,
            markeredgecolor="white",
            markeredgewidth=0.4,
            linestyle="none",
            zorder=4 if front else 3,
        )
    axes.set_title(f"{pane.title}\n{pane.truth}", fontsize=7, pad=3)


def _handles(points: Iterable[Point]) -> list[Line2D]:
    from matplotlib.lines import Line2D

    used = {point.family for point in points}
    handles = []
    for family, words in FAMILIES.items():
        if family in used:
            color, marker = palette.family_look(family)
            handles.append(
                Line2D([], [], color=color, marker=marker, linestyle="none", label=words)
            )
    return [*handles, Line2D([], [], color=figures.QUIET, linewidth=0.9, label="Pareto front")]

"""Error over the value of one numeric parameter, of a scene, a method or the shared shading.

A curve joins cells that differ in that parameter alone; it needs three values. The truth is the one
that ranks methods under the effects of the cells; for settings of shading, which exact compositing
shares, it is matched tracing. A dotted line marks the default. `python -m tests.benchmarks.sweeps`
runs the sweeps of the near plane, of shadow maps and of phenomenological transparency.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from oitbench import parameters
from oitbench.errors import OitbenchError
from oitbench.method.ablation import REQUESTED
from oitbench.parameters import AnyParameter, natural
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
from oitbench.report.artifacts import Row
from oitbench.results.ranking import largest_noise_floor
from oitbench.results.schema import Record
from oitbench.shading import PARAMETERS as SHADING
from oitbench.truths import MATCHED, TRUTHS
from oitbench.views import seen

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from oitbench.plugins import Collection

title = "Sweeps of parameters"
order = 36

_LEAST_VALUES = 3
_ACROSS = 3
# Inches of the axes of one sweep with their labels.
_WIDTH, _HEIGHT = 3.13, 2.7
_MARGINS = figures.Margins(left=0.78, right=0.08, top=0.3, bottom=0.58, columns=0.82, rows=0.86)
# Values whose largest is at least that many times the smallest have a logarithmic axis.
_WIDE = 8
# Numbers that have room below an axis.
_MOST_TICKS = 6
# Height of the axes, relative to the largest error.
_ROOM = 1.15


@dataclass(frozen=True)
class Axis:
    """The parameter that a sweep varies: of a scene, a method or the shading, by its name."""

    owner: str
    key: str


@dataclass(frozen=True)
class Curve:
    """Cells that differ in one parameter alone, with its values, in ascending order.

    `labels` are those of the cells by owner, without that parameter.
    """

    axis: Axis
    labels: Mapping[str, str]
    values: tuple[float, ...]
    cells: tuple[Record, ...]
    default: float | None

    @property
    def truth(self) -> str:
        """The truth that ranks methods; for shading, which exact compositing shares, `MATCHED`."""
        return MATCHED if self.axis.owner == "shading" else self.cells[0].ranking_truth

    @property
    def text(self) -> str:
        """The method, and the settings of shading that are not the defaults, in several lines."""
        shading = self.labels["shading"]
        text = self.labels["method"] + ("" if shading == "shading" else f"\n{shading}")
        return text.replace("[", "\n[")

    def errors(self, metric: str) -> list[float]:
        """Return the error of each cell; NaN if it has none."""
        found = (cell.metric(self.truth, metric) for cell in self.cells)
        return [math.nan if error is None else error for error in found]


def build(context: ReportContext) -> list[Artifact]:
    """Draw a figure for each parameter that is swept, and list all points."""
    from oitbench.plugins import Collection

    found = _curves(context.results.records, Collection.load())
    curves = [curve for curve in found if any(map(math.isfinite, curve.errors(context.flip)))]
    if not curves:
        return [
            Note(
                "No parameter has three values in cells that are otherwise equal; a selector such"
                " as 'NAME[param=1,2,3]' of 'oitbench run' adds them."
            )
        ]
    axes = dict.fromkeys(curve.axis for curve in curves)
    drawn = [_figure(context, axis, [c for c in curves if c.axis == axis]) for axis in axes]
    return [*drawn, _table(context, curves)]


def _labels(record: Record) -> dict[str, str]:
    """Return the labels of a cell by the owners of their parameters."""
    shading = f"shading[{record.shading}]" if record.shading else "shading"
    return {"scene": record.scene, "method": record.method, "shading": shading}


def _curves(records: Sequence[Record], collection: Collection) -> list[Curve]:
    """Return all curves, by scene and method."""
    finished = [record for record in records if record.finished]
    keys = _keys({pair for record in finished for pair in _labels(record).items()})
    groups: dict[tuple[Axis, tuple[object, ...]], dict[float, Record]] = {}
    others: dict[tuple[Axis, tuple[object, ...]], tuple[dict[str, str], float | None]] = {}
    for record in finished:
        labels = _labels(record)
        for owner, label in labels.items():
            selected = parameters.parse(label)
            known = _parameters(collection, owner, selected.name)
            for key in keys[owner, selected.name]:
                default = _number(known[key].default) if key in known else None
                given = selected.grid.get(key)
                value = _number(given[0]) if given else default
                if value is not None:
                    rest = labels | {owner: parameters.without(label, key)}
                    place = (*rest.values(), record.view, record.size, record.ssaa, record.effects)
                    group = Axis(owner, key), place
                    groups.setdefault(group, {})[value] = record
                    others[group] = rest, default
    curves = []
    for (axis, place), cells in groups.items():
        rest, default = others[axis, place]
        if len(cells) >= _LEAST_VALUES:
            values = tuple(sorted(cells))
            ordered = tuple(cells[value] for value in values)
            curves.append(Curve(axis, rest, values, ordered, default))
    return sorted(curves, key=lambda curve: [natural(label) for label in curve.labels.values()])


def _keys(labels: set[tuple[str, str]]) -> dict[tuple[str, str], list[str]]:
    """Return the parameters that any label states, by its owner and the name in it."""
    found: dict[tuple[str, str], list[str]] = {}
    for owner, label in sorted(labels):
        selected = parameters.parse(label)
        known = found.setdefault((owner, selected.name), [])
        known += [key for key in selected.grid if key not in known]
    return found


def _parameters(collection: Collection, owner: str, name: str) -> Mapping[str, AnyParameter]:
    if owner == "shading":
        return SHADING
    try:
        plugins = collection.scenes if owner == "scene" else collection.methods
        return plugins[name].parameters
    except OitbenchError:
        return {}  # of another collection, or gone


def _number(value: object) -> float | None:
    """Return a number, or the number that a text holds; None if it is no number."""
    try:
        return None if isinstance(value, bool) else float(str(value))
    except ValueError:
        return None


def _figure(context: ReportContext, axis: Axis, curves: Sequence[Curve]) -> Artifact:
    """Draw one plot for each scene, size and set of effects."""
    plots: dict[tuple[object, ...], list[Curve]] = {}
    for curve in curves:
        cell = curve.cells[0]
        plot = seen(curve.labels["scene"], cell.view), cell.size, cell.ssaa, cell.effects
        plots.setdefault(plot, []).append(curve)
    across = min(_ACROSS, len(plots))
    down = -(-len(plots) // across)
    size = _WIDTH * across, _HEIGHT * down
    with figures.canvas(*size, by_hand=True) as figure:
        grid = figures.grid(figure, down, across, _MARGINS)
        for axes in grid[len(plots) :]:
            axes.remove()
        for axes, shown in zip(grid, plots.values(), strict=False):
            _draw(axes, context, axis, shown)
        figures.share_rows(grid[: len(plots)], across)
        caption = (
            f"Mean {context.flip_name} over {axis.key} of the {axis.owner}, against the truth that "
            "is named at each axis. Dotted: the default. Shaded: errors that differ from the "
            "lowest one by no more than the noise floor."
        )
        path = context.out / f"sweep-{axis.owner}-{axis.key}"
        return figures.save(figure, path, title=f"{axis.key} of the {axis.owner}", caption=caption)


def _draw(axes: Axes, context: ReportContext, axis: Axis, curves: Sequence[Curve]) -> None:
    axes.grid(True, axis="both")
    values = [value for curve in curves for value in curve.values]
    if min(values) > 0 and max(values) >= _WIDE * min(values):
        axes.set_xscale("log")
    _set_ticks(axes, sorted(set(values)))
    styles = palette.tinted(context.style(curve.cells[0].method) for curve in curves)
    for curve, style in zip(curves, styles, strict=True):
        axes.plot(
            curve.values,
            curve.errors(context.flip),
            color=style.color,
            linestyle=style.line,
            marker=style.marker,
            markersize=4,
            linewidth=1.2,
            label=curve.text,
        )
    default, first = curves[0].default, curves[0]
    if default is not None:
        axes.axvline(default, color=figures.QUIET, linewidth=0.9, linestyle=":")
    errors = [error for curve in curves for error in curve.errors(context.flip)]
    known = [error for error in errors if math.isfinite(error)]
    floor = largest_noise_floor(first.cells, first.truth, context.flip)
    if floor:
        figures.add_band(axes, min(known), min(known) + floor, "ties", at_top=True)
    axes.set_ylim(0, _ROOM * max(known) or 1)
    effects = first.cells[0].effects
    axes.set_title(seen(first.labels["scene"], first.cells[0].view))
    axes.set_xlabel(axis.key if effects == REQUESTED else f"{axis.key}\neffects {effects}")
    axes.set_ylabel(f"{context.flip_name} error to {TRUTHS[first.truth]}\n(lower is better)")
    axes.legend(fontsize=6, frameon=False)


def _table(context: ReportContext, curves: Sequence[Curve]) -> Artifact:
    heading = (
        Column("parameter", "Parameter", kind="text"),
        columns.SCENE,
        columns.METHOD,
        Column("effects", "Effects", kind="text"),
        Column("shading", "Shading", kind="text", help="settings of shared shading"),
        Column("truth", "Truth", kind="text"),
        Column("value", "Value"),
        Column(context.flip, "FLIP", decimals=4, help=f"mean {context.flip} against the truth"),
    )
    return write_table(
        context.out / "sweeps.csv",
        heading,
        [row for curve in curves for row in _rows(context, curve)],
        title="All points of the sweeps",
        caption=f"Mean {context.flip_name} of the curves above.",
        collapsed=True,
    )


def _rows(context: ReportContext, curve: Curve) -> Iterator[Row]:
    errors = curve.errors(context.flip)
    for value, cell, error in zip(curve.values, curve.cells, errors, strict=True):
        yield (
            curve.axis.key, cell.seen, cell.method, cell.effects, cell.shading,
            TRUTHS[curve.truth], value, None if math.isnan(error) else error,
        )  # fmt: skip


def _set_ticks(axes: Axes, values: Sequence[float]) -> None:
    """Mark the values that were run, if their numbers have room."""
    from matplotlib.ticker import NullLocator

    spread = axes.xaxis.get_transform().transform(np.array(values))
    gaps = np.diff(spread)
    if len(values) <= _MOST_TICKS and gaps.min() >= gaps.sum() / _MOST_TICKS:
        axes.set_xticks(values, [f"{value:g}" for value in values])
        axes.xaxis.set_minor_locator(NullLocator())

"""Lists, curves and blending at equal bytes per pixel: where the lines of their errors cross.

Lists keep k nodes per pixel: fragments, or steps of a visibility curve at their depths. Curves
keep absorbance over depth in a fixed number of terms. Blending keeps sums, which more bytes make no
better, so it appears in every group. A group has the methods whose bytes per pixel are those of a
list, within a fifth; bytes come from the records.

Lists are exact for few layers, and curves are smooth where many are thin: the number of layers and
their opacity decide which is better. The figures need random stacks over numbers of layers and
coverage, with several seeds; `python -m tests.benchmarks.crossover` runs them, five kinds of
stacks, and real scenes. Pixels of stacks are independent, so their error is the RMSE of linear
radiance; FLIP would filter them like a picture. The truth is exact compositing. A scene lies at its
mean number of transparent fragments at covered pixels, and at the opacity of as many equal layers
that transmit as much light.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from oitbench import parameters
from oitbench.image import metrics
from oitbench.report import (
    Artifact,
    Column,
    Note,
    ReportContext,
    columns,
    crossings,
    decimal,
    families,
    figures,
    labels,
    palette,
    write_table,
)
from oitbench.report.artifacts import Row
from oitbench.report.crossings import Grid, Sweep
from oitbench.report.families import ByteGroup, Case
from oitbench.scene import Floats

if TYPE_CHECKING:
    from matplotlib.axes import Axes

title = "Lists, curves and blending"
order = 15

LISTS, CURVES, BLENDING = "lists", "curves", "blending"
FAMILIES = {
    "k_buffer": LISTS,
    "multilayer_alpha": LISTS,
    "multilayer_alpha_buckets": LISTS,
    "hybrid": LISTS,
    "adaptive": LISTS,
    "opacity_map": CURVES,
    "fourier_map": CURVES,
    "moments": CURVES,
    "wavelet": CURVES,
    "weighted_sum": BLENDING,
    "weighted_average": BLENDING,
    "weighted_blended": BLENDING,
    "phenomenological": BLENDING,
}
"""Family of each method that is compared."""
_LOOK = {LISTS: ("#0072B2", "s"), CURVES: ("#D55E00", "o"), BLENDING: ("#6b6b6b", "^")}
"""Color and marker of each family."""
_PALE = 0.85
"""Share of white in the areas of a map."""
_FINE = 200
"""Places along each axis of a map."""


@dataclass(frozen=True)
class Comparison:
    """The byte groups, the methods of each family by label, and all pictures."""

    groups: list[ByteGroup]
    members: dict[str, list[str]]
    blending: str
    cases: list[Case]
    grid: Grid | None

    @property
    def scenes(self) -> list[Case]:
        """Pictures beside the grid."""
        rows = self.grid.rows if self.grid else ()
        return [case for case in self.cases if case.row not in rows]

    def of(self, group: ByteGroup, family: str) -> list[str]:
        """Return the methods of a family in a group; blending belongs to all groups."""
        methods = self.members[family]
        return methods if family == BLENDING else [m for m in methods if m in group.bytes]

    def winner(self, case: Case, group: ByteGroup, by_flip: bool = False) -> str:
        """Return the better of lists and curves in a picture; empty if it lacks one of them."""
        errors = case.flip if by_flip else case.rmse
        best = {f: families.lowest(errors, self.of(group, f)) for f in (LISTS, CURVES)}
        known = {family: errors[method] for family, method in best.items() if method is not None}
        return min(known, key=known.__getitem__) if len(known) == len(best) else ""


def build(context: ReportContext) -> list[Artifact]:
    """Draw the errors and a map for each group, and list crossings and scenes."""
    found = compare(context)
    if not found.groups or not found.cases:
        return [
            Note(
                "No list and no curve have equal bytes per pixel in the same picture; 'python -m"
                " tests.benchmarks.crossover' runs some."
            )
        ]
    drawn: list[Artifact] = []
    if found.grid is not None:
        drawn.append(_errors(context, found, found.grid))
        drawn += [_map(context, found, found.grid, group) for group in found.groups]
        drawn.append(_crossings(context, found, found.grid))
    return [*drawn, _scenes(context, found)]


def compare(context: ReportContext) -> Comparison:
    """Sort the methods of the results by family and by bytes."""
    results = context.results
    names = {record.method: record.name for record in results.records}
    members = {
        family: [m for m in results.methods if FAMILIES.get(names[m]) == family] for family in _LOOK
    }
    sizes = families.bytes_of(results)
    blending = [size for method in members[BLENDING] for size in sizes.get(method, ())]
    cases = families.cases(results, context.flip)
    return Comparison(
        families.byte_groups(results, members[LISTS], members[CURVES]),
        members,
        f"{BLENDING}, {families.bytes_text(blending)}" if blending else BLENDING,
        cases,
        crossings.grid_of(case for case in cases if case.stack),
    )


def _sweeps(found: Comparison, grid: Grid, group: ByteGroup) -> Iterator[Sweep]:
    first, second = (grid.errors(found.of(group, family)) for family in (LISTS, CURVES))
    return crossings.sweeps(grid, first, second)


def _shown(found: Comparison, grid: Grid, by_layers: bool) -> int:
    """Return the row, or the number of layers, in which most groups have a crossing."""
    sweeps = [s for g in found.groups for s in _sweeps(found, grid, g) if s.by_layers == by_layers]
    places = len(grid.opacities if by_layers else grid.layers)

    def merit(place: int) -> tuple[int, float]:
        crossed = sum(sweep.crosses for sweep in sweeps if sweep.at == place)
        return crossed, -abs(place - (places - 1) / 2)

    return max(range(places), key=merit)


def _errors(context: ReportContext, found: Comparison, grid: Grid) -> Artifact:
    """Draw a row of two panels for each group: error over layers, and over opacity."""
    kinds = (True, False) if len(grid.opacities) > 1 else (True,)
    shown = {kind: _shown(found, grid, kind) for kind in kinds}
    with figures.canvas(figures.WIDTH, 0.4 + 2.4 * len(found.groups)) as figure:
        panels = figure.subplots(len(found.groups), len(kinds), squeeze=False, sharey=True)
        for row, group in zip(panels, found.groups, strict=True):
            sweeps = {(s.by_layers, s.at): s for s in _sweeps(found, grid, group)}
            for axes, kind in zip(row, kinds, strict=True):
                _draw_sweep(axes, found, grid, group, sweeps[kind, shown[kind]])
            row[0].set_ylabel("RMSE of radiance")
            row[0].set_title(group.title)
        figure.legend(*panels[0][0].get_legend_handles_labels(), loc="outside upper right", ncols=3)
        caption = (
            f"{metrics.RMSE} of random stacks against exact compositing, mean over {grid.seeds} "
            "seeds. Thick: the best method of each family at each place; thin: each method. "
            f"Errors below {crossings.UNSEEN:g}, which no display shows, are drawn there. Dotted: "
            "where lists and curves cross."
        )
        path = context.out / "crossover-errors"
        return figures.save(
            figure, path, title="Error over layers and over opacity", caption=caption
        )


def _draw_sweep(axes: Axes, found: Comparison, grid: Grid, group: ByteGroup, sweep: Sweep) -> None:
    from matplotlib.ticker import NullLocator

    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.grid(True, axis="both")

    def line(methods: Sequence[str]) -> Floats:
        return np.maximum(sweep.along(grid.errors(methods)), crossings.UNSEEN)

    for family, (color, marker) in _LOOK.items():
        methods = found.of(group, family)
        for method in methods:
            axes.plot(sweep.x, line([method]), color=color, linewidth=0.6, alpha=0.45)
        label = found.blending if family == BLENDING else family
        axes.plot(
            sweep.x, line(methods), color=color, marker=marker, markersize=4.5, linewidth=1.9,
            label=label,
        )  # fmt: skip
    if sweep.crosses:
        axes.axvline(sweep.middle, color=figures.INK, linewidth=0.9, linestyle=":")
        axes.annotate(
            decimal(sweep.middle, 2),
            (sweep.middle, 1),
            xycoords=("data", "axes fraction"),
            xytext=(3, 0),
            textcoords="offset points",
            fontsize=7.5,
            verticalalignment="top",
        )
    axes.set_xticks(sweep.x, [f"{x:.2g}" for x in sweep.x])
    axes.xaxis.set_minor_locator(NullLocator())
    axes.yaxis.set_major_formatter("{x:g}")
    axes.yaxis.set_minor_locator(NullLocator())
    if sweep.by_layers:
        axes.set_xlabel(f"layers at a pixel, each of opacity {sweep.fixed:.2g}")
    else:
        axes.set_xlabel(f"opacity of each of {sweep.fixed:g} layers at a pixel")


def _map(context: ReportContext, found: Comparison, grid: Grid, group: ByteGroup) -> Artifact:
    """Draw which family is better over layers and opacity, with all scenes."""
    with figures.canvas(figures.WIDTH, 4.6) as figure:
        axes = figure.subplots()
        axes.set_xscale("log")
        axes.set_yscale("log")
        if len(grid.opacities) > 1:
            _shade(axes, found, grid, group)
        written = []
        for case in found.scenes:
            winner = found.winner(case, group)
            if winner:
                color, marker = _LOOK[winner]
                fill = "white" if case.stack else color
                place = case.layers, case.opacity
                axes.plot(*place, color=color, marker=marker, markersize=6, markerfacecolor=fill)
                written.append(
                    labels.Label(*place, _short(case), figures.INK, case.layers, case.layers)
                )
        axes.margins(0.08)
        for axis in (axes.xaxis, axes.yaxis):
            axis.set_major_formatter("{x:g}")
        axes.set_xlabel("mean number of layers at a covered pixel")
        axes.set_ylabel("opacity of a layer")
        lists, curves = (
            axes.plot([], [], color=color, marker=marker, linestyle="none", label=f"{name} win")[0]
            for name, (color, marker) in _LOOK.items()
            if name != BLENDING
        )
        figure.legend(handles=[lists, curves], loc="outside upper right", ncols=2)
        labels.place(axes, written)
        caption = (
            "The family of lower RMSE. Areas: random stacks, interpolated between those of the "
            "grid. Marks: real scenes (filled) and other random stacks (open)."
        )
        path = context.out / f"crossover-map-{max(group.bytes.values()):.0f}"
        return figures.save(
            figure, path, title=f"Which family wins at {group.title}", caption=caption
        )


def _shade(axes: Axes, found: Comparison, grid: Grid, group: ByteGroup) -> None:
    """Color the plane by the family of lower error, and draw the border between both."""
    first, second = (grid.errors(found.of(group, family)) for family in (LISTS, CURVES))
    ahead = crossings.lead(first, second).mean(axis=-1)
    x, y = np.log(grid.layers), np.log(grid.opacities)
    fine_x, fine_y = (np.linspace(end[0], end[-1], _FINE) for end in (x, y))
    across = np.array([np.interp(fine_x, x, row) for row in ahead])
    plane = np.array([np.interp(fine_y, y, column) for column in across.T]).T
    limit = np.abs(plane).max() + 1
    shades = [palette.mix(_LOOK[family][0], "#ffffff", _PALE) for family in (LISTS, CURVES)]
    place = np.exp(fine_x), np.exp(fine_y)
    axes.contourf(*place, plane, levels=[-limit, 0, limit], colors=shades)
    axes.contour(*place, plane, levels=[0], colors=figures.INK, linewidths=1)


def _short(case: Case) -> str:
    """Return the label of a real scene; a stack by its family, layers and coverage."""
    if not case.stack:
        return case.scene
    given = parameters.parse(case.scene).grid
    kind = given.get("family", ("even",))[0]
    return f"{kind}, {case.layers:g} of {case.opacity:.2g}"


def _crossings(context: ReportContext, found: Comparison, grid: Grid) -> Artifact:
    heading = (
        Column("bytes", "Group", kind="text"),
        Column("opacity", "Opacity", digits=2, help="of a layer, where it stays the same"),
        Column("layers", "Layers", help="at a pixel, where they stay the same"),
        Column("curves", "Curves are better", kind="text"),
        Column("crossing", "Crossing", help="median over seeds"),
        Column("crossing_low", "Low", help="least over seeds"),
        Column("crossing_high", "High", help="greatest over seeds"),
    )
    rows: list[Row] = []
    for group in found.groups:
        for sweep in _sweeps(found, grid, group):
            fixed = (sweep.fixed, None) if sweep.by_layers else (None, sweep.fixed)
            ends = sweep.middle, min(sweep.crossings), max(sweep.crossings)
            known = [end if 0 < end < math.inf else None for end in ends]
            rows.append((group.title, *fixed, _verdict(sweep), *known))
    caption = (
        "Layers beyond which, and opacity below which, the best curve of a group stays better than "
        "its best list; interpolated between stacks."
    )
    return write_table(
        context.out / "crossover.csv", heading, rows, title="Crossings", caption=caption
    )


def _verdict(sweep: Sweep) -> str:
    """Return where curves are better in words."""
    if sweep.crosses:
        return ("beyond {} layers" if sweep.by_layers else "below {}").format(
            decimal(sweep.middle, 2)
        )
    everywhere = (sweep.middle == 0) == sweep.by_layers
    if everywhere:
        return "everywhere"
    return f"not at {sweep.x[-1]:g} layers" if sweep.by_layers else f"not at {sweep.x[0]:.2g}"


def _scenes(context: ReportContext, found: Comparison) -> Artifact:
    heading = [
        Column("bytes", "Group", kind="text"),
        columns.SCENE,
        Column("layers", "Layers", help="mean number at covered pixels"),
        Column("opacity", "Opacity", digits=2, help="of as many equal layers"),
    ]
    for family in _LOOK:
        heading += [
            Column(family, f"Best of {family}", kind="text"),
            Column(f"{family}.{metrics.RMSE}", "RMSE", decimals=4),
            Column(f"{family}.{context.flip}", "FLIP", decimals=4),
        ]
    heading += [
        Column("winner", "Lower RMSE", kind="text"),
        Column("winner_flip", "Lower FLIP", kind="text"),
    ]
    rows: list[Row] = []
    for group in found.groups:
        for case in found.scenes:
            best: list[str | float | None] = []
            for family in _LOOK:
                method = families.lowest(case.rmse, found.of(group, family))
                if method is None:
                    best += [None] * 3
                else:
                    best += [method, case.rmse[method], case.flip.get(method)]
            winners = found.winner(case, group), found.winner(case, group, by_flip=True)
            rows.append((group.title, case.scene, case.layers, case.opacity, *best, *winners))
    caption = (
        f"The method of lowest {metrics.RMSE} in each family, against exact compositing, and its "
        f"{context.flip}. The last columns compare the lowest errors of lists and curves."
    )
    path = context.out / "crossover-scenes.csv"
    return write_table(path, heading, rows, title="Scenes at equal bytes", caption=caption)

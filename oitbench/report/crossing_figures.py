"""Figures of families of methods: errors along sweeps, and maps of the family that wins."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np

from oitbench import parameters
from oitbench.image import metrics
from oitbench.report import crossings, figures, labels, palette
from oitbench.report.artifacts import Figure, decimal
from oitbench.report.context import ReportContext
from oitbench.report.crossings import Grid, Sweep
from oitbench.report.families import (
    BLENDING,
    CURVES,
    EQUAL,
    LISTS,
    UNSEEN,
    ByteGroup,
    Case,
    Comparison,
)
from oitbench.scene import Floats

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_LOOK = {family: palette.family_look(family) for family in (LISTS, CURVES, BLENDING)}
"""Color and marker of each family."""
_MARKS = {
    LISTS: (*_LOOK[LISTS], "lists win"),
    CURVES: (*_LOOK[CURVES], "curves win"),
    EQUAL: ("#6b6b6b", "v", "no visible error"),
}
"""Color, marker and legend of a winner."""
_PALE = 0.85
"""Share of white in the areas of a map."""
_ROOM = 1.4
"""Factor between the outermost marks of a map and its edges."""
_FINE = 200
"""Places along each axis of a map."""


def sweeps_of(found: Comparison, grid: Grid, group: ByteGroup) -> Iterator[Sweep]:
    """Yield the sweeps of lists against curves in a group."""
    first, second = (grid.errors(found.of(group, family)) for family in (LISTS, CURVES))
    return crossings.sweeps(grid, first, second)


def _shown(found: Comparison, grid: Grid, by_layers: bool) -> int:
    """Return the row, or the number of layers, in which most groups have a crossing."""
    sweeps = [
        s for g in found.groups for s in sweeps_of(found, grid, g) if s.by_layers == by_layers
    ]
    places = len(grid.opacities if by_layers else grid.layers)

    def merit(place: int) -> tuple[int, float]:
        crossed = sum(sweep.crosses for sweep in sweeps if sweep.at == place)
        return crossed, -abs(place - (places - 1) / 2)

    return max(range(places), key=merit)


def draw_errors(context: ReportContext, found: Comparison, grid: Grid) -> Figure:
    """Draw a row of two panels for each group: error over layers, and over opacity."""
    kinds = (True, False) if len(grid.opacities) > 1 else (True,)
    shown = {kind: _shown(found, grid, kind) for kind in kinds}
    with figures.canvas(figures.WIDTH, 0.4 + 2.4 * len(found.groups)) as figure:
        panels = figure.subplots(len(found.groups), len(kinds), squeeze=False, sharey=True)
        for row, group in zip(panels, found.groups, strict=True):
            sweeps = {(s.by_layers, s.at): s for s in sweeps_of(found, grid, group)}
            for axes, kind in zip(row, kinds, strict=True):
                _draw_sweep(axes, found, grid, group, sweeps[kind, shown[kind]])
            row[0].set_ylabel("RMSE of radiance, lower is better")
            row[0].set_title(group.title)
        figure.legend(*panels[0][0].get_legend_handles_labels(), loc="outside upper right", ncols=3)
        caption = (
            f"{metrics.RMSE} of random stacks against exact compositing, mean over {grid.seeds} "
            "seeds. Thick: the best method of each family at each place; thin: each method. "
            f"Errors below {UNSEEN:g}, which no display shows, are drawn there. Dotted: "
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
        return np.maximum(sweep.along(grid.errors(methods)), UNSEEN)

    for family, (color, marker) in _LOOK.items():
        methods = found.of(group, family)
        for method in methods:
            axes.plot(sweep.x, line([method]), color=color, linewidth=0.6, alpha=0.45)
        label = f"{family}, {found.blending}" if family == BLENDING else family
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
    axes.set_xticks(sweep.x, [f"{x:{'g' if sweep.by_layers else '.2g'}}" for x in sweep.x])
    axes.xaxis.set_minor_locator(NullLocator())
    axes.yaxis.set_minor_locator(NullLocator())
    if sweep.by_layers:
        axes.set_xlabel(f"layers at a pixel, each of opacity {sweep.fixed:.2g}")
    else:
        axes.set_xlabel(f"opacity of each of {sweep.fixed:g} layers at a pixel")


def draw_map(
    context: ReportContext,
    found: Comparison,
    grid: Grid,
    scenes: Sequence[Case],
    group: ByteGroup,
) -> Figure:
    """Draw which family is better over layers and opacity, with all scenes."""
    with figures.canvas(figures.WIDTH, 4.6) as figure:
        axes = figure.subplots()
        axes.set_xscale("log")
        axes.set_yscale("log")
        borders = _shade(axes, found, grid, group) if len(grid.opacities) > 1 else []
        written = []
        for case in scenes:
            winner = found.winner(case, group)
            if winner:
                color, marker, _ = _MARKS[winner]
                fill, edge = ("white", color) if case.stack else (color, "white")
                place = case.layers, case.opacity
                axes.plot(
                    *place,
                    marker=marker,
                    markersize=6.5,
                    markerfacecolor=fill,
                    markeredgecolor=edge,
                )
                written.append(
                    labels.Label(*place, _short(case), figures.INK, case.layers, case.layers)
                )
        _set_limits(axes, grid, scenes)
        axes.set_xlabel("mean number of layers at a covered pixel")
        axes.set_ylabel("opacity of a layer")
        handles = [
            axes.plot([], [], color=color, marker=marker, linestyle="none", label=text)[0]
            for color, marker, text in _MARKS.values()
        ]
        figure.legend(handles=handles, loc="outside upper right", ncols=len(handles))
        labels.place(axes, written, lines=borders)
        caption = (
            "The family of lower RMSE. Areas: random stacks, interpolated between those of the "
            "grid. Marks: real scenes (filled), and other random stacks (open) with their family, "
            "layers and opacity."
        )
        path = context.out / f"crossover-map-{max(group.bytes.values()):.0f}"
        return figures.save(
            figure, path, title=f"Which family wins at {group.title}", caption=caption
        )


def _set_limits(axes: Axes, grid: Grid, scenes: Sequence[Case]) -> None:
    """Show the grid and all scenes, with room for labels."""
    from matplotlib.ticker import LogLocator, NullLocator

    layers = [*grid.layers, *(case.layers for case in scenes)]
    opacities = [*grid.opacities, *(case.opacity for case in scenes)]
    axes.set_xlim(min(layers) / _ROOM, max(layers) * _ROOM)
    axes.set_ylim(min(opacities) / _ROOM, max(opacities) * _ROOM)
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_locator(LogLocator(subs=(1, 2, 5)))
        axis.set_minor_locator(NullLocator())


def _shade(
    axes: Axes, found: Comparison, grid: Grid, group: ByteGroup
) -> list[tuple[Sequence[float], Sequence[float]]]:
    """Color the plane by the family of lower error; return the border between both as (x, y)."""
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
    border = axes.contour(*place, plane, levels=[0], colors=figures.INK, linewidths=1)
    return [(line[:, 0].tolist(), line[:, 1].tolist()) for line in border.allsegs[0]]


def _short(case: Case) -> str:
    """Return the label of a real scene; a stack by its family, layers and coverage."""
    if not case.stack:
        return case.scene
    given = parameters.parse(case.scene).grid
    kind = given.get("family", ("even",))[0]
    return f"{kind}, {case.layers:g} × {case.opacity:.2g}"

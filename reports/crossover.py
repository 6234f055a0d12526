"""Where the errors of the three kinds cross at equal bytes per pixel.

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
from collections.abc import Sequence

from oitbench.image import metrics
from oitbench.report import (
    Artifact,
    Column,
    Note,
    ReportContext,
    columns,
    crossing_figures,
    crossings,
    decimal,
    families,
    write_table,
)
from oitbench.report.artifacts import Row
from oitbench.report.crossings import Grid, Sweep
from oitbench.report.families import BLENDING, CURVES, LISTS, Case, Comparison

title = "Lists, curves and blending"
order = 15

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


def build(context: ReportContext) -> list[Artifact]:
    """Draw the errors and a map for each group, and list crossings and scenes."""
    found = families.compare(context.results, FAMILIES, context.flip)
    if not found.groups or not found.cases:
        return [
            Note(
                "No list and no curve have equal bytes per pixel in the same picture; 'python -m"
                " tests.benchmarks.crossover' runs some."
            )
        ]
    swept = crossings.swept_rows(case for case in found.cases if case.stack)
    grid = crossings.grid_of(swept)
    scenes = [case for case in found.cases if case.row not in swept]
    drawn: list[Artifact] = []
    if grid is not None:
        drawn.append(crossing_figures.draw_errors(context, found, grid))
        drawn += [
            crossing_figures.draw_map(context, found, grid, scenes, group) for group in found.groups
        ]
        drawn.append(_crossings(context, found, grid))
    left = [row for row in swept if grid is None or row not in grid.rows]
    if left:
        drawn.append(Note(f"Stacks or methods are missing, so not shown: {'; '.join(left)}."))
    return [*drawn, _scenes(context, found, scenes), _methods(context, found)]


def _crossings(context: ReportContext, found: Comparison, grid: Grid) -> Artifact:
    heading = (
        Column("bytes", "Group", kind="text"),
        Column("opacity", "Opacity", digits=2, help="of a layer, where it stays the same"),
        Column("layers", "Layers", help="at a pixel, where they stay the same"),
        Column("curves", "Curves are better", kind="text"),
        Column("crossing", "Crossing", help="median over seeds"),
        Column("crossing_low", "Low", help="least over seeds"),
        Column("crossing_high", "High", help="greatest over seeds"),
        Column("best_list", "Best list", kind="text", help="at the stacks next to the crossing"),
        Column("best_curve", "Best curve", kind="text", help="at the same stacks"),
    )
    rows: list[Row] = []
    for group in found.groups:
        for sweep in crossing_figures.sweeps_of(found, grid, group):
            fixed = (sweep.fixed, None) if sweep.by_layers else (None, sweep.fixed)
            ends = sweep.middle, min(sweep.crossings), max(sweep.crossings)
            known = [end if 0 < end < math.inf else None for end in ends]
            best = [_best(grid, sweep, found.of(group, family)) for family in (LISTS, CURVES)]
            rows.append((group.title, *fixed, _verdict(sweep), *known, *best))
    caption = (
        "Layers beyond which, and opacity below which, the best curve of a group stays better than "
        "its best list; interpolated between stacks."
    )
    return write_table(
        context.out / "crossover.csv", heading, rows, title="Crossings", caption=caption
    )


def _best(grid: Grid, sweep: Sweep, methods: Sequence[str]) -> str:
    """Return the method of lowest error at the stacks next to the crossing."""
    return min(methods, key=lambda method: sweep.along(grid.errors([method]))[sweep.nearest])


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


def _scenes(context: ReportContext, found: Comparison, scenes: Sequence[Case]) -> Artifact:
    heading = [
        Column("bytes", "Group", kind="text"),
        columns.SCENE,
        Column("layers", "Layers", help="mean number at covered pixels"),
        Column("opacity", "Opacity", digits=2, help="of as many equal layers"),
    ]
    for family in families.FAMILIES:
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
        for case in scenes:
            best: list[str | float | None] = []
            for family in families.FAMILIES:
                method = families.lowest(case.rmse, found.of(group, family))
                if method is None:
                    best += [None] * 3
                else:
                    best += [method, case.rmse[method], case.flip.get(method)]
            winners = found.winner(case, group), found.winner(case, group, by_flip=True)
            rows.append((group.title, case.scene, case.layers, case.opacity, *best, *winners))
    caption = (
        f"The method of lowest {metrics.RMSE} in each family, against exact compositing, and its "
        f"{context.flip_name}. The last columns compare the lowest errors of lists and curves, "
        f"which are equal below {families.UNSEEN:g}."
    )
    path = context.out / "crossover-scenes.csv"
    return write_table(path, heading, rows, title="Scenes at equal bytes", caption=caption)


def _methods(context: ReportContext, found: Comparison) -> Artifact:
    heading = (
        Column("bytes", "Group", kind="text"),
        Column("family", "Family", kind="text"),
        columns.METHOD,
        Column("bytes_per_pixel", "Memory", "B/pixel"),
    )
    rows = [
        (group.title, family, method, group.bytes[method])
        for group in found.groups
        for family in (LISTS, CURVES)
        for method in found.of(group, family)
    ]
    path = context.out / "crossover-methods.csv"
    return write_table(
        path, heading, rows, title="Methods", caption="Bytes from the records.", collapsed=True
    )

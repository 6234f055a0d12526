"""What accuracy costs in time: frame time against FLIP, to both truths, one figure per scene.

The Pareto front joins the cells that no other one beats in both. Error bars are the bootstrap 95 %
interval of the median frame time. In the band above the best path-traced error, differences are
below the reference's own noise, so what lies there is tied.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING

from oitbench.report import (
    Artifact,
    Column,
    Figure,
    Note,
    Table,
    figures,
    labels,
    palette,
    write_table,
)
from oitbench.results import records as read
from oitbench.results.records import PATH_TRACED, TRUTHS, Panel, Results

if TYPE_CHECKING:
    from matplotlib.axes import Axes

title = "What accuracy costs in time"
order = 10

# Below the smallest error, the axis is linear down to zero, where exact methods lie.
_LEAST_ERROR = 1e-4
# Times within this factor get a tick at every digit.
_NARROW = 5
# The path tracer's curve may take this many times the slowest method's time on the axis.
_CURVE_ROOM = 12
_COLUMNS = (
    Column("scene", "Scene", kind="text"),
    Column("method", "Method", kind="method"),
    Column("truth", "Truth", kind="text"),
    Column("frame_ms", "Frame", "ms"),
    Column("frame_ms_low", "low", "ms"),
    Column("frame_ms_high", "high", "ms"),
    Column("flip", "FLIP", decimals=4),
    Column("pareto", "On the front", kind="text"),
)


def build(results: Results, out: Path) -> list[Artifact]:
    """Draw a figure per scene and list its points."""
    drawn: list[Artifact] = []
    rows: list[tuple[str | float | None, ...]] = []
    for panel in results.panels():
        truths = [truth for truth in TRUTHS if _points(panel, truth, results.flip)]
        if not truths:
            drawn.append(Note(f"{panel.title}: no cell has both a time and an error yet."))
            continue
        drawn.append(_figure(results, panel, truths, out))
        rows += [row for truth in truths for row in _rows(results, panel, truth)]
    if rows:
        drawn.append(_table(rows, out))
    return drawn or [Note("There is no cell yet.")]


def front(points: dict[str, tuple[float, float]]) -> list[str]:
    """Return the names of the (time, error) points that no other one beats, fastest first."""
    kept: list[str] = []
    lowest = float("inf")
    for name in sorted(points, key=lambda name: points[name]):
        if points[name][1] < lowest:
            lowest = points[name][1]
            kept.append(name)
    return kept


def _points(panel: Panel, truth: str, metric: str) -> dict[str, tuple[float, float]]:
    found = {}
    for cell in panel.finished:
        time, error = read.frame_time(cell), read.metric(cell, truth, metric)
        if time is not None and error is not None:
            found[cell["method"]] = (time[0], error)
    return found


def _figure(results: Results, panel: Panel, truths: list[str], out: Path) -> Figure:
    with figures.canvas(9.4, 0.5 + 4.3 * len(truths)) as figure:
        grid = figure.subplots(len(truths), 1, squeeze=False)
        for axes, truth in zip(grid[:, 0], truths, strict=True):
            _draw(axes, results, panel, truth)
        grid[-1, 0].set_xlabel("frame time, ms (logarithmic)")
        for axes, truth in zip(grid[:, 0], truths, strict=True):
            _write_labels(axes, results, panel, truth)
        left_out = [
            cell["method"]
            for cell in panel.cells
            if not any(cell["method"] in _points(panel, truth, results.flip) for truth in truths)
        ]
        return figures.save(
            figure,
            out / f"pareto-{panel.slug}",
            title=panel.title,
            caption=_caption(results, truths, left_out),
        )


def _draw(axes: Axes, results: Results, panel: Panel, truth: str) -> None:
    points = _points(panel, truth, results.flip)
    best = front(points)
    _scale(axes, points)
    axes.grid(True, axis="both")
    for cell in panel.finished:
        method = cell["method"]
        time = read.frame_time(cell)
        if method not in points or time is None:
            continue
        style = results.style(method)
        median, low, high = time
        axes.errorbar(
            median,
            points[method][1],
            xerr=[[median - low], [high - median]],
            color=style.color,
            marker=style.marker,
            markersize=7,
            markeredgecolor=figures.INK if method in best else "white",
            markeredgewidth=1.1 if method in best else 0.6,
            elinewidth=1,
            capsize=2,
            zorder=4,
        )
    if truth == PATH_TRACED:
        _draw_noise(axes, panel, results.flip, min(error for _, error in points.values()))
        _draw_path_tracing(axes, results, panel)
    axes.plot(*_front_line(axes, points), color=figures.QUIET, linewidth=1, zorder=1.5)
    axes.set_title(f"Error against {TRUTHS[truth]}")
    axes.set_ylabel(f"{results.flip} (lower is better)")


def _scale(axes: Axes, points: dict[str, tuple[float, float]]) -> None:
    """Set logarithmic axes; errors get a linear part down to zero if some are zero."""
    from matplotlib.ticker import LogLocator, NullLocator

    times = [time for time, _ in points.values()]
    axes.set_xscale("log")
    axes.set_xlim(min(times) / 1.4, max(times) * 1.9)
    narrow = max(times) < _NARROW * min(times)
    axes.xaxis.set_major_locator(LogLocator(subs=range(1, 10) if narrow else (1, 2, 5)))
    axes.xaxis.set_minor_locator(NullLocator())
    axes.xaxis.set_major_formatter("{x:g}")
    errors = [error for _, error in points.values()]
    positive = [error for error in errors if error > _LEAST_ERROR] or [10 * _LEAST_ERROR]
    if min(errors) > _LEAST_ERROR:
        axes.set_yscale("log")
        axes.set_ylim(min(positive) / 1.8, max(positive) * 1.8)
    else:
        linear = 10 ** math.floor(math.log10(min(positive)))
        axes.set_yscale("symlog", linthresh=linear, linscale=0.4)
        axes.set_ylim(-0.45 * linear, max(positive) * 1.8)
    ticks = _error_ticks(min(errors), max(positive), min(positive))
    axes.set_yticks(ticks, [f"{tick:g}" for tick in ticks])
    axes.yaxis.set_minor_locator(NullLocator())


def _error_ticks(lowest: float, highest: float, least_positive: float) -> list[float]:
    """Return round values from below the lowest to above the highest error, zero if it is met."""
    decades = range(math.floor(math.log10(least_positive)), math.ceil(math.log10(highest)) + 1)
    factors = (1, 2, 5) if len(decades) < 4 else (1, 3)
    ticks = [factor * 10.0**decade for decade in decades for factor in factors]
    kept = [tick for tick in ticks if least_positive / 2 <= tick <= 1.8 * highest]
    return kept if lowest > _LEAST_ERROR else [0.0, *kept]


def _front_line(
    axes: Axes, points: dict[str, tuple[float, float]]
) -> tuple[list[float], list[float]]:
    """Return the corners of the front: from the top to the fastest, right from the best.

    Between two cells it runs right at the worse error, which is what can be had by then.
    """
    best = front(points)
    xs, ys = [points[best[0]][0]], [axes.get_ylim()[1]]
    for name in best:
        time, error = points[name]
        xs += [time, time]
        ys += [ys[-1], error]
    return [*xs, axes.get_xlim()[1]], [*ys, ys[-1]]


def _draw_noise(axes: Axes, panel: Panel, metric: str, lowest: float) -> None:
    floors = [read.noise_floor(cell, metric) for cell in panel.finished]
    floor = max((value for value in floors if value is not None), default=None)
    if not floor:
        return
    axes.axhspan(lowest, lowest + floor, color="#000000", alpha=0.07, linewidth=0)
    axes.annotate(
        f"shaded: tied with the best, within the reference's noise of {floor:.2g}",
        (1, 1),
        xycoords="axes fraction",
        xytext=(-3, -3),
        textcoords="offset points",
        fontsize=7.5,
        color=figures.QUIET,
        horizontalalignment="right",
        verticalalignment="top",
    )


def _path_tracing(results: Results, panel: Panel) -> list[dict[str, float]]:
    curve = (results.facts.get("path_tracing") or {}).get(panel.scene) or []
    return [point for point in curve if point.get(results.flip)]


def _draw_path_tracing(axes: Axes, results: Results, panel: Panel) -> None:
    """Draw the path tracer's own error at growing sample counts, if the run measured it."""
    known = _path_tracing(results, panel)
    left, right = axes.get_xlim()
    limit = right * _CURVE_ROOM
    seen = [point for point in known if left < 1000 * point["seconds"] < limit]
    if len(known) < 2 or not seen:
        return
    bottom, top = axes.get_ylim()
    last = seen[-1]
    axes.set_xlim(left, max(right, 1.5 * 1000 * last["seconds"]))
    axes.set_ylim(min(bottom, last[results.flip] / 1.6), max(top, 1.2 * seen[0][results.flip]))
    axes.plot(
        [1000 * point["seconds"] for point in known],
        [point[results.flip] for point in known],
        color=palette.TRUTH_COLOR,
        linestyle=":",
        marker=".",
        linewidth=1.2,
    )
    for point in seen:
        axes.annotate(
            f"path tracing, {point['spp']} spp" if point is seen[0] else f"{point['spp']} spp",
            (1000 * point["seconds"], point[results.flip]),
            xytext=(5, 3),
            textcoords="offset points",
            fontsize=7,
            color=palette.TRUTH_COLOR,
        )


def _write_labels(axes: Axes, results: Results, panel: Panel, truth: str) -> None:
    points = _points(panel, truth, results.flip)
    best = front(points)
    cells = {cell["method"]: cell for cell in panel.finished}
    written = []
    for name in [*best, *(name for name in points if name not in best)]:
        time = read.frame_time(cells[name]) or (points[name][0],) * 3
        color = palette.ink(results.style(name).color)
        written.append(
            labels.Label(*points[name], name, color, time[1], time[2], bold=name in best)
        )
    lines = [_front_line(axes, points)]
    curve = _path_tracing(results, panel) if truth == PATH_TRACED else []
    if curve:
        milliseconds = [1000 * point["seconds"] for point in curve]
        lines.append((milliseconds, [point[results.flip] for point in curve]))
    labels.place(axes, written, lines=lines)


def _caption(results: Results, truths: list[str], left_out: list[str]) -> str:
    kind = "a software renderer, so times are CPU wall-clock times" if results.software else "GPU"
    parts = [
        f"Median frame time with 95 % interval on {results.renderer} ({kind}), against "
        f"{results.flip}; left and down is better.",
        "Grey line and bold names: the Pareto front.",
    ]
    if PATH_TRACED not in truths:
        parts.append("This scene has no path-traced truth.")
    if left_out:
        parts.append(f"Not shown, for want of a time or an error: {', '.join(left_out)}.")
    return " ".join(parts)


def _rows(results: Results, panel: Panel, truth: str) -> list[tuple[str | float | None, ...]]:
    points = _points(panel, truth, results.flip)
    best = front(points)
    rows: list[tuple[str | float | None, ...]] = []
    for cell in panel.finished:
        method, time = cell["method"], read.frame_time(cell)
        if method in points and time is not None:
            on_front = "yes" if method in best else ""
            error = points[method][1]
            rows.append((panel.title, method, TRUTHS[truth], *time, error, on_front))
    return rows


def _table(rows: list[tuple[str | float | None, ...]], out: Path) -> Table:
    return write_table(
        out / "pareto.csv",
        _COLUMNS,
        rows,
        title="All points",
        caption="The numbers behind the figures.",
        collapsed=True,
    )

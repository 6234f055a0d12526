"""Method time against FLIP error, one figure per scene.

One truth ranks the methods of a scene: exact compositing of the same fragments if all effects that
the scene requests are compositing or shared shading, else matched tracing, which has exactly the
light transport that the effects stand for. Where that truth is missing, errors against exact
compositing are shown as "compositing only", without a front. Method time is everything that a
method adds to a frame: the sort on the CPU with its upload, and all passes. Shadow maps, ambient
occlusion and the opaque picture are the same for all methods; they are timed apart, and the table
adds them up to the frame time. The gray line is the Pareto front: the methods for which no other
method is both faster and at least as accurate. Error bars are intervals that hold the true median
with at least 95 %. The caption names the methods that tie with the lowest error, where the truth
has noise.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from oitbench.report import (
    Artifact,
    Column,
    Figure,
    Note,
    ReportContext,
    columns,
    decimal,
    figures,
    fixed,
    labels,
    palette,
    plates,
    times,
    write_table,
)
from oitbench.report.artifacts import Row
from oitbench.results.ranking import ranking, truth_label
from oitbench.results.records import Panel
from oitbench.results.table import flat_times
from oitbench.results.times import Interval, Time
from oitbench.truths import EXACT, TRUTHS

if TYPE_CHECKING:
    from matplotlib.axes import Axes

title = "Accuracy against method time"
order = 10

# Below the smallest error, the axis is linear down to zero, the error of exact methods.
_LEAST_ERROR = 1e-4
# An axis whose times differ by less than this factor has a tick at every digit.
_NARROW = 5


@dataclass(frozen=True)
class Point:
    """Times and error of one method."""

    method: str
    times: Time
    error: float

    @property
    def time(self) -> Interval:
        """Method time in milliseconds."""
        return self.times.method_ms

    @property
    def place(self) -> tuple[float, float]:
        """Median method time in milliseconds, and error."""
        return self.time.median, self.error

    @property
    def label(self) -> str:
        """The method, with a sign if other processes disturbed its times."""
        return times.signed(self.method, self.times.block.disturbed)


def build(context: ReportContext) -> list[Artifact]:
    """Draw a figure per scene, and list its points."""
    drawn: list[Artifact] = []
    rows: list[Row] = []
    for panel in context.results.panels():
        truth = panel.truth
        points = _points(panel, truth, context.flip)
        if not points and truth != EXACT:
            truth = EXACT
            points = _points(panel, truth, context.flip)
        if not points:
            drawn.append(Note(f"{panel.title}: no method has both a time and an error yet."))
            continue
        drawn.append(_figure(context, panel, truth, points))
        rows += _rows(panel, truth, points)
    if rows:
        drawn.append(
            write_table(
                context.out / "pareto.csv",
                _columns(context.flip),
                rows,
                title="All points",
                caption=f"Times and mean {context.flip} of the figures above. Frame time is the "
                "median sum of method time and shading." + times.explain(context.results.records),
                collapsed=True,
            )
        )
    return drawn


def front(points: Iterable[Point]) -> list[Point]:
    """Return the Pareto front, fastest first."""
    kept: list[Point] = []
    for point in sorted(points, key=lambda point: point.place):
        if not kept or point.error < kept[-1].error:
            kept.append(point)
    return kept


def _points(panel: Panel, truth: str, metric: str) -> list[Point]:
    found = []
    for cell in panel.finished:
        error = cell.metric(truth, metric)
        if cell.time is not None and error is not None:
            found.append(Point(cell.method, cell.time, error))
    return found


def _figure(context: ReportContext, panel: Panel, truth: str, points: Sequence[Point]) -> Figure:
    best = front(points) if truth == panel.truth else []
    with figures.canvas(figures.WIDTH, 4.8) as figure:
        axes = figure.subplots()
        _draw(axes, context, points, best)
        axes.set_title(f"Truth: {truth_label(panel, truth)}")
        axes.set_xlabel(_axis_label(points))
        # Labels need the final layout.
        _add_labels(axes, context, points, best)
        return figures.save(
            figure,
            context.out / f"pareto-{panel.slug}",
            title=panel.title,
            caption=_caption(context, panel, truth, points),
        )


def _axis_label(points: Sequence[Point]) -> str:
    disturbed = any(point.times.block.disturbed for point in points)
    note = f"; {times.SHORT_EXPLANATION}" if disturbed else ""
    return f"method time, ms (logarithmic{note})"


def _draw(
    axes: Axes, context: ReportContext, points: Sequence[Point], best: Sequence[Point]
) -> None:
    _set_scales(axes, points)
    axes.grid(True, axis="both")
    for point in points:
        style = context.style(point.method)
        figures.add_mark(
            axes,
            point.place,
            point.time.ends,
            marker=style.marker,
            size=7,
            color=style.color,
            fill=style.color,
            edge=figures.INK if point in best else "white",
            edge_width=1.1 if point in best else 0.6,
        )
    if best:
        axes.plot(*_front_line(axes, best), color=figures.QUIET, linewidth=1, zorder=1.5)
    axes.set_ylabel(f"mean {context.flip} (lower is better)")


def _set_scales(axes: Axes, points: Sequence[Point]) -> None:
    """Set logarithmic axes; the axis of errors gets a linear part down to zero if needed."""
    from matplotlib.ticker import LogLocator, NullLocator

    medians = [point.time.median for point in points]
    axes.set_xscale("log")
    ends = [end for point in points for end in point.time.ends or ()]
    left = min([min(medians) / 1.4, *(end / 1.1 for end in ends)])
    axes.set_xlim(left, max([max(medians) * 1.9, *(end * 1.1 for end in ends)]))
    narrow = max(medians) < _NARROW * min(medians)
    axes.xaxis.set_major_locator(LogLocator(subs=range(1, 10) if narrow else (1, 2, 5)))
    axes.xaxis.set_minor_locator(NullLocator())
    axes.xaxis.set_major_formatter("{x:g}")
    errors = [point.error for point in points]
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
    """Return round values that enclose all errors; zero is one of them if an error is near zero."""
    decades = range(math.floor(math.log10(least_positive)), math.ceil(math.log10(highest)) + 1)
    factors = (1, 2, 5) if len(decades) < 4 else (1, 3)
    ticks = [factor * 10.0**decade for decade in decades for factor in factors]
    kept = [tick for tick in ticks if least_positive / 2 <= tick <= 1.8 * highest]
    return kept if lowest > _LEAST_ERROR else [0.0, *kept]


def _front_line(axes: Axes, best: Sequence[Point]) -> tuple[list[float], list[float]]:
    """Return the corners of the front as steps, from the top of the axes to their right edge.

    Between two points, the line stays at the error of the faster one, which is the lowest error
    that is possible in that time.
    """
    xs, ys = [best[0].time.median], [axes.get_ylim()[1]]
    for point in best:
        xs += [point.time.median] * 2
        ys += [ys[-1], point.error]
    return [*xs, axes.get_xlim()[1]], [*ys, ys[-1]]


def _add_labels(
    axes: Axes, context: ReportContext, points: Sequence[Point], best: Sequence[Point]
) -> None:
    # The first labels get the best places.
    ordered = [*best, *(point for point in points if point not in best)]
    written = [
        labels.Label(
            *point.place,
            point.label,
            palette.ink(context.style(point.method).color),
            *(point.time.ends or (point.time.median, point.time.median)),
            bold=point in best,
        )
        for point in ordered
    ]
    labels.place(axes, written, lines=[_front_line(axes, best)] if best else [])


def _caption(context: ReportContext, panel: Panel, truth: str, points: Sequence[Point]) -> str:
    results = context.results
    kind = "software renderer, wall-clock times of the CPU" if results.software else "GPU times"
    shown = {point.method for point in points}
    absent = [cell.method for cell in panel.cells if cell.method not in shown]
    parts = [
        f"Median method time in ms with its interval on {results.renderer} ({kind}) against "
        f"the mean of {context.flip}. Methods at the lower left are best.",
    ]
    if truth == panel.truth:
        parts.append("Gray line and bold names: the Pareto front.")
        found = ranking(panel, context.flip)
        if found.noise_floor:
            parts.append(f"Noise floor: {fixed(found.noise_floor, 4)}.")
        if len(found.best) > 1:
            parts.append(f"Tied with the lowest error: {', '.join(found.best)}.")
    else:
        reason = plates.why_no_truth(context, panel.finished, panel.truth)
        parts.append(
            f"Compositing only: {TRUTHS[panel.truth]}, which ranks this scene, is missing"
            f" ({reason})."
        )
    parts.append(_shading(points))
    if absent:
        parts.append(f"Not shown, without a time or an error: {', '.join(absent)}.")
    return " ".join(parts) + times.explain(panel.cells)


def _shading(points: Sequence[Point]) -> str:
    """Return a sentence about the time of shading, which all methods share."""
    medians = [point.times.shading_ms.median for point in points]
    low, high = (decimal(value) for value in (min(medians), max(medians)))
    several = low if low == high else f"{low} to {high}"
    return f"Shading that all methods share takes {several} ms more."


def _rows(panel: Panel, truth: str, points: Sequence[Point]) -> Iterator[Row]:
    best = front(points) if truth == panel.truth else []
    for point in points:
        values = times.marked(flat_times(point.times), point.times.block.disturbed)
        yield (
            panel.title,
            point.method,
            truth_label(panel, truth),
            *(values[column.key] for column in columns.TIMES),
            point.error,
            "yes" if point in best else "",
        )


def _columns(flip: str) -> tuple[Column, ...]:
    return (
        columns.SCENE,
        columns.METHOD,
        Column("truth", "Truth", kind="text"),
        *columns.TIMES,
        Column(flip, "FLIP", decimals=4, help=f"mean {flip} against the truth"),
        Column("pareto", "On the front", kind="text"),
    )

"""One figure per scene; lower left is best.

One truth ranks the methods of a scene: exact compositing of the same fragments if all effects that
the scene requests are compositing or shared shading, else matched tracing, which has exactly the
light transport that the effects stand for. Where that truth is missing, errors against exact
compositing are shown as "compositing only", without a front. Method time is everything that a
method adds to a frame: the sort on the CPU with its upload, and all passes. Shadow maps, ambient
occlusion and the opaque picture are the same for all methods; they are timed apart, and the table
adds them up to the frame time. The gray line is the Pareto front: a method is on it if its error is
clearly lower than that of each faster one, in spite of the noise of the truth. Error bars are
intervals that hold the true median with at least 95 %.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from oitbench.image.ties import Errors
from oitbench.report import (
    Artifact,
    Column,
    Figure,
    Note,
    ReportContext,
    columns,
    decimal,
    error_axis,
    figures,
    fixed,
    fronts,
    labels,
    palette,
    plates,
    times,
    write_table,
)
from oitbench.report.artifacts import Row
from oitbench.results.ranking import largest_noise_floor, ranking, truth_label
from oitbench.results.records import Panel
from oitbench.results.table import flat_times
from oitbench.results.times import Interval, Time
from oitbench.truths import EXACT, TRUTHS

if TYPE_CHECKING:
    from matplotlib.axes import Axes

title = "Accuracy against method time"
order = 10

# With more methods, only those of the front and the best of each family have their names.
_NAMED = 12
# An axis whose times differ by less than this factor has a tick at every digit.
_NARROW = 5


@dataclass(frozen=True)
class Point:
    """Times and errors of one method."""

    method: str
    times: Time
    errors: Errors

    @property
    def cost(self) -> float:
        """Median method time in milliseconds."""
        return self.time.median

    @property
    def time(self) -> Interval:
        """Method time in milliseconds."""
        return self.times.method_ms

    @property
    def place(self) -> tuple[float, float]:
        """Where the point is on the axes."""
        return self.cost, error_axis.place(self.errors.error)

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
                caption=f"Times and mean {context.flip_name} of the figures. Frame time is the "
                "median sum of method time and shading." + times.explain(context.results.records),
                collapsed=True,
            )
        )
    return drawn


def _points(panel: Panel, truth: str, metric: str) -> list[Point]:
    found = []
    for cell in panel.finished:
        errors = cell.errors(truth, metric)
        if cell.time is not None and errors is not None:
            found.append(Point(cell.method, cell.time, errors))
    return found


def _figure(context: ReportContext, panel: Panel, truth: str, points: Sequence[Point]) -> Figure:
    best = fronts.front(points) if truth == panel.truth else []
    with figures.canvas(figures.WIDTH, 4.8) as figure:
        axes = figure.subplots()
        _draw(axes, context, points, best)
        floor = largest_noise_floor(panel.finished, truth, context.flip)
        low, _ = axes.get_ylim()
        if floor and error_axis.place(floor) > low:
            figures.add_band(axes, low, error_axis.place(floor), "noise of the truth", at_top=False)
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
    axes.set_ylabel(error_axis.label(context.flip_name))


def _set_scales(axes: Axes, points: Sequence[Point]) -> None:
    """Set logarithmic axes; the smallest errors share a place below a break."""
    from matplotlib.ticker import LogLocator, NullLocator

    medians = [point.time.median for point in points]
    axes.set_xscale("log")
    ends = [end for point in points for end in point.time.ends or ()]
    left = min([min(medians) / 1.4, *(end / 1.1 for end in ends)])
    axes.set_xlim(left, max([max(medians) * 1.9, *(end * 1.1 for end in ends)]))
    narrow = max(medians) < _NARROW * min(medians)
    axes.xaxis.set_major_locator(LogLocator(subs=range(1, 10) if narrow else (1, 2, 5)))
    axes.xaxis.set_minor_locator(NullLocator())
    errors = [point.errors.error for point in points]
    if error_axis.set_scale(axes, max(errors), lowest=min(errors)):
        error_axis.draw_break(axes)


def _front_line(axes: Axes, best: Sequence[Point]) -> tuple[list[float], list[float]]:
    """Return the corners of the front as steps, from the top of the axes to their right edge.

    Between two points, the line stays at the error of the faster one, which is the lowest error
    that is possible in that time.
    """
    xs, ys = [best[0].time.median], [axes.get_ylim()[1]]
    for point in best:
        xs += [point.time.median] * 2
        ys += [ys[-1], point.place[1]]
    return [*xs, axes.get_xlim()[1]], [*ys, ys[-1]]


def _add_labels(
    axes: Axes, context: ReportContext, points: Sequence[Point], best: Sequence[Point]
) -> None:
    named = points if len(points) <= _NAMED else _best_of_families(context, points)
    # The first labels get the best places.
    ordered = [*best, *(point for point in named if point not in best)]
    written = [
        labels.Label(
            *point.place,
            point.label,
            palette.ink(context.style(point.method).color),
            *point.time.span,
            bold=point in best,
        )
        for point in ordered
    ]
    lines: list[tuple[Sequence[float], Sequence[float]]] = []
    if best:
        lines.append(_front_line(axes, best))
    # Labels keep away from the marks without names, too.
    lines += [(p.time.span, (p.place[1], p.place[1])) for p in points if p not in ordered]
    labels.place(axes, written, lines=lines)


def _best_of_families(context: ReportContext, points: Sequence[Point]) -> list[Point]:
    """Return the point of least error in each family."""
    families = {
        record.method: context.families.get(record.name) for record in context.results.records
    }
    best: dict[str | None, Point] = {}
    for point in sorted(points, key=lambda point: point.errors.error):
        best.setdefault(families[point.method], point)
    return [*best.values()]


def _caption(context: ReportContext, panel: Panel, truth: str, points: Sequence[Point]) -> str:
    results = context.results
    kind = "software renderer, wall-clock times of the CPU" if results.software else "GPU times"
    shown = {point.method for point in points}
    absent = [cell.method for cell in panel.cells if cell.method not in shown]
    parts = [
        f"Median method time in ms with its interval on {results.renderer} ({kind}) against "
        f"the mean of {context.flip_name}. Methods at the lower left are best.",
    ]
    if truth == panel.truth:
        parts.append("Gray line and bold names: the Pareto front.")
        if len(points) > _NAMED:
            parts.append("Other names: the least error of each family.")
        found = ranking(panel, context.flip)
        if found.noise_floor:
            parts.append(f"Noise floor: {fixed(found.noise_floor, 4)}.")
        if len(found.best) > 1:
            tied = found.best if len(found.best) <= _NAMED else [f"{len(found.best)} methods"]
            parts.append(f"Tied with the lowest error: {', '.join(tied)}.")
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
    best = fronts.front(points) if truth == panel.truth else []
    for point in points:
        values = times.marked(flat_times(point.times), point.times.block.disturbed)
        yield (
            panel.title,
            point.method,
            truth_label(panel, truth),
            *(values[column.key] for column in columns.TIMES),
            point.errors.error,
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

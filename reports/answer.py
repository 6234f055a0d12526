"""Which method to use for which content, and at what price.

The price is an error, FLIP of the displayed picture (0 is perfect; 0.01 is hard to see), and the
time that transparency adds to a frame.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from oitbench.parameters import natural
from oitbench.report import (
    Artifact,
    ReportContext,
    answers,
    error_axis,
    multiples,
    palette,
    times,
    tracing,
)
from oitbench.report.answers import Answer, Choice
from oitbench.report.artifacts import (
    Choices,
    Chosen,
    HeatTable,
    Shade,
    Statement,
    SubjectRow,
    write_csv,
)
from oitbench.report.multiples import Pane, Point
from oitbench.results.ranking import ranking
from oitbench.results.records import Panel
from oitbench.results.schema import Record
from oitbench.truths import TRUTHS

title = "The answer"
order = 1

_CRITERIA = (
    (
        f"Use: the fastest with an error within {answers.NEAR:g} of the least",
        f"of methods whose FLIP is at most {answers.NEAR:g} above the least",
    ),
    (
        f"Least error within {answers.CHEAP:g}× the least time",
        f"least error of methods that take at most {answers.CHEAP:g} times the time of the fastest",
    ),
    ("Least error, whatever the time", "of methods that tie, the fastest"),
    ("Least time, whatever the error", "of the method, which is a part of the frame"),
)
# Errors are shaded from white at the first to the darkest at the last, on a logarithmic scale.
_PALE, _DARK = 1e-3, 1.0
_DARKEST = "#8c2d04"


def build(context: ReportContext) -> list[Artifact]:
    """Answer in sentences and a table; draw errors over times and bytes; list all errors."""
    panels = [panel for panel in context.results.panels() if panel.finished]
    groups = answers.subjects(panels, context.flip)
    found = [answer for group in groups if (answer := group.answer) is not None]
    if not found:
        return []
    parts: list[Artifact] = [
        _choices(context, found),
        Statement(tuple(answers.sentences(found, panels, context.flip))),
    ]
    for name, axis, words in (
        ("time", "method time, ms (logarithmic)", "method time"),
        ("bytes", "bytes per pixel (logarithmic)", "memory of the method"),
    ):
        panes = [pane for panel in panels if (pane := _pane(context, panel, name)).points]
        if panes:
            parts.append(
                multiples.draw(
                    panes,
                    context.out / f"answer-{name}",
                    x=axis,
                    metric=context.flip_name,
                    title=f"Error over {words}, all scenes",
                    caption="All panes share both axes; lower left is best. Lines in color join "
                    "values of one parameter. The row at the bottom, below a dotted break of the "
                    f"axis, holds errors up to {error_axis.FLOOR:g}. The truth that ranks a scene "
                    "is below its name." + times.explain(context.results.records),
                )
            )
    traced = tracing.draw(context, panels)
    return [*parts, *([traced] if traced else []), _heat(context, panels)]


def _choices(context: ReportContext, found: Sequence[Answer]) -> Choices:
    path = context.out / "answer.csv"
    lines = [
        (answer.subject, criterion, price.method, price.error, price.ms, price.cost)
        for answer in found
        for (criterion, _), choice in zip(_CRITERIA, _chosen(answer), strict=True)
        if choice is not None
        for price in [choice.price]
    ]
    write_csv(path, ("subject", "criterion", "method", context.flip, "method_ms", "cost"), lines)
    # Without times, only one criterion chooses.
    places = [k for k in range(len(_CRITERIA)) if any(_chosen(answer)[k] for answer in found)]
    where = "a software renderer" if context.results.software else "this GPU"
    return Choices(
        "By content",
        f"Mean {context.flip_name} against the truth that ranks each scene (0 is perfect; a "
        f"difference of {answers.NEAR:g} is hard to see), geometric mean of the time that the "
        f"method adds to a frame on {where}, and its ratio to the least time in the last column. "
        "A method that lacks a number in one of the scenes where others have it is left out. Dots "
        "have the colors of families, as in the figures below."
        + times.explain(context.results.records),
        path,
        tuple(_CRITERIA[place] for place in places),
        tuple(
            SubjectRow(
                answer.subject,
                _remark(answer),
                answer.scenes,
                tuple(_shown(answer, k) for k in places),
            )
            for answer in found
        ),
    )


def _remark(answer: Answer) -> str:
    count = len(answer.scenes)
    scenes = "1 scene" if count == 1 else f"mean of {count} scenes"
    return f"{scenes}, times of {answer.timed}" if 0 < answer.timed < count else scenes


def _chosen(answer: Answer) -> tuple[Choice | None, ...]:
    return answer.near, answer.cheap, answer.least, answer.fastest


def _shown(answer: Answer, place: int) -> Chosen | None:
    choice = _chosen(answer)[place]
    if choice is None:
        return None
    numbers = answers.described(choice, cost=choice is not answer.fastest)
    if place and answer.near is not None and choice.price == answer.near.price:
        numbers = "as recommended"
    return Chosen(choice.price.method, numbers, choice.equal)


def _pane(context: ReportContext, panel: Panel, axis: str) -> Pane:
    found: list[tuple[Record, Point]] = []
    for cell in panel.finished:
        errors, cost = cell.errors(panel.truth, context.flip), _cost(cell, axis)
        if errors is not None and cost and cell.outcome is not None:
            found.append((cell, Point(cell.method, cell.outcome.family, cost, errors)))
    points = tuple(point for _, point in found)
    return Pane(panel.title, TRUTHS[panel.truth], points, multiples.sweeps(found))


def _cost(cell: Record, axis: str) -> float | None:
    if axis == "time":
        return cell.time.method_ms.median if cell.time is not None else None
    return cell.outcome.memory.bits_per_pixel / 8 if cell.outcome is not None else None


def _heat(context: ReportContext, panels: Sequence[Panel]) -> HeatTable:
    methods = sorted({cell.method for panel in panels for cell in panel.finished}, key=natural)
    rows, lines = [], []
    for panel in panels:
        found = ranking(panel, context.flip)
        errors = [found.errors[m].error if m in found.errors else None for m in methods]
        best = found.best
        shades = tuple(_shade(e, m in best) for m, e in zip(methods, errors, strict=True))
        rows.append((panel.title, TRUTHS[panel.truth], shades))
        lines.append((panel.title, TRUTHS[panel.truth], *errors))
    path = context.out / "answer-errors.csv"
    write_csv(path, ("scene", "truth", *methods), lines)
    return HeatTable(
        "All errors",
        f"Mean {context.flip_name} against the truth that ranks each scene, ×1000. Frames mark the "
        "least error of a scene and all that tie with it within the noise of the reference.",
        path,
        tuple(methods),
        tuple(rows),
    )


def _shade(error: float | None, best: bool) -> Shade:
    if error is None:
        return Shade("–")
    place = math.log(max(error, _PALE) / _PALE) / math.log(_DARK / _PALE)
    color = palette.mix("#ffffff", _DARKEST, min(1.0, place))
    thousandths = f"{1000 * error:.1f}" if error < 0.1 else f"{1000 * error:.0f}"
    return Shade(thousandths, color, best)

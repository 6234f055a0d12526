"""Pictures of methods beside the traced ones, for the phenomena of transparency.

Only scenes appear that request more effects than coverage. Of methods that miss the same effects,
the one with the least error is shown. The maps show FLIP against matched tracing: it has exactly
the light transport that the effects stand for. Full path tracing has all of it, and is context.
"""

from __future__ import annotations

import math
import textwrap
from collections.abc import Iterable, Sequence

from oitbench.report import Artifact, Figure, Note, ReportContext, figures, plates
from oitbench.report.cells import effect_label, effect_labels, most_complete
from oitbench.report.error_maps import MapScale, scale_of
from oitbench.results.records import Panel
from oitbench.results.schema import Record
from oitbench.truths import MATCHED, TRACED, TRUTHS

title = "Phenomena"
order = 32

_COVERAGE, _DIFFUSION = "COVERAGE", "DIFFUSION"
# Inches: a picture as wide as the page, and the room for its label.
_WIDTH = 9.24
_LABEL = 0.24
_LETTERS = 26
"""Length of a line below a picture."""


def build(context: ReportContext) -> list[Artifact]:
    """Draw the plates of every scene that requests more than coverage."""
    drawn: list[Artifact] = []
    for panel in context.results.panels():
        if {name for cell in panel.finished for name in cell.requested_effects} - {_COVERAGE}:
            drawn += _plates(context, panel)
    return drawn or [Note("No finished cell requests an effect besides coverage.")]


def _plates(context: ReportContext, panel: Panel) -> list[Artifact]:
    drawn: list[Artifact] = [_methods(context, panel)]
    diffusing = [
        cell
        for cell in panel.finished
        if _DIFFUSION in cell.requested_effects and _DIFFUSION not in cell.missing_effects
    ]
    chosen = most_complete(diffusing, context.flip)
    if chosen is not None:
        drawn += _pair(context, panel, chosen)
    reduced = [item.complete for item in panel.ablations if item.complete.finished]
    chosen = most_complete(reduced, context.flip)
    if chosen is not None:
        drawn.append(_ablations(context, panel, chosen))
    return drawn


def _methods(context: ReportContext, panel: Panel) -> Artifact:
    """Return the plate of one method for each set of effects that methods miss."""
    folder = context.out / "phenomena" / panel.slug
    shown = [plates.show_truth(context, panel, truth, folder) for truth in TRACED]
    scale = scale_of(panel.finished, MATCHED, context.flip)
    for missing, cell in best_by_missing_effects(panel.finished, context.flip).items():
        text = f"misses {effect_labels(missing)}" if missing else "all effects"
        values = (*plates.error_text(context, cell, MATCHED), *textwrap.wrap(text, _LETTERS))
        shown.append(plates.show_cell(context, cell, MATCHED, folder, values=values, scale=scale))
    caption = (
        f"Effects that the scene requests: {effect_labels(panel.finished[0].requested_effects)}. "
        "Of methods that miss the same ones, the plate has the one with the least error. "
        f"{_reading(context, MATCHED, scale)}"
    )
    path = context.out / f"phenomena-{panel.slug}"
    return plates.grid(context, panel, shown, path, scale=scale, title=panel.title, caption=caption)


def best_by_missing_effects(cells: Iterable[Record], metric: str) -> dict[tuple[str, ...], Record]:
    """Return the cell with the least error against matched tracing for each set of missing effects.

    Parameters
    ----------
    cells : iterable of Record
        Of one scene.
    metric : str

    Returns
    -------
    dict of tuple of str to Record
        Small sets first.
    """
    best: dict[tuple[str, ...], tuple[float, Record]] = {}
    for cell in cells:
        error, missing = cell.metric(MATCHED, metric), tuple(cell.missing_effects)
        key = math.inf if error is None else error
        if missing not in best or key < best[missing][0]:
            best[missing] = key, cell
    return {missing: best[missing][1] for missing in sorted(best, key=lambda m: (len(m), m))}


def _ablations(context: ReportContext, panel: Panel, complete: Record) -> Artifact:
    """Return the plate of one method with effects left out."""
    folder = context.out / "phenomena" / f"{panel.slug}-ablation"
    shown = [plates.show_truth(context, panel, panel.truth, folder)]
    cells = {"all effects": (complete, panel.truth)}
    scale = scale_of([complete], panel.truth, context.flip)
    dependent: list[str] = []
    for ablation in panel.ablations:
        if ablation.complete is complete:
            named = effect_labels(ablation.named)
            cells[f"without {named}"] = (ablation.reduced, ablation.reduced.whole_truth)
            if ablation.implied:
                implied = _joined(ablation.implied)
                dependent.append(f"Leaving out {named} also leaves out {implied}.")
    for label, (cell, truth) in cells.items():
        values = plates.error_text(context, cell, truth, panel.truth)
        shown.append(
            plates.show_cell(context, cell, truth, folder, values=values, scale=scale, label=label)
        )
    caption = f"{complete.method} with effects left out. {_reading(context, panel.truth, scale)}"
    return plates.grid(
        context,
        panel,
        shown,
        context.out / f"phenomena-{panel.slug}-ablation",
        scale=scale,
        title=f"{panel.title}: effects left out",
        caption=" ".join([caption, *dependent]),
    )


def _reading(context: ReportContext, truth: str, scale: MapScale) -> str:
    """Return the part of a caption that explains maps and numbers."""
    return (
        f"Lower picture: map of {context.flip_name} against {TRUTHS[truth]}, {scale.words}. "
        f"Number: mean {context.flip_name}."
    )


def _joined(names: Sequence[str]) -> str:
    return " and ".join(map(effect_label, names))


def _pair(context: ReportContext, panel: Panel, cell: Record) -> list[Figure]:
    """Return the large matched picture above that of a method that expresses diffusion."""
    truth = plates.first_image(context, panel, MATCHED)
    image = context.results.image(cell, "color")
    if truth is None or image is None:
        return []
    stops = plates.exposure([cell])
    error = plates.error_text(context, cell, MATCHED)
    rows = ((TRUTHS[MATCHED], truth), (", ".join([cell.method, *error]), image))
    width, height = plates.fitted(panel.size, _WIDTH)
    whole = 2 * plates.MARGIN + _WIDTH, 3 * plates.MARGIN + 2 * (_LABEL + height)
    with figures.canvas(*whole, by_hand=True) as canvas:
        top = plates.MARGIN
        for label, picture in rows:
            plates.write(canvas, label, plates.MARGIN, top + _LABEL - 0.07, 10, bold=True)
            shown = plates.display(picture, stops)
            plates.draw_picture(canvas, shown, plates.MARGIN, top + _LABEL, width)
            top += _LABEL + height + plates.MARGIN
        figure = figures.save(
            canvas,
            context.out / f"phenomena-{panel.slug}-diffusion",
            title=f"{panel.title}: diffusion",
            caption=f"Upper picture: matched tracing. Lower picture: {cell.method}, which misses "
            "the fewest effects of all methods that express diffusion. Number: mean "
            f"{context.flip_name} against it.",
        )
    return [figure]

"""An answer as rows of tables, and in types that JSON can hold."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import asdict
from typing import Any

from oitbench.choosing.choice import Candidate, Choice, SceneChoice
from oitbench.method import demand_table
from oitbench.results.times import SIGN
from oitbench.truths import EXACT, TRUTHS

HEADINGS = ("scene", "ranked by", "method", "FLIP", "loss", "FLIP to exact", "method time")
MEAN_HEADINGS = ("method", "mean FLIP", "mean loss", "largest loss")
TIE = "≈"
"""Sign of a time whose interval holds the limit."""
_NONE = "–"


def mean_rows(choice: Choice) -> list[tuple[str, ...]]:
    """Return the methods that fit in all scenes; a star marks the best and its ties."""
    return [
        (
            f"{mean.method} *" if mean.method in choice.chosen else mean.method,
            *(f"{value:.4f}" for value in (mean.error, mean.loss, mean.worst)),
        )
        for mean in choice.means
    ]


def scene_rows(choice: Choice) -> Iterator[tuple[str, ...]]:
    """Yield the methods that fit, scene by scene; a star marks the best and its ties."""
    for scene in choice.scenes:
        fitting = [item for item in scene.candidates if item.fits]
        for place, item in enumerate(fitting):
            name = item.cell.method
            yield (
                "" if place else scene.title,
                "" if place else scene.truth,
                f"{name} *" if name in scene.chosen else name,
                _error(item.errors.error if item.errors else None),
                _loss(item),
                _error(item.error(EXACT)),
                _time(choice, item),
            )


def misfit_rows(choice: Choice) -> Iterator[tuple[str, str]]:
    """Yield the methods that do not fit, with reasons, and the scenes of reasons of only some."""
    for method, reasons in choice.misfits().items():
        texts = [
            reason if len(scenes) == len(choice.scenes) else f"{reason} ({', '.join(scenes)})"
            for reason, scenes in reasons.items()
        ]
        yield method, "; ".join(texts)


def aligned(rows: Sequence[Sequence[str]]) -> str:
    """Return rows as text in columns; hundreds of rows would take rich a second."""
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    padded = (
        "  ".join(text.ljust(width) for text, width in zip(row, widths, strict=True))
        for row in rows
    )
    return "\n".join(f"  {line}".rstrip() for line in padded)


def legend(rows: Iterable[tuple[str, ...]]) -> list[str]:
    """Return what the signs of the times in rows of `scene_rows` mean, one line each."""
    times = [row[-1] for row in rows]
    meaning = {
        SIGN: "disturbed by other processes",
        TIE: "does not clearly differ from the limit of time",
    }
    return [
        f"{sign} {text}"
        for sign, text in meaning.items()
        if any(time.endswith(sign) for time in times)
    ]


def unscored(choice: Choice) -> list[str]:
    """Return one line for each scene in which methods that fit have no error."""
    lines = []
    for scene in choice.scenes:
        missing = [item for item in scene.candidates if item.fits and item.errors is None]
        if missing:
            names = ", ".join(item.cell.method for item in missing)
            reasons = {_why(scene, item) for item in missing} - {""}
            why = f" ({', '.join(sorted(reasons))})" if reasons else ""
            lines.append(f"{scene.title}: no error against {TRUTHS[scene.truth]} of {names}{why}")
    return lines


def facts(choice: Choice) -> dict[str, Any]:
    """Return the whole answer for programs."""
    return {
        "renderer": choice.renderer,
        "software": choice.software,
        "constraints": asdict(choice.constraints),
        "best": list(choice.chosen),
        "means": [asdict(mean) for mean in choice.means],
        "scenes": [
            {
                "scene": scene.title,
                "truth": scene.truth,
                "best": list(scene.best),
                "best_that_fits": list(scene.chosen),
                "methods": [_facts(choice, scene, item) for item in scene.candidates],
            }
            for scene in choice.scenes
        ],
    }


def _facts(choice: Choice, scene: SceneChoice, item: Candidate) -> dict[str, Any]:
    cell = item.cell
    time = cell.time
    demands = cell.outcome.demands if cell.outcome else None
    return {
        "method": cell.method,
        "fits": item.fits,
        "reasons": list(item.reasons),
        "flip": {truth: item.error(truth) for truth in TRUTHS},
        "loss": item.loss,
        "method_ms": time.method_ms.median if time else None,
        "time_disturbed": time.block.disturbed if time else None,
        "time_ties_with_limit": choice.constraints.ties(time),
        "missing_effects": cell.missing_effects,
        "demands": demand_table.facts(cell.method, demands) if demands else None,
    }


def _why(scene: SceneChoice, item: Candidate) -> str:
    scores = item.cell.outcome.scores.get(scene.truth) if item.cell.outcome else None
    return scores.reason if scores else ""


def _loss(item: Candidate) -> str:
    if item.loss is None:
        return _NONE
    return f"{item.loss:.4f}" if item.loss else "none"


def _error(value: float | None) -> str:
    return _NONE if value is None else f"{value:.4f}"


def _time(choice: Choice, item: Candidate) -> str:
    """Return the median, with a sign where it has a reservation; see `legend`."""
    time = item.cell.time
    if time is None:
        return _NONE
    sign = SIGN if time.block.disturbed else TIE if choice.constraints.ties(time) else ""
    return f"{time.method_ms.median:.3g} ms {sign}".rstrip()

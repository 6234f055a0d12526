"""How far each method is from each truth, and why.

Three things make a picture differ from the real one: the way in which layers are composited, the
approximation of effects such as shadow maps, and light that the shading model leaves out. Each has
a truth of its own. The figures show the FLIP error against each of them, and which part of the
squared error each one explains.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from oitbench.report import (
    Artifact,
    Column,
    ReportContext,
    columns,
    ladder_figure,
    ladder_words,
    write_table,
)
from oitbench.report.artifacts import Row
from oitbench.report.ladder import TERMS, Ladder
from oitbench.truths import FULL, MATCHED, TRUTHS

title = "The ladder of truths"
order = 12

_PERCENT = tuple(
    Column(f"{key}_percent", words.capitalize(), "%", decimals=1) for key, words in TERMS.items()
)


def build(context: ReportContext) -> list[Artifact]:
    """Say what each error consists of, draw it, and list all numbers."""
    ladders = [Ladder(context, panel) for panel in context.results.panels() if panel.finished]
    traced = [ladder for ladder in ladders if len(ladder.truths) > 1]
    if not traced:
        return []
    said = [(ladder.panel.title, text) for ladder in traced if (text := ladder_words.words(ladder))]
    drawn: list[Artifact] = [_said(context, said)] if said else []
    sheets = [
        traced[first : first + ladder_figure.SCENES]
        for first in range(0, len(traced), ladder_figure.SCENES)
    ]
    for number, sheet in enumerate(sheets, 1):
        words = ", ".join(ladder.panel.title for ladder in sheet)
        path = context.out / f"ladder-{number}"
        drawn.append(ladder_figure.draw(context, sheet, path, f"Distances to truths: {words}"))
    return [*drawn, _table(context, traced)]


def _said(context: ReportContext, rows: Sequence[Row]) -> Artifact:
    return write_table(
        context.out / "ladder-words.csv",
        (columns.SCENE, Column("words", "What the error consists of", kind="prose")),
        rows,
        title="In words",
        caption="Each sentence is on the method of least FLIP error against the truth that ranks "
        "the scene, and on the range over all methods. Squared errors are of linear radiance.",
    )


def _table(context: ReportContext, ladders: Sequence[Ladder]) -> Artifact:
    flip = context.flip
    heading = (
        columns.SCENE,
        columns.METHOD,
        *(
            Column(f"{truth}.{flip}", f"FLIP {truth}", decimals=4, help=f"against {words}")
            for truth, words in TRUTHS.items()
        ),
        columns.noise_floor(MATCHED, flip),
        columns.noise_floor(FULL, flip),
        Column("against", "Split against", kind="text", help="the truth of the squared error"),
        Column("mse", "Squared error", digits=2, help="linear radiance, without the noise"),
        Column("noise", "Noise", digits=2, help="variance of the truths, which was subtracted"),
        *_PERCENT,
        *(Column(f"{key}_mse", words.capitalize(), digits=2) for key, words in TERMS.items()),
    )
    return write_table(
        context.out / "ladder.csv",
        heading,
        [row for ladder in ladders for row in _rows(ladder)],
        title="All distances and parts",
        caption="Mean squared errors of linear radiance, averaged over pixels and channels, and "
        "their parts. Percentages are left out where the error is below half a step of 8 bits, or "
        "below the noise.",
        collapsed=True,
    )


def _rows(ladder: Ladder) -> Iterator[Row]:
    for cell in ladder.panel.finished:
        found = ladder.splits.get(cell.method)
        shares = found.shares if found else {}
        yield (
            ladder.panel.title,
            cell.method,
            *(ladder.distance(cell, truth) for truth in TRUTHS),
            ladder.floor(MATCHED),
            ladder.floor(FULL),
            TRUTHS[ladder.last] if found else None,
            found.total if found else None,
            found.noise if found else None,
            *(100 * shares[key] if shares else None for key in TERMS),
            *(found.parts[key] if found else None for key in TERMS),
        )

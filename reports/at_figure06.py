"""Three scenes by six methods, with the differences from the A-buffer times eight.

The paper has no differences of alpha blending. Each method has as many nodes, samples, slices or
coefficients as in the paper, and lists hold 12 bytes per fragment, of which 8 bits for each color.
"""

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

from oitbench.papers import (
    Album,
    Finding,
    Picture,
    Row,
    caption,
    nearer,
    needs_of,
    plate,
    read_paper,
)
from oitbench.report import Artifact, ReportContext
from oitbench.truths import EXACT

title = "Scenes by six methods"

PAPER = read_paper(Path(__file__).parent / "papers" / "at2011.toml")
METHODS = ("A-buffer", "AT", "ST", "OSMT", "FOMT", "alpha blending")
UNITS = {"nodes": "nodes", "samples": "samples", "slices": "slices", "coefficients": "terms"}
PICTURES = {
    scene: [PAPER.picture(scene, method, method) for method in METHODS]
    for scene in ("SMOKE", "HAIR", "FOREST")
}
FLOATS = PAPER.picture("SMOKE", "AT, floats")
needs = needs_of([*(picture for row in PICTURES.values() for picture in row), FLOATS])


def build(context: ReportContext) -> list[Artifact]:
    """Draw two rows for each scene."""
    album = Album(context, needs)
    rows: list[Row] = []
    for scene, pictures in PICTURES.items():
        labeled = [replace(picture, label=_heading(album, picture)) for picture in pictures]
        rows.append(Row(labeled, scene, score=EXACT))
        apart = [replace(picture, label="") for picture in pictures[1:]]
        rows.append(Row([None, *apart], against=pictures[0]))
    shown = f"FLIP is against exact compositing.{_floats(album)}"
    text = caption(album, shown, _findings(album))
    return [plate(album, rows, "at_figure06", title=title, caption=text)]


def _heading(album: Album, picture: Picture) -> str:
    outcome = album.outcome(picture)
    values = outcome.parameters if outcome else {}
    counts = [f"{values[name]} {unit}" for name, unit in UNITS.items() if name in values]
    return ", ".join([picture.label, *counts])


def _floats(album: Album) -> str:
    """Return the error of AT with floats in its lists, which is that of its curves alone."""
    error = album.error(FLOATS, EXACT)
    return "" if error is None else f" With floats in its lists, AT has {error:.4f} in SMOKE."


def _findings(album: Album) -> Iterator[Finding]:
    for scene, (_, adaptive, *others, _) in PICTURES.items():
        text = f"in {scene}, AT is nearer to the A-buffer than ST, OSMT and FOMT"
        yield nearer(album, adaptive, others, EXACT, text)
    baseline, fourier = PICTURES["SMOKE"][0], PICTURES["SMOKE"][4]
    light = [album.image(picture) for picture in (fourier, baseline)]
    text = "FOMT darkens SMOKE"
    if light[0] is None or light[1] is None:
        yield Finding(text, None)
        return
    ratio = float(light[0].mean() / light[1].mean())
    yield Finding(f"{text} (to {ratio:.0%} of the mean radiance)", ratio < 1)

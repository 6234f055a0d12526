"""Teapots behind panes of falling collimation, traced and by phenomenological transparency.

Light spreads over the distance between a pane and the background, so that a box which touches its
pane stays sharp. In the formats of the paper, the smallest blur is 3.95 pixels; half floats store
smaller ones.
"""

from collections.abc import Iterator

import numpy as np

from oitbench.papers import Album, Finding, Picture, Row, caption, nearer, needs_of, plate
from oitbench.report import Artifact, ReportContext
from oitbench.truths import MATCHED

title = "Teapots behind frosted panes"

OURS = Picture("frosted_panes", "phenomenological")
HALF = Picture("frosted_panes", "phenomenological[precision=half]")
TRACED = OURS.traced
COMPOSITED = Picture("frosted_panes", "a_buffer")
THINGS = {
    "the last teapot is blurred": ("nearest_lid", "farthest_lid", False),
    "the last box stays sharp": ("first_box", "last_box", True),
    "the second box stays sharp": ("first_box", "second_box", True),
}
"""Two parts whose contrasts are compared, and whether the second one should be as sharp."""
ROWS = (
    Row([TRACED.part("panes")], "traced"),
    Row([OURS.part("panes")], "phenomenological"),
    Row([HALF.part("panes")], "half floats"),
)
needs = needs_of((OURS, HALF, TRACED, COMPOSITED.traced))
_NAMED = {"traced": TRACED, "in the paper's formats": OURS, "in half floats": HALF}
BLURRED, SHARP = 0.5, 0.7
"""Largest part of its contrast that a blurred thing keeps, and least part that a sharp one does."""


def build(context: ReportContext) -> list[Artifact]:
    """Draw the panes three times, and measure the contrast of pots and boxes."""
    album = Album(context, needs)
    near = nearer(
        album, OURS, (COMPOSITED,), MATCHED,
        "phenomenological transparency is nearer to the traced picture than exact compositing",
    )  # fmt: skip
    shown = (
        "Contrast is the mean difference between neighboring pixels, relative to behind the first"
        " pane."
    )
    said = [near, *_findings(album)]
    return [plate(album, ROWS, "pt_figure08", title=title, caption=caption(album, shown, said))]


def _findings(album: Album) -> Iterator[Finding]:
    for name, picture in _NAMED.items():
        for thing, (first, second, sharp) in THINGS.items():
            kept = _kept(album, picture, (first, second))
            text = f"{name}, {thing}"
            if kept is None:
                yield Finding(text, None)
                continue
            holds = kept >= SHARP if sharp else kept <= BLURRED
            yield Finding(f"{text} ({kept:.0%} of its contrast)", holds)


def _kept(album: Album, picture: Picture, parts: tuple[str, str]) -> float | None:
    """Return the contrast of the second part relative to that of the first; None if unknown."""
    first, last = (album.shown(picture.part(part)) for part in parts)
    if first is None or last is None or min(first.shape[1], last.shape[1]) < 2:
        return None
    contrast = [np.abs(np.diff(image, axis=1)).mean() for image in (first, last)]
    return float(contrast[1] / max(contrast[0], 1e-6))

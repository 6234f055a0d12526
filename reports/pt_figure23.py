"""Glass in smoke, with the smoke accumulated for blocks of 4 × 4 pixels and for each pixel.

Glass keeps the resolution of the frame in both pictures, and a bilateral filter spreads the smoke
over the frame before both are resolved together. Below are the part with a frame, where glass,
smoke and opaque edges meet, and the accumulated light. In the paper's scene, blocks take 1.35 ms
and pixels 3.02 ms.
"""

from collections.abc import Iterator

from oitbench.papers import Album, Finding, Picture, Row, alike, caption, needs_of, plate
from oitbench.report import Artifact, ReportContext, decimal

title = "Glass and smoke at two resolutions"

BLOCKS = Picture(
    "smoke_and_glass", "phenomenological[subsample=4]", "Smoke in blocks of 4 × 4 pixels"
)
WHOLE = Picture("smoke_and_glass", "phenomenological", "Smoke at each pixel")
PAIR = (BLOCKS, WHOLE)
PARTS = [picture.part("edges") for picture in PAIR]
LIGHT = [Picture(picture.scene, picture.method, target="accumulated") for picture in PAIR]
ROWS = (Row(PAIR, marks=("edges",)), Row(PARTS), Row(LIGHT, "accumulated light"))
needs = needs_of(PAIR)
GEOMETRY = "gather"
"""First word of the names of passes over the geometry."""
BYTES, TIMES = 12, 2
"""Least ratios of blended bytes and of times that count as the paper's: "nearly" 16, and 2.2."""


def build(context: ReportContext) -> list[Artifact]:
    """Draw both resolutions, a part of each, and the light that they accumulate."""
    album = Album(context, needs)
    said = (
        alike(
            album, PARTS[0], PARTS[1], "glass, smoke and edges look the same at both resolutions"
        ),
        *_ratios(album),
    )
    text = caption(album, "Middle: the part with a frame.", said)
    return [plate(album, ROWS, "pt_figure23", title=title, caption=text)]


def _ratios(album: Album) -> Iterator[Finding]:
    """Compare what both resolutions cost."""
    blended = [_blended(album, picture) for picture in PAIR]
    yield _ratio("drawing the layers blends nearly 16 times fewer bytes in blocks", blended, BYTES)
    records = [album.record(picture) for picture in PAIR]
    times = [record.time.method_ms.median if record and record.time else 0 for record in records]
    yield _ratio(f"blocks are at least {TIMES} times as fast", times, TIMES)


def _blended(album: Album, picture: Picture) -> int:
    """Return the bytes that passes over the geometry blend in a frame; 0 if they are unknown."""
    outcome = album.outcome(picture)
    terms = outcome.traffic.terms if outcome else []
    blends = (term for term in terms if term.kind == "blend")
    return sum(term.bytes for term in blends if term.pass_.startswith(GEOMETRY))


def _ratio(text: str, pair: list[int] | list[float], least: float) -> Finding:
    blocks, whole = pair
    if not blocks or not whole:
        return Finding(text, None)
    return Finding(f"{text} ({decimal(whole / blocks)} times)", whole / blocks >= least)

"""Times of the stages of phenomenological transparency in eight scenes, beside those of the paper.

The paper has scenes of its own, 1920 × 1080 pixels, shadow maps of 4096 texels per side (here 1024)
that are filtered to a quarter, and a GeForce 980: compare how the stages of a scene relate, not
milliseconds. Stage 1 is shading that all methods share. Stage 2 accumulates layers and fog, in
blocks of 4 × 4 pixels where it says so. Stage 3 enlarges blocks, bends and blurs the background.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

from oitbench.papers import Album, Finding, Picture, caption, needs_of
from oitbench.report import Artifact, Column, Note, ReportContext, columns, times, write_table
from oitbench.report.artifacts import Row

title = "Times of the stages"


class Stages(NamedTuple):
    """Milliseconds: maps of shadows, filtering them, accumulation of layers, and resolve."""

    maps: float
    filters: float
    accumulation: float
    resolve: float


METHOD, BLOCKS = "phenomenological", "phenomenological[subsample=4]"
PUBLISHED = {
    ("Door", METHOD): ("frosted_door", Stages(0.01, 1.55, 0.04, 2.37)),
    ("Glasses", METHOD): ("tumblers", Stages(0.73, 4.65, 1.53, 0.09)),
    ("Foggy Night", METHOD): ("foggy_street", Stages(0.37, 1.55, 4.32, 4.02)),
    ("Foggy Night", BLOCKS): ("foggy_street", Stages(0.37, 1.55, 0.37, 5.01)),
    ("Chess", METHOD): ("chess", Stages(0.24, 4.65, 6.21, 0.09)),
    ("Engine", METHOD): ("engine", Stages(0.48, 1.55, 10.0, 0.07)),
    ("Hair", METHOD): ("hair", Stages(28.13, 1.55, 19.21, 0.06)),
    ("Car", METHOD): ("smoke_and_glass", Stages(0.68, 1.55, 2.91, 0.11)),
    ("Car", BLOCKS): ("smoke_and_glass", Stages(0.68, 1.55, 0.25, 1.10)),
    ("San Miguel", METHOD): ("courtyard", Stages(5.07, 1.55, 0.54, 0.09)),
}
"""Scenes and times of the paper, by its name of a scene and by the variant that ran."""
PICTURES = {
    key: Picture(scene, key[1], shading="translucent=published")
    for key, (scene, _) in PUBLISHED.items()
}
needs = needs_of(PICTURES.values())
GAIN = 10
"""Factor by which blocks speed accumulation up in the paper."""
_TITLES = {"maps": "Maps", "filters": "Filters", "accumulation": "OIT", "resolve": "Resolve"}
_COLUMNS = (
    Column("paper_scene", "Paper", kind="text"),
    columns.SCENE,
    Column("blocks", "Blocks", kind="text", help="of particles and fog"),
    *(
        column
        for key, heading in _TITLES.items()
        for column in (
            Column(f"{key}_ms", heading, "ms", help="median"),
            Column(f"paper_{key}", "Paper's", "ms", help=f"{heading.lower()}, of the paper"),
        )
    ),
    columns.DISTURBED,
)


def build(context: ReportContext) -> list[Artifact]:
    """Write one row for each scene of the paper and each size of blocks."""
    album = Album(context, needs)
    rows = list(_rows(album))
    if not rows:
        return [Note("The results have no timed cell of this table.")]
    records = filter(None, map(album.record, PICTURES.values()))
    text = caption(album, "Milliseconds beside those of the paper.", _findings(album))
    path = context.out / "pt_table1.csv"
    text += times.explain(records)
    return [write_table(path, _COLUMNS, rows, title="Stages", caption=text)]


def _rows(album: Album) -> Iterator[Row]:
    for (name, variant), picture in PICTURES.items():
        stages, record = _stages(album, picture), album.record(picture)
        if stages is None or record is None:
            continue
        published = PUBLISHED[name, variant][1]._asdict()
        values = {
            "paper_scene": name,
            "scene": record.seen,
            "blocks": "4 × 4" if variant == BLOCKS else "",
            **{f"paper_{key}": value for key, value in published.items()},
            **{f"{key}_ms": value for key, value in stages._asdict().items()},
        }
        shown = times.marked(values, times.is_disturbed(record))
        yield tuple(shown.get(column.key) for column in _COLUMNS)


def _stages(album: Album, picture: Picture) -> Stages | None:
    """Return the times of the stages of a cell; None if it has not been timed."""
    record = album.record(picture)
    if record is None or record.time is None:
        return None
    shading = {part.name: part.ms.median for part in record.time.shading}
    found = {"accumulation": 0.0, "resolve": 0.0}
    for part in record.time.passes:
        last = part.name.split()[0] in ("upsample", "resolve")
        found["resolve" if last else "accumulation"] += part.ms.median
    return Stages(shading.get("shadow maps", 0.0), shading.get("variance maps", 0.0), **found)


def _findings(album: Album) -> Iterator[Finding]:
    """Compare stages of one scene, whose relations should not depend on the machine."""
    stages = {key: _stages(album, picture) for key, picture in PICTURES.items()}
    for name in ("Foggy Night", "Car"):
        text = f"blocks speed OIT up by {GAIN} times and more in {name}"
        full, blocks = stages[name, METHOD], stages[name, BLOCKS]
        if full is None or blocks is None:
            yield Finding(text, None)
            continue
        gain = full.accumulation / max(blocks.accumulation, 1e-6)
        yield Finding(f"{text} ({gain:.1f})", gain >= GAIN)
    for longer, shorter in (("accumulation", "resolve"), ("resolve", "accumulation")):
        words = f"{_TITLES[longer]} takes longer than {_TITLES[shorter]} in"
        scenes: dict[bool | None, list[str]] = {}
        for (name, variant), (_, published) in PUBLISHED.items():
            if variant == BLOCKS or not _longer(published, longer, shorter):
                continue
            here = stages[name, variant]
            scenes.setdefault(here and _longer(here, longer, shorter), []).append(name)
        for holds, names in scenes.items():
            yield Finding(f"{words} {', '.join(names)}", holds)


def _longer(stages: Stages, stage: str, other: str) -> bool:
    return bool(getattr(stages, stage) > getattr(stages, other))

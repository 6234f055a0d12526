"""Targets of phenomenological transparency beside those of the paper.

Formats and clear values are what the method declares when all of its effects run. A target is left
out where a scene does not request its effect, so that no scene of this suite needs all bits.
"""

from collections.abc import Iterator, Mapping
from typing import NamedTuple

from oitbench.effects import Effect
from oitbench.method.declaration import Request, plan_of
from oitbench.method.storage import Target
from oitbench.papers import Album, Finding, Picture, caption, needs_of
from oitbench.report import Artifact, Column, Note, ReportContext, write_table

title = "Layout of the framebuffer"


class Published(NamedTuple):
    """A row of the paper's table."""

    place: str
    holds: str
    format: str
    bits: int
    clear: tuple[float, ...]


PUBLISHED = {
    "accum": Published("RT0", "A: light and opacity, weighted", "rgba16f", 64, (0, 0, 0, 0)),
    "beta": Published("RT1", "β and D² / 63²", "rgba8", 32, (1, 1, 1, 0)),
    "delta": Published("RT2", "δ / 63", "rg8_snorm", 16, (0, 0)),
}
METHOD = "phenomenological"
BITS = {
    Picture("engine", METHOD): ("coverage alone", 88),
    Picture("engine", "multilayer_alpha"): ("multi-layer alpha blending with 4 nodes", 256),
}
needs = needs_of(BITS)
_COLUMNS = (
    Column("place", "Target", kind="text"),
    Column("holds", "Holds", kind="text"),
    Column("format", "Format", kind="text"),
    Column("bits", "Bits", "bit/px"),
    Column("clear", "Cleared to", kind="text"),
    Column("paper_format", "Paper's format", kind="text"),
    Column("paper_bits", "Paper's bits", "bit/px"),
    Column("paper_clear", "Paper's", kind="text", help="clear value of the paper"),
)


def build(context: ReportContext) -> list[Artifact]:
    """Write one row for each target of the paper."""
    album = Album(context, needs)
    if not any(map(album.record, BITS)):
        return [Note("The results have no cell of this table.")]
    declared = _declared()
    rows = [
        (
            row.place, row.holds, target.format, _bits(target), _text(_clear(target)),
            row.format, row.bits, _text(row.clear),
        )
        for name, row in PUBLISHED.items()
        for target in [declared[name]]
    ]  # fmt: skip
    text = caption(album, "Targets with all effects.", _findings(album, declared))
    path = context.out / "pt_table2.csv"
    return [write_table(path, _COLUMNS, rows, title="Targets", caption=text)]


def _declared() -> Mapping[str, Target]:
    """Return the targets that the method declares when all of its effects run."""
    from oitbench.plugins import Collection

    (method,) = Collection.load().expand_methods([METHOD])
    plan = plan_of(method, Request(method.expresses & ~Effect.VOLUME))
    return {name: target for name, target in plan.targets.items() if name != "color"}


def _bits(target: Target) -> int:
    return 8 * target.texel.bytes


def _clear(target: Target) -> tuple[float, ...]:
    """Return the clear value of each component."""
    count = target.texel.components
    return target.clear * count if len(target.clear) == 1 else target.clear


def _text(values: tuple[float, ...]) -> str:
    return ", ".join(f"{value:g}" for value in values)


def _findings(album: Album, declared: Mapping[str, Target]) -> Iterator[Finding]:
    """Compare the declaration with the table, and bits of cells with the paper's text."""
    same = {
        name: (target.format, _bits(target), _clear(target)) for name, target in declared.items()
    }
    wanted = {name: (row.format, row.bits, row.clear) for name, row in PUBLISHED.items()}
    yield Finding("all targets have the paper's formats and clear values", same == wanted)
    whole = sum(map(_bits, declared.values()))
    yield Finding(f"112 bits per pixel with all effects ({whole})", whole == 112)
    for picture, (words, bits) in BITS.items():
        outcome = album.outcome(picture)
        text = f"{bits} bits per pixel for {words}"
        if outcome is None:
            yield Finding(text, None)
            continue
        have = outcome.memory.bits_per_pixel
        yield Finding(f"{text} ({have:.0f})", round(have) == bits)

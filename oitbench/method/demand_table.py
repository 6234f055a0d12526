"""Demands as the columns of a table: those of the README, of the report and of the command line."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

from msgspec import to_builtins

from oitbench.method.demands import CLASSES, Demands


class Fact(NamedTuple):
    """One column: its key, heading, kind, "number" or "text", and meaning, and its value."""

    key: str
    heading: str
    kind: str
    help: str
    value: Callable[[Demands], int | str]


def _passes(found: Demands) -> int | str:
    return "grow with layers" if found.geometry_passes is None else found.geometry_passes


def _buffers(found: Demands) -> str:
    return "unbounded" if found.unbounded else _yes(found.atomics)


def _fragment_bits(found: Demands) -> int | str:
    return found.fragment_bits if found.has_fixed_cost else f"≥ {found.fragment_bits}"


def _yes(value: bool) -> str:
    return "yes" if value else "no"


FACTS = (
    Fact("class", "capability class", "text", "the first class that offers all that is demanded",
         lambda found: CLASSES[found.capability_class]),
    Fact("geometry_passes", "geometry passes", "number", "draws of the same geometry in a frame",
         _passes),
    Fact("targets", "targets", "number", "color targets of one pass, at most",
         lambda found: found.targets),
    Fact("dual_source", "dual source", "text", "a pass blends two colors of one shader",
         lambda found: _yes(found.dual_source)),
    Fact("programmable", "shader blends", "text", "by framebuffer fetch or interlock",
         lambda found: _yes(found.programmable)),
    Fact("buffers", "buffers with atomics", "text", "unbounded: one grows with the fragments",
         _buffers),
    Fact("tile_bits", "bits of tile memory", "number", "at a pixel, with all samples, in one pass",
         lambda found: found.tile_bits),
    Fact("fragment_bits", "bits per fragment", "number", "read and written for a fragment",
         _fragment_bits),
    Fact("msaa", "samples per pixel", "text", "numbers that the method offers",
         lambda found: ", ".join(map(str, found.offered))),
)  # fmt: skip
"""The columns in their order."""


def table(rows: Mapping[str, Demands]) -> str:
    """Return the demands of methods, by label, as a Markdown table."""
    headings = ("method", *(fact.heading for fact in FACTS))
    lines = [headings, ("---",) * len(headings)]
    lines += [
        (f"`{label}`", *(str(fact.value(found)) for fact in FACTS)) for label, found in rows.items()
    ]
    return "".join(f"| {' | '.join(line)} |\n" for line in lines)


def facts(label: str, found: Demands) -> dict[str, Any]:
    """Return the demands of a method for programs."""
    return {"method": label, "class": found.capability_class, **to_builtins(found)}

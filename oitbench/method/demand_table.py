"""Demands as the columns of a table: those of the README, of the report and of the command line."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

from msgspec import to_builtins

from oitbench.method.demands import CLASSES, Demands


class Fact(NamedTuple):
    """One column: its key, heading and meaning, and the value that it shows."""

    key: str
    heading: str
    help: str
    value: Callable[[Demands], int | str]


def _passes(found: Demands) -> int | str:
    return "grows with layers" if found.geometry_passes is None else found.geometry_passes


def _buffers(found: Demands) -> str:
    return "unbounded" if found.unbounded else _yes(found.atomics)


def _fragment_bits(found: Demands) -> int | str:
    return found.fragment_bits if found.has_fixed_cost else f"≥ {found.fragment_bits}"


def _yes(value: bool) -> str:
    return "yes" if value else "no"


FACTS = (
    Fact("class", "capability class", "the first class that offers everything that is demanded",
         lambda found: CLASSES[found.capability_class]),
    Fact("geometry_passes", "geometry passes", "draws of the same geometry in a frame", _passes),
    Fact("targets", "targets", "color targets of one pass, at most", lambda found: found.targets),
    Fact("dual_source", "dual source", "a pass blends two colors of one shader",
         lambda found: _yes(found.dual_source)),
    Fact("programmable", "shader blends", "by framebuffer fetch or interlock",
         lambda found: _yes(found.programmable)),
    Fact("buffers", "buffers with atomics", "unbounded: memory grows with the fragments", _buffers),
    Fact("tile_bits", "bits of tile memory", "at a pixel, with all samples, in one pass",
         lambda found: found.tile_bits),
    Fact("fragment_bits", "bits per fragment", "read and written for a fragment", _fragment_bits),
    Fact("msaa", "samples per pixel", "numbers that the method offers",
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

"""What each method demands of a platform, by what it declares.

The capability class is the first of fixed-function blending, multiple targets, dual-source
blending, framebuffer fetch or interlock, and atomics and unbounded buffers that offers all of it. A
method that declares other targets or passes for the effects of some scenes has a row for each of
its demands. `oitbench choose` finds the methods that fit a platform.
"""

from __future__ import annotations

from oitbench.method.demand_table import FACTS
from oitbench.method.demands import CLASSES, Demands
from oitbench.parameters import natural
from oitbench.report import Artifact, Column, ReportContext, columns, write_table

title = "Capability classes"
order = 22

_COLUMNS = (
    columns.METHOD,
    *(Column(f.key, f.heading.capitalize(), kind=f.kind, help=f.help) for f in FACTS),
    Column("scenes", "Scenes", kind="text", help="whose effects the method then declares it for"),
)


def build(context: ReportContext) -> list[Artifact]:
    """Write one table, by class."""
    found: dict[tuple[str, Demands], list[str]] = {}
    for record in context.results.records:
        if record.outcome is not None:
            scenes = found.setdefault((record.method, record.outcome.demands), [])
            scenes += [] if record.seen in scenes else [record.seen]
    if not found:
        return []
    variants = [method for method, _ in found]
    rows = [
        (
            method,
            *(fact.value(demands) for fact in FACTS),
            "all" if variants.count(method) == 1 else ", ".join(scenes),
        )
        for (method, demands), scenes in sorted(found.items(), key=lambda item: _place(*item[0]))
    ]
    caption = (
        "Bits of tile memory are those of all targets at a pixel, with all samples, of the pass "
        "where they are most. Bits per fragment are read and written in passes over the geometry, "
        "blending included; where lists or the number of passes grow, they are a lower bound."
    )
    path = context.out / "capability.csv"
    return [write_table(path, _COLUMNS, rows, title="Demands of methods", caption=caption)]


def _place(method: str, demands: Demands) -> tuple[object, ...]:
    return list(CLASSES).index(demands.capability_class), natural(method), demands.tile_bits

"""What a method demands of a platform: facts of its declaration, and the class that they give.

Nothing here is measured, and no method states any of it: targets, passes, blending and buffers of
the plan say everything.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Set

from msgspec import Struct

from oitbench.method.declaration import Method, Plan, Request, plan_of
from oitbench.method.passes import Gather, Interleaved, Loop, Objects, Pass, Resolve, Step
from oitbench.method.steps import (
    accesses_of,
    all_passes,
    check_pass,
    is_programmable,
    passes_of,
)
from oitbench.method.storage import Items

BLENDING, TARGETS, DUAL_SOURCE = "blending", "targets", "dual-source"
INTERLOCK, ATOMICS = "interlock", "atomics"
CLASSES: Mapping[str, str] = {
    BLENDING: "fixed-function blending",
    TARGETS: "multiple targets",
    DUAL_SOURCE: "dual-source blending",
    INTERLOCK: "framebuffer fetch or interlock",
    ATOMICS: "atomics and unbounded buffers",
}
"""Capability classes: key and name. A platform of one class offers those before it, too."""
_REQUIRED: Mapping[str, frozenset[str]] = {
    DUAL_SOURCE: frozenset({"dual_source"}),
    INTERLOCK: frozenset({"framebuffer_fetch", "interlock"}),
    ATOMICS: frozenset({"image_load_store"}),
}
"""Names in `Method.requires` that put a method into a class, whatever its plan says."""


_KINDS = (Objects.PARTICLES, Objects.OTHERS)


class Demands(Struct, frozen=True, forbid_unknown_fields=True):
    """What a frame of a method demands of a platform.

    `geometry_passes` is the largest number of times that a frame draws the same geometry; null if a
    pass repeats until no fragment is left. `targets` is the largest number of color targets of one
    pass. `dual_source` tells whether a pass blends two colors of one shader, `programmable` whether
    a shader itself blends, by framebuffer fetch or interlock. `atomics` tells whether passes access
    buffers, in which fragments of a pixel meet by atomic operations, and `unbounded` whether a
    buffer grows with the number of fragments.

    `tile_bits` are those of all targets at a pixel that one pass writes, the method's own depth and
    all samples included, for the pass where they are most. Passes that alternate for each unit of
    geometry count as one. `fragment_bits` are the bits that passes read and write for a fragment
    that covers its pixel, blending included, in one round of a loop that has no fixed end. A record
    of a list is written once and read once by each pass over pixels; its head is exchanged.

    `samples` is the number of samples per pixel, and `offered` are those that the method's
    parameter `msaa` allows.
    """

    geometry_passes: int | None
    targets: int
    dual_source: bool
    programmable: bool
    atomics: bool
    unbounded: bool
    tile_bits: int
    fragment_bits: int
    samples: int
    offered: tuple[int, ...]

    @property
    def capability_class(self) -> str:
        """The first class that offers everything that is demanded, a key of `CLASSES`."""
        demanded = {
            TARGETS: self.targets > 1,
            DUAL_SOURCE: self.dual_source,
            INTERLOCK: self.programmable,
            ATOMICS: self.atomics or self.unbounded,
        }
        return [BLENDING, *(key for key, found in demanded.items() if found)][-1]

    @property
    def has_fixed_cost(self) -> bool:
        """Whether memory and passes do not grow with the number of layers."""
        return not self.unbounded and self.geometry_passes is not None


NOTHING = Demands(0, 0, False, False, False, False, 0, 0, 1, (1,))
"""The demands of an empty plan."""


def default_demands(method: Method) -> Demands:
    """Return the demands of a method in a scene that requests all effects that it shows.

    Raises
    ------
    DeclarationError
        The method returns no plan, or one whose passes do not fit its targets and buffers.
    """
    plan = plan_of(method, Request(method.shows, particles=True))
    for item in all_passes(plan.passes):
        check_pass(item, plan.declared, plan.buffers)
    return demands_of(method, plan)


def demands_of(method: Method, plan: Plan) -> Demands:
    """Return the demands of a plan that `method` returned, whose passes were checked."""
    passes = tuple(all_passes(plan.passes))
    blends = [blend for item in passes for blend in item.writes.values()]
    offered = method.parameters["msaa"].choices if "msaa" in method.parameters else ()

    def required(name: str) -> bool:
        return not _REQUIRED[name].isdisjoint(method.requires)

    return Demands(
        geometry_passes=_geometry_passes(plan.passes),
        targets=max((len(item.writes) for item in passes), default=0),
        dual_source=required(DUAL_SOURCE) or any(blend.dual for blend in blends),
        programmable=required(INTERLOCK) or any(map(is_programmable, passes)),
        atomics=required(ATOMICS)
        or any(item.buffers for item in passes)
        or any(blend.counts for blend in blends),
        unbounded=any(item.items is Items.FRAGMENTS for item in plan.buffers.values()),
        tile_bits=_tile_bits(plan, method.sample_count),
        fragment_bits=_fragment_bits(plan, method.sample_count),
        samples=method.sample_count,
        offered=tuple(sorted(map(int, offered))) or (method.sample_count,),
    )


def _geometry_passes(steps: Iterable[Step]) -> int | None:
    counts = dict.fromkeys(_KINDS, 0)
    for step in steps:
        for kind in counts:
            drawn = sum(_draws(item, kind) for item in passes_of(step))
            if drawn and isinstance(step, Loop) and step.times is None:
                return None
            counts[kind] += drawn * _rounds(step)
    # A pass over particles and one over all other objects draw everything once.
    return max(counts.values())


def _rounds(step: Step) -> int:
    return step.times or 1 if isinstance(step, Loop) else 1


def _draws(item: Pass, kind: Objects) -> bool:
    return isinstance(item, Gather) and item.objects in (Objects.ALL, kind)


def _tile_bits(plan: Plan, samples: int) -> int:
    attached = [
        {name for item in passes for name in (*item.writes, item.depth) if name is not None}
        for step in plan.passes
        for passes in _together(step)
    ]
    return max((sum(_bits(plan, name, samples) for name in names) for names in attached), default=0)


def _together(step: Step) -> Iterator[tuple[Pass, ...]]:
    """Yield passes whose targets are attached at the same time."""
    if isinstance(step, Interleaved):
        yield step.passes
    else:
        yield from ((item,) for item in passes_of(step))


def _fragment_bits(plan: Plan, samples: int) -> int:
    totals = dict.fromkeys(_KINDS, 0)
    filled: set[str] = set()
    for step in plan.passes:
        for item in passes_of(step):
            for kind in totals:
                if isinstance(item, Resolve) or _draws(item, kind):
                    totals[kind] += _rounds(step) * _moved_bits(plan, item, filled, samples)
            if isinstance(item, Gather):
                filled |= set(item.buffers)
    return max(totals.values())


def _moved_bits(plan: Plan, item: Pass, filled: Set[str], samples: int) -> int:
    """Return the bits that a pass moves for one fragment.

    A pass over pixels only reads lists, and only those that an earlier pass has filled.
    """
    bits = 0
    if isinstance(item, Gather):
        bits += sum(_bits(plan, name, samples) for name, _ in accesses_of(item))
    for name in item.buffers:
        buffer = plan.buffers[name]
        if buffer.items is Items.FRAGMENTS and (isinstance(item, Gather) or name in filled):
            bits += 8 * buffer.record_bytes
        elif isinstance(item, Gather):
            bits += 2 * 8 * buffer.record_bytes
    return bits


def _bits(plan: Plan, name: str, samples: int) -> int:
    """Return the bits of a target at one of its pixels, all samples included."""
    target = plan.declared[name]
    return 8 * target.texel.bytes * (1 if target.single else samples)

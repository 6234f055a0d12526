"""The declaration of a method as plain data: its storage, its passes, and how these use it."""

from __future__ import annotations

from collections.abc import Iterator

from msgspec import Struct

from oitbench.method import blending
from oitbench.method.blending import Blend
from oitbench.method.declaration import Method, Plan, Request, plan_of
from oitbench.method.passes import (
    BLUE_NOISE,
    OPAQUE_COLOR,
    OPAQUE_DEPTH,
    Gather,
    Interleaved,
    Loop,
    Objects,
    Order,
    Pass,
    Resolve,
    Step,
)
from oitbench.method.steps import passes_of
from oitbench.method.storage import Items

FRAGMENT, PIXEL = "fragment", "pixel"
"""Units that storage has its bits for."""
_FRAME = ("color", OPAQUE_COLOR, OPAQUE_DEPTH, BLUE_NOISE)
_WORDS = tuple(
    (getattr(blending, name), word)
    for name, word in (
        ("REPLACE", "write"), ("ADD", "add"), ("OVER", "over"), ("UNDER", "under"),
        ("ATTENUATE", "attenuate"), ("MODULATE", "multiply"), ("COMPOSITE", "composite"),
        ("MINIMUM", "min"), ("MAXIMUM", "max"), ("PROGRAMMABLE", "by shader"), ("COUNT", "count"),
    )
)  # fmt: skip


class Storage(Struct, frozen=True):
    """A target or a buffer.

    Parameters
    ----------
    name : str
    format : str
        Of the texels of a target, or the number of fields of a record; empty if it is unknown.
    bits : float
        For each `unit`.
    unit : str
        `PIXEL` or `FRAGMENT`.
    shared : bool
        Whether it belongs to the frame, and not to the method.
    """

    name: str
    format: str
    bits: float
    unit: str = PIXEL
    shared: bool = False


class Access(Struct, frozen=True):
    """How a pass uses a storage, in a word or two."""

    storage: str
    reads: bool
    writes: bool
    word: str


class PassOutline(Struct, frozen=True):
    """A pass: its name, the things that it is drawn for, a remark, and its accesses."""

    name: str
    draws: str
    remark: str
    accesses: list[Access]


class Outline(Struct, frozen=True):
    """All storage and all passes of a frame, in their order."""

    storages: list[Storage]
    passes: list[PassOutline]


def outline(method: Method) -> Outline:
    """Return what a method declares for a scene that requests all effects that it shows.

    Raises
    ------
    DeclarationError
        The method returns no plan.
    """
    plan = plan_of(method, Request(method.shows, particles=True))
    passes = [
        PassOutline(item.name, _draws(item), _remark(step, item), list(_accesses(item, plan)))
        for step in plan.passes
        for item in passes_of(step)
    ]
    used = {access.storage for item in passes for access in item.accesses}
    return Outline([item for item in _storages(plan, method) if item.name in used], passes)


def _storages(plan: Plan, method: Method) -> Iterator[Storage]:
    """Yield the method's own targets, its buffers, and the targets of the frame."""
    declared = plan.declared
    own = [name for name in declared if name not in _FRAME]
    for name in own:
        target = declared[name]
        samples = 1 if target.single else method.sample_count
        bits = 8 * target.texel.bytes * samples / target.subsample**2
        yield Storage(name, target.format, bits)
    for name, buffer in plan.buffers.items():
        unit = FRAGMENT if buffer.items is Items.FRAGMENTS else PIXEL
        fields = f"{len(buffer.fields)} field{'' if len(buffer.fields) == 1 else 's'}"
        yield Storage(name, fields, 8 * buffer.record_bytes, unit)
    for name in _FRAME:
        if name in declared:
            target = declared[name]
            yield Storage(name, target.format, 8 * target.texel.bytes, shared=True)


def _draws(item: Pass) -> str:
    if isinstance(item, Resolve):
        return "all pixels"
    objects = {
        Objects.ALL: "all fragments",
        Objects.PARTICLES: "fragments of particles",
        Objects.OTHERS: "all other fragments",
    }
    return objects[item.objects]


def _remark(step: Step, item: Pass) -> str:
    remarks = []
    if isinstance(item, Gather) and item.order is not Order.SUBMISSION:
        remarks.append(f"far to near by {item.order.value}")
    if isinstance(step, Interleaved):
        remarks.append("in turns with the other pass")
    if isinstance(step, Loop) and step.times != 1:
        end = "until nothing is left" if step.times is None else f"up to {step.times} times"
        remarks.append(f"repeated {end}")
    return ", ".join(remarks)


def _accesses(item: Pass, plan: Plan) -> Iterator[Access]:
    for name in item.reads:
        yield Access(name, True, False, "read")
    if item.depth is not None:
        writes = isinstance(item, Resolve) or item.depth_writes
        word = "depth test" if isinstance(item, Gather) else "write"
        yield Access(item.depth, isinstance(item, Gather), writes, word)
    for name, blend in item.writes.items():
        yield Access(name, blend.reads, True, _word(blend))
    for name in item.buffers:
        grows = plan.buffers[name].items is Items.FRAGMENTS and isinstance(item, Gather)
        yield Access(name, True, True, "append" if grows else "access")


def _word(blend: Blend) -> str:
    return next((word for known, word in _WORDS if known == blend), "blend")

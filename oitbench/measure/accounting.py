"""Memory and traffic of one frame, from its plan and from measured counts.

Traffic is algorithmic: the bytes that shaders and blending ask for, without caches or compression.
Its terms (pass × resource × kind) are kept, so that every total can be checked by eye.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from oitbench.gl.draws.records import FrameMeasurement, Term, terms_of
from oitbench.gl.frame import Frame
from oitbench.method.storage import Items
from oitbench.results.schema import Memory, MemoryTerm, SharedShading, Traffic, TrafficTerm


def memory(frame: Frame) -> Memory:
    """Return the memory that the method allocates for `frame`.

    The frame's own color and depth, which every method shares, are not counted.
    """
    return _memory(frame.resources.memory(), frame.plan.size)


def traffic(frame: Frame, measured: FrameMeasurement) -> Traffic:
    """Return the traffic of a frame.

    Parameters
    ----------
    frame : Frame
        Built with `counted=True` if the method has buffers.
    measured : FrameMeasurement
        From `Frame.measure`.
    """
    plan, pixels = frame.plan, frame.plan.size[0] * frame.plan.size[1]
    terms = [
        Term("clear", name, "clear", plan.texels(name) * plan.clears(name), target.texel.bytes)
        for name, target in plan.targets.items()
    ]
    for name, buffer in plan.buffers.items():
        if buffer.clear is not None:
            items = pixels if buffer.items is Items.PIXELS else frame.resources.records(name)
            terms.append(Term("clear", name, "clear", items * plan.frames, buffer.record_bytes))
    for step, record in zip(plan.passes, measured.passes, strict=True):
        terms += terms_of(step, record, plan.declared, plan.texels, plan.buffers)
    return _traffic(terms)


def shading(frame: Frame, measured: FrameMeasurement) -> SharedShading:
    """Return memory and traffic of the stages that all methods share.

    These are the shadow maps, ambient occlusion and the filters of both.
    """
    maps = [entry for stage in frame.shading for entry in stage.memory()]
    return SharedShading(
        _memory(maps, frame.plan.size),
        _traffic(measured.shading_terms),
        frame.scene.settings.values,
    )


def _memory(terms: Sequence[tuple[str, int]], size: tuple[int, int]) -> Memory:
    total = sum(count for _, count in terms)
    return Memory(
        total, 8 * total / (size[0] * size[1]), [MemoryTerm(name, count) for name, count in terms]
    )


def _traffic(terms: Iterable[Term]) -> Traffic:
    kept = [
        TrafficTerm(
            term.pass_, term.resource, term.kind, term.items, term.bytes_per_item, term.bytes
        )
        for term in terms
        if term.items
    ]
    return Traffic(sum(term.bytes for term in kept), kept)

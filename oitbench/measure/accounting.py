"""Memory and traffic of one frame, from its declaration and from counts that were measured.

Traffic is algorithmic: what the shaders and the blending ask for, without caches or compression.
Its terms (pass × resource × kind) are kept, so that every total can be checked by eye.
"""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from typing import Any

from oitbench.gl.draws.steps import PassRecord
from oitbench.gl.frame import Frame
from oitbench.method.declaration import Draws, Items, Pass
from oitbench.method.formats import GLSL_BYTES


@dataclass(frozen=True)
class Term:
    """Bytes that one pass moves to or from one resource in one way.

    Parameters
    ----------
    pass : str
        Named `pass_` here and "pass" in records.
    resource : str
        Target, or buffer and field.
    kind : str
        "clear", "read", "write", "blend" (what blending reads) or "atomic" (a read and a write).
    items : int
        Pixels, fragments or accesses; measured.
    bytes_per_item : int
    """

    pass_: str
    resource: str
    kind: str
    items: int
    bytes_per_item: int

    @property
    def bytes(self) -> int:
        """Items times bytes of each."""
        return self.items * self.bytes_per_item

    def facts(self) -> dict[str, Any]:
        """Return the term as it stands in a record."""
        facts = asdict(self)
        facts["pass"] = facts.pop("pass_")
        return {**facts, "bytes": self.bytes}


def memory(frame: Frame) -> dict[str, Any]:
    """Return bytes, bits a pixel and terms of all that the method allocates for `frame`.

    The frame's own color and depth, which every method shares, are not counted.
    """
    terms = frame.resources.memory()
    total = sum(size for _, size in terms)
    return {
        "bytes": total,
        "bits_per_pixel": 8 * total / (frame.size[0] * frame.size[1]),
        "terms": [{"resource": name, "bytes": size} for name, size in terms],
    }


def traffic(frame: Frame, records: list[PassRecord]) -> list[Term]:
    """Return the terms of a frame's traffic.

    Parameters
    ----------
    frame : Frame
        Built with `counted=True`, if the method has buffers.
    records : list of PassRecord
        What the frame's passes did, from `Frame.issue`.
    """
    pixels = frame.size[0] * frame.size[1]
    terms = [
        Term("clear", name, "clear", _texels(frame, name), target.texel.bytes)
        for name, target in frame.resources.targets.items()
    ]
    for name, buffer in frame.resources.buffers.items():
        if buffer.clear is not None:
            items = pixels if buffer.items is Items.PIXELS else frame.resources.records(name)
            terms.append(Term("clear", name, "clear", items, buffer.record_bytes))
    for step, record in zip(frame.passes, records, strict=True):
        terms += _pass_terms(frame, step, record)
    return [term for term in terms if term.items]


def shading(frame: Frame) -> dict[str, Any]:
    """Return memory and traffic of the stages that shade, and so are the same for every method.

    These are the shadow maps, ambient occlusion and what filters both; `frame` must have been
    measured.
    """
    maps = [entry for stage in frame.shading for entry in stage.memory()]
    terms = [Term(*moved) for moved in frame.shading_moved if moved[3]]
    return {
        "memory": {
            "bytes": sum(size for _, size in maps),
            "terms": [{"resource": name, "bytes": size} for name, size in maps],
        },
        "traffic": {
            "bytes": sum(term.bytes for term in terms),
            "terms": [term.facts() for term in terms],
        },
    }


def _texels(frame: Frame, target: str) -> int:
    declared = frame.declared[target]
    return math.prod(declared.size(frame.size)) * (1 if declared.single else frame.samples)


def _pass_terms(frame: Frame, step: Pass, record: PassRecord) -> list[Term]:
    screen = step.draws is Draws.PIXELS
    texels = _texels(frame, next(iter(step.writes), step.depth or "color"))
    items = texels * record.runs if screen else record.fragments
    terms = [
        Term(
            step.name,
            name,
            "clear",
            _texels(frame, name) * record.runs,
            frame.declared[name].texel.bytes,
        )
        for name in step.clears
    ]
    for name in step.reads:
        # What is smaller than the screen that it is spread over counts once.
        found = min(items, _texels(frame, name) * record.runs) if screen else items
        terms.append(Term(step.name, name, "read", found, frame.declared[name].texel.bytes))
    if screen and step.depth is not None:
        size = frame.declared[step.depth].texel.bytes
        terms.append(Term(step.name, step.depth, "write", items, size))
    for name, blend in step.writes.items():
        size = frame.declared[name].texel.bytes
        if blend.reads:
            terms.append(Term(step.name, name, "blend", items, size))
        terms.append(Term(step.name, name, "write", items, size))
    for (name, field, kind), count in record.accesses.items():
        buffer = frame.resources.buffers[name]
        size = GLSL_BYTES[buffer.fields.get(field, "uint")]
        terms.append(
            Term(step.name, f"{name}.{field}", kind, count, 2 * size if kind == "atomic" else size)
        )
    return terms

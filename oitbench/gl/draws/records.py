"""Counts of a pass, and the bytes that follow from them. Nothing here needs OpenGL."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Mapping
from dataclasses import dataclass, field
from fractions import Fraction
from typing import Literal

from oitbench.gl.program.bindings import Access
from oitbench.method.formats import GLSL_BYTES
from oitbench.method.passes import Pass, Resolve
from oitbench.method.steps import accesses_of
from oitbench.method.storage import Buffer, Target

Kind = Literal["clear", "read", "write", "blend", "atomic"]


Lap = Callable[[Hashable], None]
"""Called with the key of a part of a frame when that part has been issued, to time it."""


def no_lap(key: Hashable) -> None:
    """Time nothing."""


@dataclass
class PassRecord:
    """Counts of one pass in a frame.

    Parameters
    ----------
    name : str
    runs : int
        Issued draws of the screen, or of all geometry.
    cleared : Fraction
        Times that the pass has cleared its targets; a part of the frame counts by its area.
    fragments : int
        Samples that passed the depth test, or fragments stored in buffers.
    accesses : dict
        Number of accesses to buffers.
    """

    name: str
    runs: int = 0
    cleared: Fraction = Fraction()
    fragments: int = 0
    accesses: dict[Access, int] = field(default_factory=dict)


@dataclass(frozen=True)
class Term:
    """Bytes that one pass moves to or from one resource in one way.

    Parameters
    ----------
    pass_ : str
        Name of the pass.
    resource : str
        Target, or buffer and field.
    kind : str
        "clear", "read", "write", "blend" (the read that blending or a depth test that writes
        implies) or "atomic" (a read and a write).
    items : int
        Measured number of pixels, fragments or accesses.
    bytes_per_item : int
    """

    pass_: str
    resource: str
    kind: Kind
    items: int
    bytes_per_item: int

    @property
    def bytes(self) -> int:
        """Items times bytes of each."""
        return self.items * self.bytes_per_item


@dataclass(frozen=True)
class FrameMeasurement:
    """Counts of one frame.

    Parameters
    ----------
    passes : list of PassRecord
        One per pass of the plan.
    shading : list of PassRecord
        The stages that all methods share.
    shading_terms : list of Term
        Traffic of those stages.
    """

    passes: list[PassRecord]
    shading: list[PassRecord]
    shading_terms: list[Term]


def terms_of(
    step: Pass,
    record: PassRecord,
    targets: Mapping[str, Target],
    texels: Callable[[str], int],
    buffers: Mapping[str, Buffer],
    taps: Mapping[str, int] | None = None,
    label: str = "",
) -> list[Term]:
    """Return the traffic of one pass.

    Parameters
    ----------
    step : Gather or Resolve
    record : PassRecord
    targets : mapping of str to Target
    texels : callable
        From the name of a target to its number of texels, samples included.
    buffers : mapping of str to Buffer
    taps : mapping of str to int, optional
        Texels of each read target that one output needs. Default: a pass over pixels counts each
        texel once, however often its filter fetches it.
    label : str, optional
        Name of the pass in the terms. Default: that of the record.
    """
    name, items = label or record.name, record.fragments

    def term(resource: str, kind: Kind, count: int) -> Term:
        return Term(name, resource, kind, count, targets[resource].texel.bytes)

    terms = [term(target, "clear", int(texels(target) * record.cleared)) for target in step.clears]
    for target, kind in accesses_of(step):
        count = items
        if kind == "read" and taps is not None:
            count = taps[target] * items
        elif kind == "read" and isinstance(step, Resolve):
            count = min(items, texels(target) * record.runs)
        terms.append(term(target, kind, count))
    for (buffer, key, access), count in record.accesses.items():
        size = GLSL_BYTES[buffers[buffer].fields.get(key, "uint")]
        size *= 2 if access == "atomic" else 1
        terms.append(Term(name, f"{buffer}.{key}", access, count, size))
    return [entry for entry in terms if entry.items]

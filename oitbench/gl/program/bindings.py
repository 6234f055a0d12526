"""Numbers of uniform blocks, storage blocks and access counters."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

from oitbench.method.storage import Buffer, Items

AccessKind = Literal["read", "write", "atomic"]
Access = tuple[str, str, AccessKind]
"""Buffer, field, and kind of access."""
VIEW_BINDING, LIGHTS_BINDING, MEDIUM_BINDING = 0, 1, 2
"""Bindings of the uniform blocks `View`, `Lights` and `Medium` of the engine's shaders."""


@dataclass(frozen=True)
class Bindings:
    """Bindings of buffers, and the counter of each kind of access.

    Parameters
    ----------
    fields : mapping of (buffer, field) to int
        Storage block of each field.
    allocators : mapping of buffer to int
    counters : int or None
        Storage block of the access counters; None in a build that does not count.
    slots : mapping of (buffer, field, kind) to int
        Counter of each kind of access.
    """

    fields: Mapping[tuple[str, str], int] = field(default_factory=dict)
    allocators: Mapping[str, int] = field(default_factory=dict)
    counters: int | None = None
    slots: Mapping[Access, int] = field(default_factory=dict)

    @classmethod
    def of(cls, buffers: Mapping[str, Buffer], counted: bool) -> Bindings:
        """Return the bindings of the storage blocks of the allocated `buffers`."""
        pairs = [(name, key) for name, buffer in buffers.items() for key in buffer.fields]
        listed = [name for name, buffer in buffers.items() if buffer.items is Items.FRAGMENTS]
        kinds: tuple[AccessKind, ...] = ("read", "write", "atomic")
        slots: list[Access] = [(*pair, kind) for pair in pairs for kind in kinds]
        slots += [(name, "allocator", "atomic") for name in listed]
        count = len(pairs) + len(listed)
        return cls(
            {pair: index for index, pair in enumerate(pairs)},
            {name: len(pairs) + index for index, name in enumerate(listed)},
            count if counted and slots else None,
            {slot: index for index, slot in enumerate(slots)},
        )

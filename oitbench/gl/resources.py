"""The textures and buffers of a frame, and the memory that records are allocated from."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import moderngl
import numpy as np
import numpy.typing as npt

from oitbench.errors import CapabilityError
from oitbench.gl.device import Device
from oitbench.gl.program.prelude import ALLOCATOR_STRIDE, TILE, Bindings
from oitbench.method.declaration import Buffer, Items, Target
from oitbench.method.formats import GLSL_BYTES

Counts = npt.NDArray[np.int64]


@dataclass(frozen=True)
class Region:
    """A rectangle of tiles that is rendered at once: columns and rows [first, last)."""

    left: int
    bottom: int
    right: int
    top: int

    def scissor(self, size: tuple[int, int]) -> tuple[int, int, int, int]:
        """Return (x, y, width, height) in pixels, clipped to the frame."""
        left, bottom = self.left * TILE, self.bottom * TILE
        right, top = min(self.right * TILE, size[0]), min(self.top * TILE, size[1])
        return left, bottom, right - left, top - bottom


def split(demand: Counts, limit: int) -> list[Region]:
    """Cut the frame into as few regions as needed for each to hold at most `limit` records.

    Parameters
    ----------
    demand : array, shape (rows, columns), int64
        Records that each tile needs.
    limit : int
        Records that one storage block can hold.

    Raises
    ------
    CapabilityError
        One tile alone needs more.
    """

    def cut(region: Region) -> list[Region]:
        part = demand[region.bottom : region.top, region.left : region.right]
        if part.sum() <= limit:
            return [region]
        if part.size == 1:
            raise CapabilityError(
                f"{int(part.sum())} fragments in one {TILE}×{TILE} tile pass the driver's limit of"
                f" {limit} records a buffer; render fewer layers"
            )
        if part.shape[0] >= part.shape[1]:
            middle = (region.bottom + region.top) // 2
            halves = (
                Region(region.left, region.bottom, region.right, middle),
                Region(region.left, middle, region.right, region.top),
            )
        else:
            middle = (region.left + region.right) // 2
            halves = (
                Region(region.left, region.bottom, middle, region.top),
                Region(middle, region.bottom, region.right, region.top),
            )
        return [piece for half in halves for piece in cut(half)]

    rows, columns = demand.shape
    return cut(Region(0, 0, columns, rows))


class Resources:
    """What a method's declaration allocates for a frame of `size`.

    `asked` counts the records that fragments asked for since it was last set to zero.

    Parameters
    ----------
    device : Device
    size : (int, int)
        Width and height in pixels.
    targets, buffers : mapping
        Those that are allocated: `when` has been applied.
    bindings : Bindings
    block_limit : int
        Bytes that one storage block may have.
    samples : int
        Samples a pixel of every target that is not single.
    """

    def __init__(
        self,
        device: Device,
        size: tuple[int, int],
        targets: Mapping[str, Target],
        buffers: Mapping[str, Buffer],
        bindings: Bindings,
        block_limit: int,
        samples: int = 1,
    ) -> None:
        self.device, self.size, self.targets, self.buffers = device, size, targets, buffers
        self.samples = samples
        self.bindings, self.block_limit = bindings, block_limit
        self.tiles = (math.ceil(size[1] / TILE), math.ceil(size[0] / TILE))
        self.textures = {
            name: device.texture(target.size(size), target.texel, self.samples_of(name))
            for name, target in targets.items()
        }
        self._blocks: dict[tuple[str, str], moderngl.Buffer] = {}
        self._allocators: dict[str, moderngl.Buffer] = {}
        self._records: dict[str, int] = {}
        self.asked = 0
        self.regions = [Region(0, 0, self.tiles[1], self.tiles[0])]
        for name, buffer in buffers.items():
            if buffer.items is Items.PIXELS:
                self._allocate(name, size[0] * size[1])
        self._counters: moderngl.Buffer | None = None
        if bindings.counters is not None:
            words = math.prod(self.tiles) * len(bindings.slots)
            self._counters = device.context.buffer(reserve=4 * words)
            self._counters.clear()

    def samples_of(self, target: str) -> int:
        """Return how many samples a pixel a target has."""
        return 1 if self.targets[target].single else self.samples

    @property
    def listed(self) -> list[str]:
        """Names of the buffers that hold one record a fragment."""
        return [name for name, item in self.buffers.items() if item.items is Items.FRAGMENTS]

    def records(self, name: str) -> int:
        """Return how many records the buffer `name` has room for."""
        return self._records.get(name, 0)

    def _allocate(self, name: str, records: int) -> None:
        context = self.device.context
        self._records[name] = records
        for field, kind in self.buffers[name].fields.items():
            old = self._blocks.pop((name, field), None)
            if old is not None:
                old.release()
            size = max(records, 1) * GLSL_BYTES[kind]
            if size > self.block_limit:
                raise CapabilityError(
                    f"buffer {name}.{field} needs {size} bytes; the driver allows"
                    f" {self.block_limit}: render a smaller frame"
                )
            self._blocks[name, field] = context.buffer(reserve=size)

    def reserve(self, demand: Counts) -> None:
        """Make room for `demand` records a tile, (rows, columns), in as few regions as fit."""
        if not self.listed:
            return
        widest = max(
            GLSL_BYTES[kind] for name in self.listed for kind in self.buffers[name].fields.values()
        )
        self.demand = demand
        self.regions = split(demand, self.block_limit // widest)
        records = max(int(demand[r.bottom : r.top, r.left : r.right].sum()) for r in self.regions)
        for name in self.listed:
            if self._records.get(name) != records:
                self._allocate(name, records)
            if name not in self._allocators:
                words = math.prod(self.tiles) * ALLOCATOR_STRIDE
                self._allocators[name] = self.device.context.buffer(reserve=4 * words)

    def begin(self, region: Region) -> None:
        """Clear the buffers, and hand each tile of `region` its share of the records."""
        self._wait()
        for (name, _), block in self._blocks.items():
            value = self.buffers[name].clear
            if value is not None:
                block.clear(chunk=np.uint32(value).tobytes())
        for allocator in self._allocators.values():
            allocator.write(self._shares(region).tobytes())

    def _wait(self) -> None:
        """Let what shaders did to buffers come before what is done to them from outside."""
        if self._blocks:
            self.device.context.memory_barrier()

    def _shares(self, region: Region) -> npt.NDArray[np.uint32]:
        inside = np.zeros(self.tiles, dtype=np.int64)
        window = np.s_[region.bottom : region.top, region.left : region.right]
        inside[window] = self.demand[window]
        ends = np.cumsum(inside.reshape(-1))
        words = np.zeros((math.prod(self.tiles), ALLOCATOR_STRIDE), dtype=np.uint32)
        words[:, 0] = ends - inside.reshape(-1)
        words[:, 1] = ends
        return words

    def shortfall(self, region: Region) -> Counts | None:
        """Return the records that each tile of `region` asked for, if any had too few."""
        given = self._shares(region)
        needed: Counts | None = None
        self._wait()
        for allocator in self._allocators.values():
            words = np.frombuffer(allocator.read(), dtype=np.uint32).reshape(given.shape)
            asked = (words[:, 0] - given[:, 0]).astype(np.int64).reshape(self.tiles)
            self.asked += int(asked.sum())
            if (words[:, 0] > words[:, 1]).any():
                needed = asked if needed is None else np.maximum(needed, asked)
        return needed

    def bind(self) -> None:
        """Bind every storage block to its number."""
        for pair, block in self._blocks.items():
            block.bind_to_storage_buffer(self.bindings.fields[pair])
        for name, allocator in self._allocators.items():
            allocator.bind_to_storage_buffer(self.bindings.allocators[name])
        if self._counters is not None and self.bindings.counters is not None:
            self._counters.bind_to_storage_buffer(self.bindings.counters)

    def read(self, name: str, field: str) -> npt.NDArray[np.uint32]:
        """Return the words of a field of all records of a buffer, shape (records, words)."""
        self._wait()
        words = np.frombuffer(self._blocks[name, field].read(), dtype=np.uint32)
        return words.reshape(-1, GLSL_BYTES[self.buffers[name].fields[field]] // 4)

    def copy(self, source: str, target: str) -> None:
        """Copy one target's texels to another of its format."""
        samples, size = self.samples_of(target), self.targets[target].size(self.size)
        self.device.copy(self.textures[source], self.textures[target], size, samples)

    def take_counts(self) -> dict[tuple[str, str, str], int]:
        """Return the accesses counted since the last call, by (buffer, field, kind)."""
        if self._counters is None:
            return {}
        self._wait()
        words = np.frombuffer(self._counters.read(), dtype=np.uint32)
        totals = words.reshape(-1, len(self.bindings.slots)).sum(axis=0, dtype=np.int64)
        self._counters.clear()
        return {key: int(totals[slot]) for key, slot in self.bindings.slots.items()}

    def memory(self) -> list[tuple[str, int]]:
        """Return (resource, bytes) of all that the method's declaration allocated."""
        terms = [
            (name, target.texel.bytes * math.prod(target.size(self.size)) * self.samples_of(name))
            for name, target in self.targets.items()
        ]
        terms += [
            (name, buffer.record_bytes * self._records.get(name, 0))
            for name, buffer in self.buffers.items()
        ]
        # Two words a tile are used; the padding to a cache line is this renderer's own affair.
        terms += [(f"{name} allocator", 8 * math.prod(self.tiles)) for name in self._allocators]
        return terms

    def release(self) -> None:
        """Free the device's memory."""
        for texture in self.textures.values():
            texture.release()
        blocks = [*self._blocks.values(), *self._allocators.values()]
        for block in [*blocks, self._counters] if self._counters else blocks:
            block.release()

"""Textures and buffers of a frame, and the memory from which records are allocated."""

from __future__ import annotations

import math

import moderngl
import numpy as np
import numpy.typing as npt

from oitbench.errors import CapabilityError
from oitbench.gl.device import Device
from oitbench.gl.ownership import Owner
from oitbench.gl.plan import FramePlan
from oitbench.gl.program.bindings import Access
from oitbench.gl.readback import read_texels
from oitbench.gl.tiling import ALLOCATOR_STRIDE, TILE, Counts, Region, split
from oitbench.image.values import Values
from oitbench.method.blue_noise import MASK, SIDE, thresholds
from oitbench.method.formats import GLSL_BYTES
from oitbench.method.passes import BLUE_NOISE
from oitbench.method.storage import Items


class Resources(Owner):
    """The objects that a method's plan allocates.

    Parameters
    ----------
    device : Device
    plan : FramePlan
    block_limit : int, optional
        Largest storage block in bytes. Default: the driver's limit.

    Attributes
    ----------
    textures : dict of str to moderngl.Texture
    tiles : (int, int)
        Rows and columns of tiles.
    regions : list of Region
        Parts of the frame whose records fit in memory at once.
    demand : array, shape `tiles`, int64
        Records that each tile needs.
    requested : int
        Records that fragments requested since this was last set to zero.
    """

    def __init__(self, device: Device, plan: FramePlan, block_limit: int | None = None) -> None:
        super().__init__()
        self._device, self._plan = device, plan
        self._block_limit = min(device.max_block_bytes, block_limit or device.max_block_bytes)
        width, height = plan.size
        self.tiles = (math.ceil(height / TILE), math.ceil(width / TILE))
        self.textures: dict[str, moderngl.Texture] = {}
        self._blocks: dict[tuple[str, str], moderngl.Buffer] = {}
        self._allocators: dict[str, moderngl.Buffer] = {}
        self._given: dict[Region, npt.NDArray[np.uint32]] = {}
        self._records: dict[str, int] = {}
        self.requested = 0
        self.demand: Counts = np.zeros(self.tiles, dtype=np.int64)
        self.regions = [Region(0, 0, self.tiles[1], self.tiles[0])]
        self._counters: moderngl.Buffer | None = None
        with self.building():
            self._allocate_fixed()

    def _allocate_fixed(self) -> None:
        width, height = self._plan.size
        for name, target in self._plan.targets.items():
            samples = self._plan.samples_of(name)
            texture = self._device.texture(target.size(self._plan.size), target.texel, samples)
            self.textures[name] = self.own(texture)
        if self._plan.reads_mask:
            mask = self.own(self._device.texture((SIDE, SIDE), MASK.texel))
            mask.write(thresholds().tobytes())
            self.textures[BLUE_NOISE] = mask
        for name, buffer in self._plan.buffers.items():
            if buffer.items is Items.PIXELS:
                self._allocate(name, width * height)
        if self._plan.bindings.counters is not None:
            words = math.prod(self.tiles) * len(self._plan.bindings.slots)
            self._counters = self.own(self._device.context.buffer(reserve=4 * words))
            self._device.fill(self._counters)

    def records(self, name: str) -> int:
        """Return the number of records that fit in the buffer `name`."""
        return self._records.get(name, 0)

    def _allocate(self, name: str, records: int) -> None:
        self._records[name] = records
        for field, kind in self._plan.buffers[name].fields.items():
            old = self._blocks.pop((name, field), None)
            if old is not None:
                old.release()
            size = max(records, 1) * GLSL_BYTES[kind]
            if size > self._block_limit:
                raise CapabilityError(
                    f"buffer {name}.{field} needs {size} bytes; the driver allows"
                    f" {self._block_limit}: render a smaller frame"
                )
            self._blocks[name, field] = self.own(self._device.context.buffer(reserve=size))

    def reserve(self, demand: Counts) -> None:
        """Make room for `demand` records per tile, (rows, columns), in as few regions as fit."""
        listed, buffers = self._plan.listed, self._plan.buffers
        if not listed:
            return
        widest = max(GLSL_BYTES[kind] for name in listed for kind in buffers[name].fields.values())
        self.demand = demand
        self._given.clear()
        self.regions = split(demand, self._block_limit // widest)
        records = max(int(demand[r.bottom : r.top, r.left : r.right].sum()) for r in self.regions)
        for name in listed:
            if self._records.get(name) != records:
                self._allocate(name, records)
            if name not in self._allocators:
                words = math.prod(self.tiles) * ALLOCATOR_STRIDE
                allocator = self._device.context.buffer(reserve=4 * words)
                self._allocators[name] = self.own(allocator)

    def begin(self, region: Region) -> None:
        """Clear the buffers, and give each tile of `region` its share of the records."""
        self._wait()
        for (name, _), block in self._blocks.items():
            value = self._plan.buffers[name].clear
            if value is not None:
                self._device.fill(block, value)
        for allocator in self._allocators.values():
            allocator.write(self._shares(region).tobytes())

    def _wait(self) -> None:
        """Order accesses of shaders to buffers before those from outside."""
        if self._blocks:
            self._device.context.memory_barrier()

    def _shares(self, region: Region) -> npt.NDArray[np.uint32]:
        """Return the words of allocators; they are kept, as a GPU waits for them in each frame."""
        if region in self._given:
            return self._given[region]
        inside = np.zeros(self.tiles, dtype=np.int64)
        window = np.s_[region.bottom : region.top, region.left : region.right]
        inside[window] = self.demand[window]
        ends = np.cumsum(inside.reshape(-1))
        words = np.zeros((math.prod(self.tiles), ALLOCATOR_STRIDE), dtype=np.uint32)
        words[:, 0] = ends - inside.reshape(-1)
        words[:, 1] = ends
        self._given[region] = words
        return words

    def shortfall(self, region: Region) -> Counts | None:
        """Return the records that each tile of `region` requested, if any tile had too few."""
        given = self._shares(region)
        needed: Counts | None = None
        self._wait()
        for allocator in self._allocators.values():
            words = np.frombuffer(allocator.read(), dtype=np.uint32).reshape(given.shape)
            requested = (words[:, 0] - given[:, 0]).astype(np.int64).reshape(self.tiles)
            self.requested += int(requested.sum())
            if (words[:, 0] > words[:, 1]).any():
                needed = requested if needed is None else np.maximum(needed, requested)
        return needed

    def bind(self) -> None:
        """Bind every storage block."""
        bindings = self._plan.bindings
        for pair, block in self._blocks.items():
            block.bind_to_storage_buffer(bindings.fields[pair])
        for name, allocator in self._allocators.items():
            allocator.bind_to_storage_buffer(bindings.allocators[name])
        if self._counters is not None and bindings.counters is not None:
            self._counters.bind_to_storage_buffer(bindings.counters)

    def read(self, name: str, field: str) -> npt.NDArray[np.uint32]:
        """Return the words of a field of all records of a buffer, shape (records, words)."""
        self._wait()
        words = np.frombuffer(self._blocks[name, field].read(), dtype=np.uint32)
        return words.reshape(-1, GLSL_BYTES[self._plan.buffers[name].fields[field]] // 4)

    def texels(self, target: str) -> Values:
        """Return a target of one sample per pixel, top row first, shape (h, w, components)."""
        declared = self._plan.targets[target]
        size = declared.size(self._plan.size)
        return read_texels(self._device, self.textures[target], size, declared.texel)

    def copy(self, source: str, target: str) -> None:
        """Copy the texels of one target to another of its format."""
        size = self._plan.targets[target].size(self._plan.size)
        samples = self._plan.samples_of(target)
        self._device.copy(self.textures[source], self.textures[target], size, samples)

    def take_counts(self) -> dict[Access, int]:
        """Return the accesses to buffers since the last call."""
        if self._counters is None:
            return {}
        self._wait()
        slots = self._plan.bindings.slots
        words = np.frombuffer(self._counters.read(), dtype=np.uint32)
        totals = words.reshape(-1, len(slots)).sum(axis=0, dtype=np.int64)
        self._device.fill(self._counters)
        return {key: int(totals[slot]) for key, slot in slots.items()}

    def memory(self) -> list[tuple[str, int]]:
        """Return (resource, bytes) of everything that the method's plan allocated."""
        terms = self._plan.target_bytes()
        terms += [
            (name, buffer.record_bytes * self._records.get(name, 0))
            for name, buffer in self._plan.buffers.items()
        ]
        # Two words per tile are used; the padding to a cache line belongs to this renderer.
        terms += [(f"{name} allocator", 8 * math.prod(self.tiles)) for name in self._allocators]
        return terms

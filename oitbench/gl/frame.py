"""A method's frame of a scene: its declaration compiled into draws, and those draws issued."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field, replace

import moderngl
import numpy as np
import numpy.typing as npt

from oitbench.collection import folder_of
from oitbench.declare import (
    ADD,
    REPLACE,
    Draws,
    Interleaved,
    Method,
    Order,
    Pass,
    Step,
    Target,
)
from oitbench.effects import Effect
from oitbench.errors import CapabilityError, UsageError
from oitbench.gl.device import Device
from oitbench.gl.geometry import Batch, Geometry, view_block
from oitbench.gl.passes import CompiledPass, compile_pass
from oitbench.gl.prelude import TILE, bind
from oitbench.gl.resources import Counts, Resources

Image = npt.NDArray[np.float32]
_OPAQUE = Pass("opaque.glsl", Draws.FRAGMENTS, writes={"color": REPLACE})
_COUNT = Pass("count.glsl", Draws.FRAGMENTS, writes={"count": ADD})
_COUNT_TARGET = Target("r32f")
_ATTEMPTS = 4


@dataclass
class PassRecord:
    """What one pass did in a measured frame: fragments written, and accesses to buffers."""

    name: str
    fragments: int = 0
    milliseconds: float | None = None
    accesses: dict[tuple[str, str, str], int] = field(default_factory=dict)


@dataclass(frozen=True)
class _Sequence:
    """Indices of one draw order on the device, and the units of interleaved passes."""

    indices: moderngl.Buffer
    units: npt.NDArray[np.int64]
    triangles: int


class Frame:
    """One method on one scene at one size, ready to be rendered again and again.

    Parameters
    ----------
    device : Device
    geometry : Geometry
    method : Method
    size : (int, int)
        Width and height in pixels, sub-pixels included.
    effects : Effect
        Those that run: called by the scene and expressed by the method.
    counted : bool
        Build the accessors so that every access to a buffer is counted; slower, same image.
    block_limit : int, optional
        Bytes that one storage block may have, if less than the driver's own limit.

    Raises
    ------
    CapabilityError
        The driver lacks what the method requires.
    DeclarationError
        The declaration is inconsistent or a shader does not compile.
    UsageError
        The size is beyond the driver.
    """

    def __init__(
        self,
        device: Device,
        geometry: Geometry,
        method: Method,
        size: tuple[int, int],
        effects: Effect = Effect.NONE,
        counted: bool = False,
        block_limit: int | None = None,
    ) -> None:
        check_size(device, size)
        device.require(method.name, method.requires)
        self.device, self.geometry, self.method, self.size = device, geometry, method, size
        self.effects = effects
        targets = {k: t for k, t in method.targets.items() if _runs(t.when, effects)}
        color = targets.pop("color", Target("rgba16f"))
        buffers = {k: b for k, b in method.buffers.items() if _runs(b.when, effects)}
        self.bindings = bind(buffers, counted)
        limit = min(device.max_block_bytes, block_limit or device.max_block_bytes)
        self.resources = Resources(device, size, targets, buffers, self.bindings, limit)
        self.declared: dict[str, Target] = {
            **targets,
            "color": color,
            "opaque_color": color,
            "opaque_depth": Target("depth32f"),
        }
        self.textures = {
            **self.resources.textures,
            **{
                name: device.texture(size, self.declared[name].texel)
                for name in ("color", "opaque_color", "opaque_depth")
            },
        }
        self._view = device.context.buffer(
            reserve=len(view_block(geometry.scene.camera, size, False))
        )
        self._sequences: dict[Order, _Sequence] = {}
        self._transmittance: bool | None = None
        self.complexity = self._count_fragments()
        if self.resources.listed:
            self.resources.reserve(_by_tile(self.complexity, self.resources.tiles))
        absent = {*method.targets, *method.buffers} - {*targets, *buffers, "color"}
        running = [_running(step, effects, absent) for step in method.passes]
        self.steps = [
            (step, [self._compile(p) for p in _passes(step)]) for step in running if _passes(step)
        ]
        self._framebuffer_color = device.context.framebuffer([self.textures["color"]])
        self._framebuffer_opaque = device.context.framebuffer(
            [self.textures["opaque_color"]], self.textures["opaque_depth"]
        )
        self._clears = {
            name: device.context.framebuffer([texture])
            for name, texture in self.resources.textures.items()
        }

    # -- preparation ---------------------------------------------------------------------------

    def _compile(self, step: Pass) -> CompiledPass:
        return compile_pass(
            self.device,
            step,
            folder_of(type(self.method)),
            self.method,
            self.effects,
            self.geometry,
            self.declared,
            self.textures,
            self.resources.buffers,
            self.bindings,
        )

    def _engine_pass(self, step: Pass, textures: dict[str, moderngl.Texture], depth: bool) -> None:
        """Run one of the engine's own passes: the opaque picture, or the count of fragments."""
        declared = {**self.declared, "count": _COUNT_TARGET}
        compiled = compile_pass(
            self.device, step, None, Method(), Effect.NONE, self.geometry, declared,
            {**self.textures, **textures}, {}, bind({}, False), depth_writes=depth,
        )  # fmt: skip
        batch = self.geometry.opaque if depth else self.geometry.transparent
        indices = batch.arrange(Order.SUBMISSION)[0]
        if len(indices):
            buffer = self.device.context.buffer(indices.tobytes())
            compiled.begin(self._view, (0, 0, *self.size))
            compiled.draw(buffer, 0, len(indices))
            compiled.forget(buffer)
            buffer.release()
        compiled.release()

    def _render_opaque(self, transmittance: bool) -> None:
        if self._transmittance is transmittance:
            return
        self._transmittance = transmittance
        scene = self.geometry.scene
        self._view.write(view_block(scene.camera, self.size, transmittance))
        background = (1.0, 1.0, 1.0) if transmittance else scene.background
        framebuffer = self.device.context.framebuffer(
            [self.textures["opaque_color"]], self.textures["opaque_depth"]
        )
        framebuffer.use()
        framebuffer.depth_mask = True
        framebuffer.scissor = (0, 0, *self.size)
        framebuffer.clear(*background, 1.0, depth=1.0)
        framebuffer.release()
        self._engine_pass(_OPAQUE, {"color": self.textures["opaque_color"]}, depth=True)

    def _count_fragments(self) -> npt.NDArray[np.int64]:
        """Return the number of visible transparent fragments a pixel, shape (h, w), bottom up."""
        self._render_opaque(transmittance=False)
        texture = self.device.texture(self.size, _COUNT_TARGET.texel)
        framebuffer = self.device.context.framebuffer([texture])
        framebuffer.use()
        self.device.clear(0, _COUNT_TARGET.texel, (0.0,))
        framebuffer.release()
        self._engine_pass(_COUNT, {"count": texture}, depth=False)
        counts = np.frombuffer(texture.read(), dtype=np.float32).reshape(self.size[::-1])
        texture.release()
        return counts.astype(np.int64)

    def sort(self, permutation: int | None = None) -> float:
        """Arrange the geometry for every order that a pass asks for; return milliseconds taken.

        Parameters
        ----------
        permutation : int, optional
            Seed that shuffles what is drawn, within the freedom that each order leaves.
        """
        start = time.perf_counter()
        orders = {step.order for step, _ in self.steps}
        for order in orders:
            self._upload(order, permutation)
        return 1e3 * (time.perf_counter() - start) if orders - {Order.SUBMISSION} else 0.0

    def _upload(self, order: Order, permutation: int | None) -> None:
        batch: Batch = self.geometry.transparent
        indices, units = batch.arrange(order, permutation)
        if order in self._sequences:
            self._sequences[order].indices.write(indices.tobytes())
        else:
            reserve = max(indices.nbytes, 12)
            buffer = self.device.context.buffer(reserve=reserve)
            if len(indices):
                buffer.write(indices.tobytes())
            self._sequences[order] = _Sequence(buffer, units, len(indices))
        old = self._sequences[order]
        self._sequences[order] = _Sequence(old.indices, units, len(indices))

    # -- rendering -----------------------------------------------------------------------------

    def render(self, transmittance: bool = False, permutation: int | None = None) -> None:
        """Render one complete frame; memory that ran out is found, enlarged, and the frame redone.

        Parameters
        ----------
        transmittance : bool
            Show transmittance alone: no radiance over a background of one.
        permutation : int, optional
            Seed that shuffles the draws.
        """
        self._render_opaque(transmittance)
        self.sort(permutation)
        for _ in range(_ATTEMPTS):
            needed = self.issue()
            if needed is None:
                return
            self.resources.reserve(np.maximum(self.resources.demand, needed))
        raise CapabilityError(
            f"{self.method.label}: buffers still overflow after {_ATTEMPTS} frames"
        )

    def issue(self, records: list[PassRecord] | None = None, check: bool = True) -> Counts | None:
        """Issue the frame's draws; return what each tile needs if fragments did not fit.

        Parameters
        ----------
        records : list of PassRecord, optional
            Filled with one entry a pass. Measuring waits after every pass.
        check : bool
            Read back the allocators; a frame that is timed has been checked before.
        """
        context = self.device.context
        context.copy_framebuffer(self._framebuffer_color, self._framebuffer_opaque)
        missing: Counts | None = None
        for region in self.resources.regions:
            scissor = region.scissor(self.size)
            for name, framebuffer in self._clears.items():
                framebuffer.use()
                framebuffer.scissor = scissor
                self.device.clear(0, self.declared[name].texel, self.declared[name].clear)
            self.resources.begin(region)
            self.resources.bind()
            for index, (step, compiled) in enumerate(self.steps):
                self._issue_step(step, compiled, scissor, records, index)
            if check and self.resources.listed:
                needed = self.resources.shortfall(region)
                if needed is not None:
                    missing = needed if missing is None else np.maximum(missing, needed)
        return missing

    def _issue_step(
        self,
        step: Step,
        compiled: list[CompiledPass],
        scissor: tuple[int, int, int, int],
        records: list[PassRecord] | None,
        index: int,
    ) -> None:
        sequence = self._sequences.get(step.order)
        if isinstance(step, Interleaved):
            assert sequence is not None
            for first, count in sequence.units:
                for number, item in enumerate(compiled):
                    with self._measured(item, records, (index, number)):
                        item.begin(self._view, scissor)
                        item.draw(sequence.indices, int(first), int(count))
            return
        (item,) = compiled
        with self._measured(item, records, (index, 0)):
            item.begin(self._view, scissor)
            if item.step.draws is Draws.PIXELS:
                item.draw_screen()
            elif sequence is not None and sequence.triangles:
                item.draw(sequence.indices, 0, sequence.triangles)

    @contextmanager
    def _measured(
        self, item: CompiledPass, records: list[PassRecord] | None, place: tuple[int, int]
    ) -> Iterator[None]:
        """Count and time what happens inside; does nothing without `records`."""
        if records is None:
            yield
            return
        offset = sum(len(compiled) for _, compiled in self.steps[: place[0]]) + place[1]
        while len(records) <= offset:
            records.append(PassRecord(""))
        record = records[offset]
        record.name = item.step.name
        query = self.device.context.query(samples=True)
        self.device.finish()
        start = time.perf_counter()
        with query:
            yield
        self.device.finish()
        record.milliseconds = (record.milliseconds or 0.0) + 1e3 * (time.perf_counter() - start)
        # Early tests count what the scene's shader then discards: with buffers the count is known.
        early = item.step.draws is Draws.FRAGMENTS and bool(item.step.buffers)
        if early:
            record.fragments = int(self.complexity.sum())
        else:
            record.fragments += int(query.samples)
        for key, count in self.resources.take_counts().items():
            record.accesses[key] = record.accesses.get(key, 0) + count

    def image(self) -> Image:
        """Read the frame's color: [h, w, 3], linear, top row first."""
        return self.read("color")[..., :3]

    def read(self, target: str) -> Image:
        """Read a target as float32 [h, w, components], top row first."""
        entry = self.declared[target].texel
        kinds = {"f1": np.uint8, "f2": np.float16, "f4": np.float32, "u4": np.uint32}
        data = np.frombuffer(self.textures[target].read(), dtype=kinds[entry.dtype])
        texels = data.reshape(self.size[1], self.size[0], entry.components)[::-1]
        scale = np.float32(1 / 255 if entry.dtype == "f1" else 1)
        return np.asarray(texels.astype(np.float32) * scale)

    def release(self) -> None:
        """Free the frame's memory on the device."""
        for _, compiled in self.steps:
            for item in compiled:
                item.release()
        for sequence in self._sequences.values():
            sequence.indices.release()
        for framebuffer in (
            *self._clears.values(), self._framebuffer_color, self._framebuffer_opaque
        ):  # fmt: skip
            framebuffer.release()
        for name in ("color", "opaque_color", "opaque_depth"):
            self.textures[name].release()
        self._view.release()
        self.resources.release()


def check_size(device: Device, size: tuple[int, int]) -> None:
    """Raise `UsageError` unless the driver can render a frame of `size`."""
    if min(size) < 1 or max(size) > device.max_side:
        raise UsageError(
            f"size {size[0]}x{size[1]} (sub-pixels included) is outside 1 to {device.max_side},"
            " the driver's limit"
        )


def _runs(when: Effect, effects: Effect) -> bool:
    return when is Effect.NONE or bool(when & effects)


def _running(step: Step, effects: Effect, absent: set[str]) -> Step:
    """Return what is left of `step`: the passes that run, without the `absent` resources."""
    passes = tuple(
        replace(
            p,
            reads=tuple(name for name in p.reads if name not in absent),
            writes={name: blend for name, blend in p.writes.items() if name not in absent},
            buffers=tuple(name for name in p.buffers if name not in absent),
        )
        for p in _passes(step)
        if _runs(p.when, effects)
    )
    if isinstance(step, Pass) and passes:
        return passes[0]
    return Interleaved(passes, step.order)


def _passes(step: Step) -> tuple[Pass, ...]:
    return step.passes if isinstance(step, Interleaved) else (step,)


def _by_tile(counts: npt.NDArray[np.int64], tiles: tuple[int, int]) -> Counts:
    """Sum a per-pixel count over tiles, shape (rows, columns)."""
    rows, columns = tiles
    padded = np.zeros((rows * TILE, columns * TILE), dtype=np.int64)
    padded[: counts.shape[0], : counts.shape[1]] = counts
    return np.asarray(padded.reshape(rows, TILE, columns, TILE).sum(axis=(1, 3)))

"""A method's frame of a scene: its declaration compiled into draws, and those draws issued."""

from __future__ import annotations

import time

import numpy as np
import numpy.typing as npt

from oitbench.effects import Effect
from oitbench.errors import CapabilityError, DeclarationError, UsageError
from oitbench.gl.device import Device
from oitbench.gl.draws.chain import Moved
from oitbench.gl.draws.steps import (
    CompiledStep,
    Drawn,
    Issuer,
    PassRecord,
    Sequence,
    passes_of,
    running,
    runs,
    unneeded,
)
from oitbench.gl.geometry import Geometry
from oitbench.gl.program.passes import Blueprint, attach, compile_pass
from oitbench.gl.program.prelude import TILE, bind
from oitbench.gl.resources import Counts, Resources
from oitbench.gl.shading.backdrop import Backdrop
from oitbench.gl.shading.lighting import Lighting, lighting_of
from oitbench.gl.shading.occlusion import Occlusion, occlusion_of
from oitbench.gl.shading.opaque import DEPTH, count_fragments
from oitbench.gl.view import view_block
from oitbench.method.declaration import Draws, Interleaved, Loop, Method, Order, Pass, Step, Target
from oitbench.plugins import folder_of

Image = npt.NDArray[np.float32]
_ATTEMPTS = 4


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
    mechanism : str, optional
        How programmable blending is done, instead of the best that the driver offers.

    Attributes
    ----------
    complexity : array, shape (h, w), int64
        Visible transparent fragments at each pixel's center, bottom row first.
    mechanism : str or None
        How programmable blending is done; None for a method that needs none.
    lighting : Lighting or None
        None for a scene that is lit by emission alone.
    occlusion : Occlusion or None
        None unless ambient occlusion runs.
    shading_records, shading_moved : list
        What the stages that all methods share did in the last measured frame, and the bytes that
        they moved.

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
        mechanism: str | None = None,
    ) -> None:
        check_size(device, size)
        device.require(method.name, method.requires)
        self.device, self.geometry, self.method, self.size = device, geometry, method, size
        self.effects, self.samples = effects, method.samples
        self.mechanism = self._mechanism(mechanism)
        self.complexity = count_fragments(device, geometry, size, effects)
        self._check_depth()
        spared = unneeded(method.passes, geometry.present)
        targets = {
            k: t.under(effects)
            for k, t in method.targets.items()
            if runs(t.when, effects) and k not in spared
        }
        color = targets.pop("color", Target("rgba16f"))
        if self.mechanism == "spin lock":
            targets["lock"] = Target("r32ui")
        buffers = {
            k: b for k, b in method.buffers.items() if runs(b.when, effects) and k not in spared
        }
        bindings = bind(buffers, counted)
        limit = min(device.max_block_bytes, block_limit or device.max_block_bytes)
        self.resources = Resources(device, size, targets, buffers, bindings, limit, self.samples)
        self.declared: dict[str, Target] = {
            **targets,
            "color": color,
            "opaque_color": color,
            "opaque_depth": DEPTH,
        }
        self._backdrop = Backdrop(
            device, geometry, size, color, self.samples,
            [item for step in method.passes for item in passes_of(step)],
            any(target.single for target in targets.values()),
        )  # fmt: skip
        self.textures = {
            **self.resources.textures,
            **self._backdrop.textures,
            "color": device.texture(size, color.texel, self.samples),
        }
        self.lighting = lighting_of(device, geometry, effects)
        self.occlusion = occlusion_of(device, geometry, size, effects)
        self._blueprint = Blueprint(
            device, geometry, method, folder_of(type(method)), effects, self.declared, buffers,
            bindings, self.samples, self.mechanism or "", self.lighting, self.occlusion,
        )  # fmt: skip
        absent = {*method.targets, *method.buffers} - {*targets, *buffers, "color"}
        left = [running(step, effects, absent, geometry.present) for step in method.passes]
        self.steps = [self._compile(step) for step in left if step is not None]
        if self.resources.listed:
            self.resources.reserve(_by_tile(self.complexity, self.resources.tiles))
        self._view = device.context.buffer(view_block(geometry.scene.camera, size, False))
        sizes = {target.subsample for target in targets.values()} - {1}
        self._views = {1: self._view}
        for subsample in sizes:
            self._views[subsample] = device.context.buffer(self._block(subsample, False))
        self._issuer = Issuer(device, self._views, self.resources)
        self._sequences: dict[Drawn, Sequence] = {}
        self._transmittance: bool | None = None
        self.shading_records: list[PassRecord] = []
        self.shading_moved: list[Moved] = []
        self._framebuffers = {
            name: attach(device, texture, self.declared[name].texel)
            for name, texture in self.textures.items()
            if name in self.declared and name != "opaque_depth"
        }

    # -- preparation ---------------------------------------------------------------------------

    def _check_depth(self) -> None:
        deepest, found = self.method.deepest, int(self.complexity.max())
        if deepest is not None and self.device.limits_loops and found > deepest:
            raise CapabilityError(
                f"{self.method.label}: {found} fragments at one pixel; {self.device.renderer}"
                f" cuts its loops short beyond {deepest}"
            )

    def _mechanism(self, asked: str | None) -> str | None:
        programmable = any(
            blend.programmable
            for step in self.method.passes
            for item in passes_of(step)
            for blend in item.writes.values()
        )
        if not programmable:
            return None
        return asked or self.device.mechanism(self.samples)

    def _block(self, subsample: int, transmittance: bool) -> bytes:
        """Return the bytes of `View` for targets of every `subsample`th pixel."""
        return view_block(self.geometry.scene.camera, self.size, transmittance, subsample)

    def _compile(self, step: Step) -> CompiledStep:
        if isinstance(step, Interleaved) and len({item.objects for item in step.passes}) > 1:
            shaders = " and ".join(item.shader for item in step.passes)
            raise DeclarationError(f"{shaders}: interleaved passes must draw the same objects")
        names = [self.textures]
        if isinstance(step, Loop) and step.swaps:
            traded = {a: self.textures[b] for pair in step.swaps for a, b in (pair, pair[::-1])}
            names.append({**self.textures, **traded})
        rounds = tuple(
            tuple(compile_pass(self._blueprint, item, textures) for item in passes_of(step))
            for textures in names
        )
        return CompiledStep(step, rounds)

    @property
    def passes(self) -> list[Pass]:
        """The passes that run, in order; measured frames have one record for each."""
        return [item.step for compiled in self.steps for item in compiled.rounds[0]]

    def sort(self, permutation: int | None = None) -> float:
        """Arrange the geometry for every order that a pass asks for; return milliseconds taken.

        Parameters
        ----------
        permutation : int, optional
            Seed that shuffles what is drawn, within the freedom that each order leaves.
        """
        start = time.perf_counter()
        wanted = {
            (compiled.step.order, item.step.objects)
            for compiled in self.steps
            for item in compiled.rounds[0]
        }
        for drawn in wanted:
            self._upload(drawn, permutation)
        sorts = any(order is not Order.SUBMISSION for order, _ in wanted)
        return 1e3 * (time.perf_counter() - start) if sorts else 0.0

    def _upload(self, drawn: Drawn, permutation: int | None) -> None:
        order, objects = drawn
        indices, units = self.geometry.batches[objects].arrange(order, permutation)
        known = self._sequences.get(drawn)
        buffer = known.indices if known else self.device.context.buffer(reserve=indices.nbytes + 12)
        if len(indices):
            buffer.write(indices.tobytes())
        self._sequences[drawn] = Sequence(buffer, units, len(indices))

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
        for stage in self.shading:
            stage.prepare()
        if self._transmittance is not transmittance:
            self._backdrop.draw(
                self._view, transmittance, self.lighting, self.effects, self.occlusion
            )
            for subsample, view in self._views.items():
                if subsample > 1:
                    view.write(self._block(subsample, transmittance))
            self._transmittance = transmittance
        self.sort(permutation)
        for _ in range(_ATTEMPTS):
            needed = self.issue(lit=False)
            if needed is None:
                return
            self.resources.reserve(np.maximum(self.resources.demand, needed))
        raise CapabilityError(
            f"{self.method.label}: buffers still overflow after {_ATTEMPTS} frames"
        )

    def issue(
        self, records: list[PassRecord] | None = None, check: bool = True, lit: bool = True
    ) -> Counts | None:
        """Issue the frame's draws; return what each tile needs if fragments did not fit.

        Parameters
        ----------
        records : list of PassRecord, optional
            Filled with one entry a pass. Measuring waits after every draw.
        check : bool
            Read back the allocators; a frame that is timed has been checked before.
        lit : bool
            Draw the stages of shading too; they stay the same from frame to frame.
        """
        context, resources = self.device.context, self.resources
        resources.take_counts()
        resources.asked = 0
        if lit:
            self._shade(records is not None)
        # The scissor of the last region still stands, and would clip the copy.
        self._framebuffers["color"].use()
        self._framebuffers["color"].scissor = (0, 0, *self.size)
        context.copy_framebuffer(self._framebuffers["color"], self._framebuffers["opaque_color"])
        missing: Counts | None = None
        for region in resources.regions:
            scissor = region.scissor(self.size)
            for name, target in resources.targets.items():
                self._framebuffers[name].use()
                whole = (0, 0, *target.size(self.size))
                self._framebuffers[name].scissor = scissor if target.subsample == 1 else whole
                self.device.clear(0, target.texel, target.clear)
            resources.begin(region)
            resources.bind()
            self._issuer.issue(self.steps, self._sequences, scissor, records)
            if resources.listed and (check or records is not None):
                needed = resources.shortfall(region)
                if needed is not None:
                    missing = needed if missing is None else np.maximum(missing, needed)
        for step, record in zip(self.passes, records or (), strict=False):
            # Early tests count what the scene's shader then discards; buffers know better.
            if step.draws is Draws.FRAGMENTS and step.buffers:
                known = resources.asked if resources.listed else int(self.complexity.sum())
                record.fragments = known * record.runs if not resources.listed else known
        return missing

    def _shade(self, measured: bool) -> None:
        """Issue what all methods share."""
        if measured:
            self.shading_records, self.shading_moved = [], []
        for stage in self.shading:
            if measured:
                records, moved = stage.measure()
                self.shading_records += records
                self.shading_moved += moved
            else:
                stage.issue()

    @property
    def shading(self) -> tuple[Lighting | Occlusion, ...]:
        """The stages that all methods share, in order."""
        return tuple(s for s in (self.lighting, self.occlusion) if s is not None)

    def image(self) -> Image:
        """Read the frame's color: [h, w, 3], linear, top row first; samples are averaged."""
        return self.read("color")[..., :3]

    def read(self, target: str) -> Image:
        """Read a target as float32 [h, w, components], top row first; samples are averaged."""
        entry, size = self.declared[target].texel, self.declared[target].size(self.size)
        texture = self.textures[target]
        several = self.samples > 1 and not self.declared[target].single
        if several:
            texture = self.device.texture(size, entry)
            framebuffer = attach(self.device, texture, entry)
            framebuffer.use()  # without a scissor
            self.device.context.copy_framebuffer(framebuffer, self._framebuffers[target])
            framebuffer.release()
        if entry.name.endswith("snorm"):
            raise UsageError(f"target {target}: {entry.name} cannot be read; choose half floats")
        kinds = {"f1": np.uint8, "f2": np.float16, "f4": np.float32, "u4": np.uint32}
        data = np.frombuffer(texture.read(), dtype=kinds[entry.dtype])
        texels = data.reshape(size[1], size[0], entry.components)[::-1]
        if several:
            texture.release()
        scale = np.float32(1 / 255 if entry.dtype == "f1" else 1)
        return np.asarray(texels.astype(np.float32) * scale)

    def release(self) -> None:
        """Free the frame's memory on the device."""
        for compiled in self.steps:
            compiled.release()
        for sequence in self._sequences.values():
            sequence.indices.release()
        for framebuffer in self._framebuffers.values():
            framebuffer.release()
        self._backdrop.release()
        self.textures["color"].release()
        for view in self._views.values():
            view.release()
        if self.occlusion is not None:
            self.occlusion.release()
        self.resources.release()


def check_size(device: Device, size: tuple[int, int]) -> None:
    """Raise `UsageError` unless the driver can render a frame of `size`."""
    if min(size) < 1 or max(size) > device.max_side:
        raise UsageError(
            f"size {size[0]}x{size[1]} (sub-pixels included) is outside 1 to {device.max_side},"
            " the driver's limit"
        )


def _by_tile(counts: npt.NDArray[np.int64], tiles: tuple[int, int]) -> Counts:
    """Sum a per-pixel count over tiles, shape (rows, columns)."""
    rows, columns = tiles
    padded = np.zeros((rows * TILE, columns * TILE), dtype=np.int64)
    padded[: counts.shape[0], : counts.shape[1]] = counts
    return np.asarray(padded.reshape(rows, TILE, columns, TILE).sum(axis=(1, 3)))

"""A method's frame of a scene, ready to be rendered again and again."""

from __future__ import annotations

from collections.abc import Hashable

import moderngl
import numpy as np
import numpy.typing as npt

from oitbench.effects import SHADING, Effect
from oitbench.errors import CapabilityError
from oitbench.gl.draws.chain import Measurement
from oitbench.gl.draws.executor import CompiledStep, Executor
from oitbench.gl.draws.orders import DrawOrders
from oitbench.gl.draws.records import FrameMeasurement, Lap, PassRecord, no_lap
from oitbench.gl.limits import check_loops, check_size
from oitbench.gl.ownership import Owner
from oitbench.gl.plan import FramePlan
from oitbench.gl.program.compiled_pass import CompiledPass
from oitbench.gl.program.passes import Blueprint, attach, compile_pass
from oitbench.gl.program.shading_inputs import UNLIT
from oitbench.gl.readback import read_averaged, read_texels
from oitbench.gl.resources import Resources
from oitbench.gl.shading.backdrop import Backdrop
from oitbench.gl.shading.lighting import Lighting
from oitbench.gl.shading.occlusion import Occlusion, occludes
from oitbench.gl.tiling import Counts, sum_by_tile
from oitbench.gl.uploaded_scene import UploadedScene
from oitbench.image.values import Values
from oitbench.method.declaration import Method
from oitbench.method.passes import (
    OPAQUE_COLOR,
    OPAQUE_DEPTH,
    Gather,
    Loop,
    Objects,
    Pass,
    Step,
)
from oitbench.method.steps import passes_of, read_per_sample

Image = npt.NDArray[np.float32]
_ATTEMPTS = 4
START = "start of the frame"
"""The part of a timed frame before its first pass: copies, clears and buffers."""


class Frame(Owner):
    """One method on one scene at one size.

    Parameters
    ----------
    scene : UploadedScene
    method : Method
    size : (int, int)
        Width and height in pixels, including sub-pixels.
    effects : Effect
        Running effects: requested by the scene and expressed by the method.
    counted : bool
        Count every access to a buffer: slower, same image.
    block_limit : int, optional
        Largest storage block in bytes. Default: the driver's limit.
    mechanism : str, optional
        Way of programmable blending. Default: the best that the driver offers.

    Attributes
    ----------
    plan : FramePlan
    complexity : array, shape (h, w), int64
        Visible transparent fragments at each pixel's center, bottom row first.
    orders : DrawOrders
        `sort` of it is a part of every frame.
    resources : Resources
    textures : dict of str to moderngl.Texture
        Texture of every target, including those of the frame itself.
    lighting : Lighting or None
        None for a scene that is lit by emission alone.
    occlusion : Occlusion or None
        None unless ambient occlusion runs.

    Raises
    ------
    CapabilityError
        The driver lacks a capability that the method requires.
    DeclarationError
        The declaration is inconsistent or a shader does not compile.
    UsageError
        The size exceeds the driver's limit.
    """

    def __init__(
        self,
        scene: UploadedScene,
        method: Method,
        size: tuple[int, int],
        effects: Effect = Effect.NONE,
        *,
        counted: bool = False,
        block_limit: int | None = None,
        mechanism: str | None = None,
    ) -> None:
        super().__init__()
        device = scene.device
        check_size(device, size)
        device.require(method.name, method.requires)
        self.device, self.scene = device, scene
        self.plan = FramePlan.of(
            method,
            size,
            effects,
            particles=scene.geometry.has(Objects.PARTICLES),
            others=scene.geometry.has(Objects.OTHERS),
            mechanism=mechanism or device.mechanism,
            counted=counted,
        )
        device.within(f"{method.label} (samples per pixel)", self.plan.samples, "GL_MAX_SAMPLES")
        if scene.geometry.coincident and self.plan.samples > 1:
            one, other = scene.geometry.coincident
            raise CapabilityError(
                f"{method.label}: {one} and {other} lie in one plane; give one sample per pixel"
            )
        self._method, self._camera = method, scene.geometry.scene.camera
        self._count()
        self._transmittance: bool | None = None
        with self.building(), device.checked(self._owner):
            self._build(block_limit)

    @property
    def _owner(self) -> str:
        width, height = self.plan.size
        return f"{self.plan.label} at {width}x{height}"

    def _build(self, block_limit: int | None) -> None:
        device, plan, geometry = self.device, self.plan, self.scene.geometry
        self._views = {
            subsample: self.own(device.context.buffer(self._view_block(subsample, False)))
            for subsample in sorted(plan.subsamples)
        }
        self.lighting = self.scene.lighting(plan.effects)
        shading = self.lighting.inputs(plan.effects) if self.lighting else UNLIT
        self.occlusion: Occlusion | None = None
        if occludes(self.scene.scene, plan.effects):
            self.occlusion = self.own(Occlusion(device, geometry, plan.size))
            shading = shading.with_occlusion(self.occlusion.samplers)
        self.resources = self.own(Resources(device, plan, block_limit))
        self._backdrop = self.own(Backdrop(device, geometry, plan, self._views[1], shading))
        color = self.own(device.texture(plan.size, plan.color.texel, plan.samples))
        self.textures = {**self.resources.textures, **self._backdrop.textures, "color": color}
        self._framebuffers = {
            name: self.own(attach(device, self.textures[name], target.texel))
            for name, target in plan.declared.items()
            if name != OPAQUE_DEPTH
        }
        blueprint = Blueprint(
            plan.label, plan.declared, plan.buffers, plan.bindings, plan.folders, plan.macros,
            plan.effects, shading, plan.samples, plan.mechanism or "",
            read_per_sample(plan.passes, plan.declared),
        )  # fmt: skip
        self.orders = self.own(DrawOrders(device.context, geometry, plan.passes))
        self._steps = [self._compile(blueprint, step) for step in plan.steps]
        resources = self.resources
        self._executor = Executor(
            device, self._views, resources.copy, resources.take_counts, resources.texels
        )
        self.resources.reserve(sum_by_tile(self.complexity, self.resources.tiles))

    def _count(self) -> None:
        """Count the fragments, and refuse more of them than the driver's loops can have steps."""
        self.complexity = self.scene.fragment_counts(self.plan.size, self.plan.effects)
        check_loops(self.device, self._method, int(self.complexity.max()))

    def _follow(self) -> None:
        """Look from the camera where it is now, if it has moved since the last frame."""
        camera = self.scene.geometry.scene.camera
        if camera is self._camera:
            return
        self._camera, self._transmittance = camera, None
        self._count()
        self.resources.reserve(sum_by_tile(self.complexity, self.resources.tiles))
        if self.occlusion is not None:
            self.occlusion.follow()

    def _view_block(self, subsample: int, transmittance: bool) -> bytes:
        """Return the bytes of `View` for targets that are downsampled by `subsample`."""
        return self.scene.geometry.view(self.plan.size, transmittance, subsample)

    def _compile(self, blueprint: Blueprint, step: Step) -> CompiledStep:
        rounds = [self.textures]
        if isinstance(step, Loop) and step.swaps:
            traded = {a: self.textures[b] for pair in step.swaps for a, b in (pair, pair[::-1])}
            rounds.append({**self.textures, **traded})
        compiled = [
            [self._compile_pass(blueprint, item, textures) for item in passes_of(step)]
            for textures in rounds
        ]
        return CompiledStep(step, tuple(map(tuple, compiled)))

    def _compile_pass(
        self, blueprint: Blueprint, step: Pass, textures: dict[str, moderngl.Texture]
    ) -> CompiledPass:
        draws = (step.order, step.objects) if isinstance(step, Gather) else None
        geometry = self.scene.geometry
        return self.own(compile_pass(self.device, geometry, blueprint, step, textures, draws))

    @property
    def shading(self) -> tuple[Lighting | Occlusion, ...]:
        """The stages that all methods share, in order."""
        return tuple(stage for stage in (self.lighting, self.occlusion) if stage is not None)

    @property
    def shading_key(self) -> Hashable:
        """A key that frames with equal work in `shade` share; None if they do nothing there."""
        if not self.shading:
            return None
        return (self.lighting, self.occlusion is not None, self.plan.effects & SHADING)

    @property
    def backdrop_key(self) -> Hashable:
        """A key that frames with equal work in `draw_backdrop` share."""
        return (self.shading_key, self.plan.color.format, self.plan.samples)

    def render(self, transmittance: bool = False, permutation: int | None = None) -> None:
        """Render one complete frame. If memory for records runs out, it is enlarged first.

        Parameters
        ----------
        transmittance : bool
            Render transmittance only: no radiance, over a background of one.
        permutation : int, optional
            Seed that shuffles the draws, within the freedom that each order leaves.

        Raises
        ------
        CapabilityError
            The records of a tile exceed the driver's limit, or the driver reports an error.
        """
        with self.device.checked(self._owner):
            self._prepare(transmittance, permutation)
            self._draw_all()

    def _prepare(self, transmittance: bool, permutation: int | None) -> None:
        """Bring everything that precedes the method's own work up to date."""
        self._follow()
        for stage in self.shading:
            stage.prepare()
        if self._transmittance is not transmittance:
            for subsample, view in self._views.items():
                view.write(self._view_block(subsample, transmittance))
            self._backdrop.draw(transmittance)
            self._backdrop.derive()
            self._transmittance = transmittance
        self.orders.arrange(permutation)

    def _draw_all(self, counted: bool = False) -> list[PassRecord]:
        """Draw until all fragments fit into the memory, which is enlarged between the attempts.

        Returns
        -------
        list of PassRecord
            One per pass of the plan, of the last attempt; empty unless `counted`.
        """
        for _ in range(_ATTEMPTS):
            records = [PassRecord(item.name) for item in self.plan.passes] if counted else []
            self.restore()
            needed = self._draw(records or None, check=True)
            if needed is None:
                return records
            self.resources.reserve(np.maximum(self.resources.demand, needed))
        raise CapabilityError(f"{self.plan.label}: buffers still overflow after {_ATTEMPTS} frames")

    def shade(self, lap: Lap = no_lap) -> None:
        """Issue the shading that all methods share: shadow maps and ambient occlusion.

        `lap` ends each part.
        """
        for stage in self.shading:
            stage.issue(lap)

    def draw_backdrop(self) -> None:
        """Issue the opaque picture. The frame must have been rendered before."""
        self._backdrop.draw(bool(self._transmittance))

    def restore(self) -> None:
        """Copy the opaque picture to `color`, where the method's passes find it."""
        color = self._framebuffers["color"]
        # The scissor of the last region is still set, and would clip the copy.
        color.use()
        color.scissor = (0, 0, *self.plan.size)
        self.device.context.copy_framebuffer(color, self._framebuffers[OPAQUE_COLOR])

    def composite(self, lap: Lap = no_lap) -> None:
        """Issue everything that the method draws in a frame, over the opaque picture in `color`.

        The frame must have been rendered, and `restore`d since then. `lap` ends each part: `START`,
        and the passes by their place in the plan (see `FramePlan.parts`).
        """
        if self.plan.copies_color:
            self.restore()
        self._backdrop.derive()
        self._draw(None, check=False, lap=lap)

    def measure(self) -> FrameMeasurement:
        """Render one complete frame, and count the work of each pass.

        Raises
        ------
        CapabilityError
            As `render` does.
        """
        shading = Measurement()
        with self.device.checked(self._owner):
            self._prepare(transmittance=False, permutation=None)
            for stage in self.shading:
                stage.measure(shading)
            records = self._draw_all(counted=True)
        for item, record in zip(self.plan.passes, records, strict=True):
            if isinstance(item, Gather) and item.buffers:
                # Stored fragments are counted by their allocator, or once per run.
                listed = bool(self.plan.listed)
                fragments = int(self.complexity.sum()) * record.runs
                record.fragments = self.resources.requested if listed else fragments
        return FrameMeasurement(records, list(shading.records.values()), shading.terms)

    def _draw(
        self, records: list[PassRecord] | None, check: bool, lap: Lap = no_lap
    ) -> Counts | None:
        """Clear targets and buffers, and issue all passes of all frames whose mean is the image.

        Returns
        -------
        array or None
            Records that each tile needs, if `check` found that some did not fit.
        """
        self.resources.take_counts()
        self.resources.requested = 0
        missing: Counts | None = None
        for number in range(self.plan.frames):
            if number:
                self._executor.set_frame(number)
                self.restore()
            needed = self._draw_frame(number, records, check, lap)
            if needed is not None:
                missing = needed if missing is None else np.maximum(missing, needed)
        if self.plan.frames > 1:
            self._executor.set_frame(0)
        return missing

    def _draw_frame(
        self, number: int, records: list[PassRecord] | None, check: bool, lap: Lap
    ) -> Counts | None:
        """Draw one of the frames; see `_draw`."""
        resources, size = self.resources, self.plan.size
        missing: Counts | None = None
        for region in resources.regions:
            scissor = region.scissor(size)
            for name, target in self.plan.targets.items():
                if number >= self.plan.clears(name):
                    continue
                self._framebuffers[name].use()
                whole = (0, 0, *target.size(size))
                self._framebuffers[name].scissor = scissor if target.subsample == 1 else whole
                self.device.clear(0, target.texel, target.clear)
            resources.begin(region)
            resources.bind()
            lap(START)
            self._executor.issue(self._steps, self.orders.uploaded, scissor, records, lap)
            if self.plan.listed and check:
                needed = resources.shortfall(region)
                if needed is not None:
                    missing = needed if missing is None else np.maximum(missing, needed)
        return missing

    def image(self) -> Image:
        """Return the color, shape (h, w, 3), linear, top row first; samples are averaged."""
        return self.read("color")[..., :3]

    def read(self, target: str) -> Image:
        """Return a target, shape (h, w, components), float32, top row first; samples are averaged.

        Raises
        ------
        UsageError
            The target has several samples per pixel and a format that has no mean.
        """
        return self.texels(target).astype(np.float32, copy=False)

    def texels(self, target: str) -> Values:
        """Return a target as `read` does; integers stay integers, uint32."""
        declared = self.plan.declared[target]
        entry, size = declared.texel, declared.size(self.plan.size)
        if self.plan.samples_of(target) == 1:
            return read_texels(self.device, self.textures[target], size, entry)
        framebuffer = self._framebuffers.get(target)
        return read_averaged(self.device, target, framebuffer, size, entry)

"""One pass, compiled: program, framebuffer, textures and every piece of state that it needs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import moderngl

from oitbench.effects import Effect
from oitbench.errors import CapabilityError, DeclarationError, unknown
from oitbench.gl.device import Device
from oitbench.gl.geometry import VERTEX, VERTEX_FORMAT, Geometry
from oitbench.gl.program import prelude
from oitbench.gl.program.prelude import Bindings
from oitbench.gl.program.source import Source
from oitbench.method.declaration import Buffer, Draws, Method, Pass, Target
from oitbench.method.formats import Format

if TYPE_CHECKING:
    from oitbench.gl.shading.lighting import Lighting
    from oitbench.gl.shading.occlusion import Occlusion

Sampled = moderngl.Texture | moderngl.TextureArray | moderngl.Texture3D

_OPAQUE = "opaque_depth"
"""What passes of fragments test, where there is one and they name no other."""


@dataclass(frozen=True)
class Blueprint:
    """What all passes of one frame are compiled from.

    Parameters
    ----------
    folder : Path, optional
        Where the method's shaders are; None for the engine's own passes.
    declared : mapping of str to Target
        All targets that exist, the frame's own included.
    buffers : mapping of str to Buffer
    bindings : Bindings
    samples : int
        Samples a pixel.
    mechanism : str
        How programmable blending is done.
    lighting : Lighting, optional
        What shades; without it nothing is lit.
    occlusion : Occlusion, optional
        What hides the environment from surfaces; without it nothing does.
    """

    device: Device
    geometry: Geometry
    method: Method
    folder: Path | None
    effects: Effect
    declared: Mapping[str, Target]
    buffers: Mapping[str, Buffer]
    bindings: Bindings
    samples: int = 1
    mechanism: str = prelude.FETCH
    lighting: Lighting | None = None
    occlusion: Occlusion | None = None


class CompiledPass:
    """A pass that can be drawn. `begin` sets all of its state; none is trusted to be left over.

    `clears` are the framebuffer, format and value of each target to clear just before; `subsample`
    is that of the targets that it writes.
    """

    def __init__(
        self,
        device: Device,
        step: Pass,
        program: moderngl.Program,
        framebuffer: moderngl.Framebuffer,
        samplers: Mapping[str, Sampled],
        images: Sequence[moderngl.Texture],
        vertices: moderngl.Buffer,
        depth_writes: bool,
        blocks: Mapping[int, moderngl.Buffer],
        subsample: int = 1,
    ) -> None:
        self.device, self.step, self.program = device, step, program
        self.framebuffer, self.samplers, self.vertices = framebuffer, samplers, vertices
        self.images, self.depth_writes, self.blocks = images, depth_writes, blocks
        self.subsample = subsample
        self.clears: list[tuple[moderngl.Framebuffer, Format, tuple[float, ...]]] = []
        self._arrays: dict[int, moderngl.VertexArray] = {}

    def begin(self, view: moderngl.Buffer, scissor: tuple[int, int, int, int]) -> None:
        """Set framebuffer, depth, blend, samplers and uniform blocks."""
        device, context = self.device, self.device.context
        self.framebuffer.use()
        self.framebuffer.scissor = scissor
        self.framebuffer.depth_mask = self.depth_writes
        geometry = self.step.draws is Draws.FRAGMENTS
        # Blending stays on also where it replaces: with blending, depth test and discard all off,
        # llvmpipe drops the side effects of primitives that a later one covers.
        depth = geometry or self.step.depth is not None
        context.enable_only(moderngl.BLEND | (moderngl.DEPTH_TEST if depth else 0))
        context.depth_func = "<" if geometry else "1"
        for slot, blend in enumerate(self.step.writes.values()):
            device.set_blend(slot, blend)
        for unit, texture in enumerate(self.samplers.values()):
            texture.use(unit)
        for unit, image in enumerate(self.images):
            image.bind_to_image(unit, read=True, write=True)
        view.bind_to_uniform_block(0)
        for binding, block in self.blocks.items():
            block.bind_to_uniform_block(binding)
        if self.step.buffers or self.images:
            context.memory_barrier()

    def draw(self, indices: moderngl.Buffer, first: int, count: int) -> None:
        """Draw `count` triangles of `indices` from the triangle `first` on."""
        array = self._arrays.get(indices.glo)
        if array is None:
            array = self.device.context.vertex_array(
                self.program,
                [(self.vertices, VERTEX_FORMAT, *(VERTEX.names or ()))],
                index_buffer=indices,
                skip_errors=True,
            )
            self._arrays[indices.glo] = array
        array.render(moderngl.TRIANGLES, vertices=3 * count, first=3 * first)
        self._end()

    def draw_screen(self) -> None:
        """Draw one triangle over the frame."""
        if 0 not in self._arrays:
            self._arrays[0] = self.device.context.vertex_array(self.program, [])
        self._arrays[0].render(moderngl.TRIANGLES, vertices=3)
        self._end()

    def _end(self) -> None:
        # What was stored in images is next read as textures, copied, or read back.
        if self.images:
            self.device.context.memory_barrier()

    def forget(self, indices: moderngl.Buffer) -> None:
        """Drop what was kept for an index buffer that is about to be released."""
        array = self._arrays.pop(indices.glo, None)
        if array is not None:
            array.release()

    def release(self) -> None:
        """Free what this pass owns; its program is kept by the device for the next frame."""
        for array in self._arrays.values():
            array.release()
        self.framebuffer.release()
        for framebuffer, _, _ in self.clears:
            framebuffer.release()


def compile_pass(
    blueprint: Blueprint,
    step: Pass,
    textures: Mapping[str, moderngl.Texture],
    depth_writes: bool = False,
) -> CompiledPass:
    """Assemble the shaders of `step`, compile them, and gather the state of its draws.

    Parameters
    ----------
    blueprint : Blueprint
    step : Pass
    textures : mapping of str to moderngl.Texture
        What each target's name stands for in this pass.
    depth_writes : bool
        Whether the opaque depth is written: for the opaque picture itself.

    Raises
    ------
    DeclarationError
        A name is not declared, or a shader does not compile; the message gives file and line.
    """
    device, geometry = blueprint.device, blueprint.geometry
    subsample = _subsample(step, blueprint.declared)
    vertex, fragment = _sources(blueprint, step)
    images = _images(blueprint, step, textures)
    colors = [] if images else [textures[name] for name in step.writes]
    limit = device.max_images if images else device.max_targets
    if len(images or colors) > limit:
        raise CapabilityError(
            f"{blueprint.method.label}: {step.shader} writes {len(images or colors)} targets;"
            f" {device.renderer} allows {limit}"
        )
    program = _program(device, vertex, fragment)
    samplers: dict[str, Sampled] = {f"{name}_texture": textures[name] for name in step.reads}
    lighting = blueprint.lighting
    if step.draws is Draws.FRAGMENTS:
        if "opaque_depth" in step.reads:
            samplers["opaque_depth_texture"] = textures["opaque_depth_copy"]
        samplers.update(geometry.textures)
    if lighting is not None:
        samplers.update(lighting.textures)
    if blueprint.occlusion is not None:
        samplers.update(blueprint.occlusion.textures)
    used = {name: item for name, item in samplers.items() if name in program}
    for unit, name in enumerate(used):
        # A program is shared by frames, but its samplers always come in this order.
        program[name] = unit
    depth = None
    # A framebuffer must have something, also where the pass writes nothing but buffers.
    own = step.depth or step.tests or _OPAQUE
    fragments = step.draws is Draws.FRAGMENTS and own in blueprint.declared
    if fragments or own != _OPAQUE or not colors:
        centers = blueprint.samples > 1 and prelude.single(step, blueprint.declared)
        depth = textures["opaque_depth_single" if centers and own == _OPAQUE else own]
    try:
        framebuffer = device.context.framebuffer(colors, depth)
    except moderngl.Error as error:
        formats = ", ".join(blueprint.declared[name].format for name in step.writes)
        raise CapabilityError(
            f"{blueprint.method.label}: {device.renderer} cannot render to {formats} ({error})"
        ) from error
    writes_depth = depth_writes or step.depth is not None
    compiled = CompiledPass(
        device, step, program, framebuffer, used, images, geometry.vertices, writes_depth,
        {} if lighting is None else lighting.blocks, subsample,
    )  # fmt: skip
    for name in step.clears:
        target = blueprint.declared[name]
        place = attach(device, textures[name], target.texel)
        compiled.clears.append((place, target.texel, target.clear))
    return compiled


def _subsample(step: Pass, declared: Mapping[str, Target]) -> int:
    """Return the `subsample` of all that the pass writes and tests; raise unless there is one."""
    depths = [name for name in (step.depth, step.tests) if name is not None]
    if len(depths) > 1 or (step.tests is not None and step.draws is Draws.PIXELS):
        raise DeclarationError(
            f"{step.shader}: `tests` is for passes of fragments that have no `depth`"
        )
    if not depths and step.draws is Draws.FRAGMENTS and _OPAQUE in declared:
        depths = [_OPAQUE]
    for name in {*step.writes, *depths} - {*declared}:
        raise DeclarationError(f"{step.shader}: {unknown('target', name, declared)}")
    for name in {*depths} & {*step.reads} - {_OPAQUE}:
        raise DeclarationError(f"{step.shader}: reads and tests '{name}' in one pass")
    kinds = {name: declared[name].subsample for name in (*step.writes, *depths)}
    if len({*kinds.values()}) > 1:
        told = ", ".join(f"{name} 1/{kind}" for name, kind in kinds.items())
        raise DeclarationError(f"{step.shader}: all targets of a pass must have one size: {told}")
    subsample = next(iter(kinds.values()), 1)
    if subsample > 1 and step.buffers:
        raise DeclarationError(f"{step.shader}: a pass that touches buffers must be of full size")
    return subsample


def _images(
    blueprint: Blueprint, step: Pass, textures: Mapping[str, moderngl.Texture]
) -> list[moderngl.Texture]:
    """Return the images that stand in for targets where shaders blend without fetching."""
    programmable = any(blend.programmable for blend in step.writes.values())
    if not programmable or blueprint.mechanism == prelude.FETCH:
        return []
    locks = ["lock"] if blueprint.mechanism == prelude.SPIN_LOCK else []
    return [textures[name] for name in (*step.writes, *locks)]


def attach(device: Device, texture: moderngl.Texture, entry: Format) -> moderngl.Framebuffer:
    """Return a framebuffer of one texture, be it of color or of depth."""
    if entry.depth:
        return device.context.framebuffer([], texture)
    return device.context.framebuffer([texture])


def _sources(blueprint: Blueprint, step: Pass) -> tuple[Source, Source]:
    """Return the vertex and the fragment shader of `step`."""
    mechanism = blueprint.mechanism
    samples = 1 if prelude.single(step, blueprint.declared) else blueprint.samples
    extensions = prelude.extensions(step, mechanism, samples)
    fragment = Source(blueprint.folder, extensions=extensions)
    fragment.add_text("prelude (macros)", prelude.macros(blueprint.method, blueprint.effects))
    fragment.add_text("prelude (pass)", prelude.defines(step))
    fragment.add_file("view.glsl")
    lighting = blueprint.lighting
    detailed = step.draws is Draws.FRAGMENTS and "surface_materials" in blueprint.geometry.textures
    if lighting is not None or detailed:
        fragment.add_text("prelude (lights)", lighting.macros if lighting else prelude.NO_LIGHTS)
        fragment.add_file("lighting.glsl")
        shadows = lighting.visibility if lighting else prelude.NO_SHADOWS
        fragment.add_text("prelude (shadows)", shadows)
    declarations = (
        prelude.outputs(step, blueprint.declared, mechanism),
        prelude.reads(step, blueprint.declared, blueprint.samples),
        prelude.indexed(step, blueprint.declared),
        prelude.accessors(step, blueprint.buffers, blueprint.bindings, samples),
    )
    fragment.add_text("prelude (declarations)", "\n".join(declarations))
    vertex = Source(None)
    if step.draws is Draws.FRAGMENTS:
        geometry = blueprint.geometry
        fragment.add_text("prelude (scene)", geometry.macros)
        if detailed:
            fragment.add_file("shading.glsl")
            if blueprint.occlusion is not None:
                fragment.add_file("inferred_occlusion.glsl")
        fragment.add_file("fragment.glsl")
        fragment.add_file(step.shader)
        fragment.add_text("prelude (deliver)", prelude.deliver(step, mechanism))
        fragment.add_file("lists.frag.glsl" if geometry.scene.lists else "surface.frag.glsl")
        vertex.add_text("prelude (scene)", geometry.macros)
        vertex.add_file("view.glsl")
        vertex.add_file("surface.vert.glsl")
    else:
        if lighting is not None and Effect.VOLUME in blueprint.effects:
            fragment.add_text("prelude (medium)", lighting.fog.macros)
        fragment.add_file(step.shader)
        # Reads of buffers give helper lanes zero, and a list of them would never end.
        fragment.add_text("main", "void main() { if (!gl_HelperInvocation) { resolve(); } }")
        vertex.add_file("screen.vert.glsl")
    return vertex, fragment


def _program(device: Device, vertex: Source, fragment: Source) -> moderngl.Program:
    key = (vertex.text, fragment.text)
    program = device.programs.get(key)
    if program is None:
        try:
            program = device.context.program(vertex.text, fragment.text)
        except moderngl.Error as error:
            log = str(error)
            source = vertex if "vertex_shader" in log else fragment
            raise DeclarationError(source.explain(log)) from error
        device.programs[key] = program
    return program

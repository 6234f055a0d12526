"""One pass, compiled: program, framebuffer, textures and every piece of state that it needs."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import moderngl

from oitbench.declare import Buffer, Draws, Method, Pass, Target
from oitbench.effects import Effect
from oitbench.errors import DeclarationError
from oitbench.gl import prelude
from oitbench.gl.device import Device
from oitbench.gl.geometry import VERTEX, VERTEX_FORMAT, Geometry
from oitbench.gl.prelude import Bindings
from oitbench.gl.source import Source


class CompiledPass:
    """A pass that can be drawn. All of its state is set by `begin`; none is trusted to be left over."""

    def __init__(
        self,
        device: Device,
        step: Pass,
        program: moderngl.Program,
        framebuffer: moderngl.Framebuffer,
        samplers: Mapping[str, moderngl.Texture | moderngl.TextureArray],
        vertices: moderngl.Buffer,
        depth_writes: bool,
    ) -> None:
        self.device, self.step, self.program = device, step, program
        self.framebuffer, self.samplers, self.vertices = framebuffer, samplers, vertices
        self.depth_writes = depth_writes
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
        context.enable_only(moderngl.BLEND | (moderngl.DEPTH_TEST if geometry else 0))
        context.depth_func = "<"
        for slot, blend in enumerate(self.step.writes.values()):
            device.set_blend(slot, blend)
        for unit, texture in enumerate(self.samplers.values()):
            texture.use(unit)
        view.bind_to_uniform_block(0)
        if self.step.buffers:
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

    def draw_screen(self) -> None:
        """Draw one triangle over the frame."""
        if 0 not in self._arrays:
            self._arrays[0] = self.device.context.vertex_array(self.program, [])
        self._arrays[0].render(moderngl.TRIANGLES, vertices=3)

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


def compile_pass(
    device: Device,
    step: Pass,
    folder: Path | None,
    method: Method,
    effects: Effect,
    geometry: Geometry,
    declared: Mapping[str, Target],
    textures: Mapping[str, moderngl.Texture],
    buffers: Mapping[str, Buffer],
    bindings: Bindings,
    depth_writes: bool = False,
) -> CompiledPass:
    """Assemble the shaders of `step`, compile them, and gather the state of its draws.

    Raises
    ------
    DeclarationError
        A name is not declared, or a shader does not compile; the message gives file and line.
    """
    fragment = Source(folder)
    fragment.add_text("prelude (macros)", prelude.macros(method, effects))
    fragment.add_file("view.glsl")
    declarations = (
        prelude.outputs(step, declared),
        prelude.reads(step, declared),
        prelude.accessors(step, buffers, bindings),
    )
    fragment.add_text("prelude (declarations)", "\n".join(declarations))
    samplers: dict[str, moderngl.Texture | moderngl.TextureArray] = {
        f"{name}_texture": textures[name] for name in step.reads
    }
    vertex = Source(None)
    if step.draws is Draws.FRAGMENTS:
        fragment.add_text("prelude (scene)", geometry.macros)
        fragment.add_file("fragment.glsl")
        fragment.add_file(step.shader)
        fragment.add_file("lists.frag.glsl" if geometry.scene.lists else "surface.frag.glsl")
        vertex.add_text("prelude (scene)", geometry.macros)
        vertex.add_file("view.glsl")
        vertex.add_file("surface.vert.glsl")
        samplers.update(geometry.textures)
    else:
        fragment.add_file(step.shader)
        # Reads of buffers give helper lanes zero, and a list of them would never end.
        fragment.add_text("main", "void main() { if (!gl_HelperInvocation) { resolve(); } }")
        vertex.add_file("screen.vert.glsl")
    program = _program(device, vertex, fragment)
    used = {name: item for name, item in samplers.items() if name in program}
    for unit, name in enumerate(used):
        # A program is shared by frames, but its samplers always come in this order.
        program[name] = unit
    colors = [textures[name] for name in step.writes]
    depth = textures["opaque_depth"] if step.draws is Draws.FRAGMENTS else None
    framebuffer = (
        device.context.framebuffer(colors, depth)
        if colors or depth is not None
        else device.context.simple_framebuffer(textures["color"].size)
    )
    return CompiledPass(device, step, program, framebuffer, used, geometry.vertices, depth_writes)


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

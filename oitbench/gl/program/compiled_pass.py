"""One compiled pass: program, framebuffer, textures and every piece of state that it needs."""

from __future__ import annotations

from collections.abc import Hashable, Mapping, Sequence

import moderngl

from oitbench.gl.device import Device
from oitbench.gl.geometry import FACTORS, FACTORS_FORMAT, VERTEX, VERTEX_FORMAT, Geometry
from oitbench.gl.ownership import Owner
from oitbench.gl.planes import PLANE_FORMAT, PLANE_NAME
from oitbench.gl.program.bindings import VIEW_BINDING
from oitbench.gl.program.shading_inputs import Sampled
from oitbench.gl.tiling import Scissor
from oitbench.method.formats import Format
from oitbench.method.passes import Gather, Pass
from oitbench.method.storage import Target

_SAMPLE_ALPHA_TO_COVERAGE, _SAMPLE_SHADING = 0x809E, 0x8C36


class CompiledPass(Owner):
    """A pass that can be drawn. `begin` sets all of its state; the device owns its program.

    Attributes
    ----------
    step : Gather or Resolve
        The declaration.
    draws : hashable or None
        Key of the index order that a gather pass draws; None for a pass over pixels.
    framebuffer : moderngl.Framebuffer
    clears : list of (framebuffer, format, value)
        Targets to clear just before.
    subsample : int
        Downsampling factor of the written targets.

    Parameters
    ----------
    device : Device
    step, draws, framebuffer, subsample
        See above.
    program : moderngl.Program
    samplers : mapping of str to texture
        In the order of their units.
    images : sequence of moderngl.Texture
        Images that replace targets.
    geometry : Geometry
    depth_writes, depth_tests : bool
        Whether the driver writes depths, and tests them in a pass over geometry.
    per_sample : bool
        Whether the shader runs for each sample of a fragment.
    blocks : mapping of int to moderngl.Buffer
        Uniform blocks by binding.
    """

    def __init__(
        self,
        device: Device,
        step: Pass,
        draws: Hashable | None,
        program: moderngl.Program,
        framebuffer: moderngl.Framebuffer,
        samplers: Mapping[str, Sampled],
        images: Sequence[moderngl.Texture],
        geometry: Geometry,
        depth_writes: bool,
        depth_tests: bool,
        per_sample: bool,
        blocks: Mapping[int, moderngl.Buffer],
        subsample: int,
    ) -> None:
        super().__init__()
        self.step, self.draws, self.subsample = step, draws, subsample
        self.framebuffer = self.own(framebuffer)
        self.clears: list[tuple[moderngl.Framebuffer, Format, tuple[float, ...]]] = []
        self._device, self._program, self._geometry = device, program, geometry
        self._samplers, self._images, self._blocks = samplers, images, blocks
        self._depth_writes, self._depth_tests = depth_writes, depth_tests
        self._per_sample = per_sample
        self._arrays: dict[int, moderngl.VertexArray] = {}

    def begin(self, view: moderngl.Buffer, scissor: Scissor) -> None:
        """Set framebuffer, depth, blend, samplers and uniform blocks."""
        device, context = self._device, self._device.context
        self.framebuffer.use()
        self.framebuffer.scissor = scissor
        self.framebuffer.depth_mask = self._depth_writes
        geometry = isinstance(self.step, Gather)
        # Blending stays on even where it replaces: with blending, depth test and discard all off,
        # llvmpipe drops the side effects of primitives that a later one covers.
        depth = geometry or self.step.depth is not None
        masks = isinstance(self.step, Gather) and self.step.masked_by_alpha
        # A driver may shade whole pixels where the shader uses no value of a sample but its depth.
        for state, on in ((_SAMPLE_ALPHA_TO_COVERAGE, masks), (_SAMPLE_SHADING, self._per_sample)):
            (context.enable_direct if on else context.disable_direct)(state)
        context.enable_only(moderngl.BLEND | (moderngl.DEPTH_TEST if depth else 0))
        tests = geometry and self._depth_tests
        context.depth_func = ">" if tests else "1"
        for slot, blend in enumerate(self.step.writes.values()):
            device.set_blend(slot, blend)
        for unit, texture in enumerate(self._samplers.values()):
            texture.use(unit)
        for unit, image in enumerate(self._images):
            image.bind_to_image(unit, read=True, write=True)
        view.bind_to_uniform_block(VIEW_BINDING)
        for binding, block in self._blocks.items():
            block.bind_to_uniform_block(binding)
        if self.step.buffers or self._images:
            context.memory_barrier()

    def draw(self, indices: moderngl.Buffer, first: int, count: int) -> None:
        """Draw `count` triangles of `indices`, starting at triangle `first`."""
        array = self._arrays.get(indices.glo)
        if array is None:
            geometry = self._geometry
            content = [(geometry.vertices, VERTEX_FORMAT, *(VERTEX.names or ()))]
            if geometry.factors is not None:
                content.append((geometry.factors, FACTORS_FORMAT, *(FACTORS.names or ())))
            if geometry.planes is not None:
                content.append((geometry.planes, PLANE_FORMAT, PLANE_NAME))
            array = self._device.context.vertex_array(
                self._program,
                content,
                index_buffer=indices,
                skip_errors=True,
            )
            self._arrays[indices.glo] = self.own(array)
        array.render(moderngl.TRIANGLES, vertices=3 * count, first=3 * first)
        self._end()

    def draw_screen(self) -> None:
        """Draw one triangle over the frame."""
        if 0 not in self._arrays:
            array = self._device.context.vertex_array(self._program, [])
            self._arrays[0] = self.own(array)
        self._arrays[0].render(moderngl.TRIANGLES, vertices=3)
        self._end()

    def _end(self) -> None:
        # Values stored in images are next read as textures, copied, or read back.
        if self._images:
            self._device.context.memory_barrier()

    def add_clear(self, framebuffer: moderngl.Framebuffer, target: Target) -> None:
        """Clear a target, the one attachment of `framebuffer`, before each draw."""
        self.clears.append((self.own(framebuffer), target.texel, target.clear))

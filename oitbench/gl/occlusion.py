"""Screen-space ambient occlusion of one frame: how open each visible surface is to the environment.

The chain: the depth of all opaque surfaces, with those fragments of binary coverage that cover
their pixel whole; openness from that depth; a filter over the estimator's pattern.
"""

from __future__ import annotations

import time
from collections.abc import Mapping
from dataclasses import dataclass

import moderngl

from oitbench.declare import REPLACE, Draws, Method, Order, Pass, Target
from oitbench.effects import Effect
from oitbench.gl.device import Device
from oitbench.gl.geometry import Batch, Geometry
from oitbench.gl.passes import Blueprint, CompiledPass, attach, compile_pass
from oitbench.gl.prelude import bind
from oitbench.gl.shadows import Moved
from oitbench.gl.steps import PassRecord
from oitbench.gl.view import view_block
from oitbench.scene import Scene

PLANES, STEPS = 2, 6
"""Planes through the view ray in which a pixel looks for horizons, and steps to either side."""
_AROUND = 9
"""Depths that a pixel reads to find its place and its normal."""
_PATTERN = 25
"""Pixels that the filter averages."""
_TARGETS = {
    "occluders": Target("depth32f", clear=(1.0,)),
    "raw": Target("r8", clear=(1.0,)),
    "openness": Target("r8", clear=(1.0,)),
}


def occludes(scene: Scene, effects: Effect) -> bool:
    """Tell whether surfaces of `scene` hide its environment from each other under `effects`.

    Those fragments of binary coverage that cover their pixel whole are then opaque.
    """
    called = Effect.AMBIENT_OCCLUSION in effects and scene.ambient_occlusion > 0
    return called and scene.environment is not None


@dataclass(frozen=True)
class _Draw:
    """One compiled pass with what it draws: indices, or the screen; `reads` in texels a pixel."""

    label: str
    compiled: CompiledPass
    indices: moderngl.Buffer | None
    writes: str
    reads: Mapping[str, int]


class Occlusion:
    """The stages of ambient occlusion, at one sample a pixel, and what they leave.

    Parameters
    ----------
    device : Device
    geometry : Geometry
        Of a scene for which `occludes` holds.
    size : (int, int)
        Width and height of the frame in pixels.

    Attributes
    ----------
    textures : dict of str to moderngl.Texture
        Samplers by name: the depth of what occludes, and the openness of each pixel.
    """

    def __init__(self, device: Device, geometry: Geometry, size: tuple[int, int]) -> None:
        self.device, self.size = device, size
        self._targets = {name: device.texture(size, t.texel) for name, t in _TARGETS.items()}
        self._framebuffers = {
            name: attach(device, texture, _TARGETS[name].texel)
            for name, texture in self._targets.items()
        }
        self.textures = {f"{n}_texture": self._targets[n] for n in ("occluders", "openness")}
        self._view = device.context.buffer(view_block(geometry.scene.camera, size, False))
        self._blueprint = Blueprint(
            device, geometry, Method(), None, Effect.NONE, _TARGETS, {}, bind({}, False)
        )
        self._draws: list[_Draw] = []
        self._drawn = False
        self._compile(geometry)

    # -- preparation ---------------------------------------------------------------------------

    def _compile(self, geometry: Geometry) -> None:
        radius = {"RADIUS_MICROMETRES": _micrometres(geometry.scene.ambient_occlusion)}
        for batch, defines in ((geometry.opaque, {}), (geometry.cutouts, {"INTERIOR": 1})):
            step = Pass("opaque_map.glsl", Draws.FRAGMENTS, depth="occluders", defines=defines)
            self._add("occluders", step, "occluders", {}, batch)
        taps = _AROUND + 2 * PLANES * STEPS
        for shader, writes, reads, defines in (
            ("occlusion.glsl", "raw", {"occluders": taps}, {"PLANES": PLANES, "STEPS": STEPS}),
            ("occlusion_filter.glsl", "openness", {"occluders": 1 + _PATTERN, "raw": _PATTERN}, {}),
        ):
            step = Pass(
                shader, Draws.PIXELS, tuple(reads), {writes: REPLACE}, defines=radius | defines
            )
            self._add(shader.removesuffix(".glsl").replace("_", " "), step, writes, reads)

    def _add(
        self,
        label: str,
        step: Pass,
        writes: str,
        reads: Mapping[str, int],
        batch: Batch | None = None,
    ) -> None:
        indices = None
        if batch is not None:
            triangles = batch.arrange(Order.SUBMISSION)[0]
            if not len(triangles):
                return
            indices = self.device.context.buffer(triangles.tobytes())
        compiled = compile_pass(self._blueprint, step, self._targets)
        self._draws.append(_Draw(label, compiled, indices, writes, reads))

    # -- rendering -----------------------------------------------------------------------------

    def prepare(self) -> None:
        """Find the openness, unless it has been found: camera and scene stand still."""
        if not self._drawn:
            self.issue()

    def issue(self) -> None:
        """Find the openness of all pixels."""
        self._drawn = True
        self._clear()
        for draw in self._draws:
            self._draw(draw)

    def measure(self) -> tuple[list[PassRecord], list[Moved]]:
        """Do the same, waiting for every draw; return what each did, and the bytes it moved."""
        records: dict[str, PassRecord] = {}
        pixels = self.size[0] * self.size[1]
        moved: list[Moved] = [
            ("clear", name, "clear", pixels, target.texel.bytes)
            for name, target in _TARGETS.items()
        ]
        self._clear()
        for draw in self._draws:
            start = time.perf_counter()
            query = self.device.context.query(samples=True)
            with query:
                self._draw(draw)
            self.device.finish()
            items, size = int(query.samples), _TARGETS[draw.writes].texel.bytes
            record = records.setdefault(draw.label, PassRecord(draw.label))
            record.runs += 1
            record.fragments += items
            record.milliseconds += 1e3 * (time.perf_counter() - start)
            for name, texels in draw.reads.items():
                texel = _TARGETS[name].texel.bytes
                moved.append((draw.label, name, "read", texels * items, texel))
            if draw.indices is not None:
                moved.append((draw.label, draw.writes, "blend", items, size))
            moved.append((draw.label, draw.writes, "write", items, size))
        return list(records.values()), moved

    def _clear(self) -> None:
        for name, target in _TARGETS.items():
            self._framebuffers[name].use()
            self._framebuffers[name].scissor = (0, 0, *self.size)
            self.device.clear(0, target.texel, target.clear)

    def _draw(self, draw: _Draw) -> None:
        draw.compiled.begin(self._view, (0, 0, *self.size))
        if draw.indices is None:
            draw.compiled.draw_screen()
        else:
            draw.compiled.draw(draw.indices, 0, draw.indices.size // 12)

    def memory(self) -> list[tuple[str, int]]:
        """Return (texture, bytes)."""
        pixels = self.size[0] * self.size[1]
        return [(name, pixels * target.texel.bytes) for name, target in _TARGETS.items()]

    def release(self) -> None:
        """Free the device's memory."""
        for draw in self._draws:
            draw.compiled.release()
            if draw.indices is not None:
                draw.indices.release()
        for framebuffer in self._framebuffers.values():
            framebuffer.release()
        for texture in self._targets.values():
            texture.release()
        self._view.release()


def _micrometres(radius: float) -> int:
    """Return a radius in metres as a positive integer that GLSL can hold."""
    return min(max(round(1e6 * radius), 1), 2**31 - 1)


def occlusion_of(
    device: Device, geometry: Geometry, size: tuple[int, int], effects: Effect
) -> Occlusion | None:
    """Return the ambient occlusion of a frame of `size`; None if nothing occludes."""
    return Occlusion(device, geometry, size) if occludes(geometry.scene, effects) else None

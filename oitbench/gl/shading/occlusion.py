"""Screen-space ambient occlusion of one frame: how open each visible surface is to the environment.

The chain: the depth of all opaque surfaces, with those fragments of binary coverage that cover
their pixel whole; openness from that depth; a filter over the estimator's pattern.
"""

from __future__ import annotations

from oitbench.effects import Effect
from oitbench.gl.device import Device
from oitbench.gl.draws.chain import Chain, Moved
from oitbench.gl.draws.steps import PassRecord
from oitbench.gl.geometry import Geometry
from oitbench.gl.program.passes import Blueprint
from oitbench.gl.program.prelude import bind
from oitbench.gl.view import view_block
from oitbench.method.declaration import REPLACE, Draws, Method, Pass, Target
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
        view = device.context.buffer(view_block(geometry.scene.camera, size, False))
        self._chain = Chain(device, _TARGETS, dict.fromkeys(_TARGETS, size), view)
        kept = ("occluders", "openness")
        self.textures = {f"{name}_texture": self._chain.textures[name] for name in kept}
        self._drawn = False
        self._compile(device, geometry)

    # -- preparation ---------------------------------------------------------------------------

    def _compile(self, device: Device, geometry: Geometry) -> None:
        blueprint = Blueprint(
            device, geometry, Method(), None, Effect.NONE, _TARGETS, {}, bind({}, False)
        )
        radius = {"RADIUS_MICROMETRES": _micrometres(geometry.scene.ambient_occlusion)}
        for batch, defines in ((geometry.opaque, {}), (geometry.cutouts, {"INTERIOR": 1})):
            step = Pass("opaque_map.glsl", Draws.FRAGMENTS, depth="occluders", defines=defines)
            first = batch is geometry.opaque
            self._chain.add("occluders", blueprint, step, ("occluders",), {}, batch, clears=first)
        taps = _AROUND + 2 * PLANES * STEPS
        for shader, writes, reads, defines in (
            ("occlusion.glsl", "raw", {"occluders": taps}, {"PLANES": PLANES, "STEPS": STEPS}),
            ("occlusion_filter.glsl", "openness", {"occluders": 1 + _PATTERN, "raw": _PATTERN}, {}),
        ):
            step = Pass(
                shader, Draws.PIXELS, tuple(reads), {writes: REPLACE}, defines=radius | defines
            )
            label = shader.removesuffix(".glsl").replace("_", " ")
            self._chain.add(label, blueprint, step, (writes,), reads, clears=True)

    # -- rendering -----------------------------------------------------------------------------

    def prepare(self) -> None:
        """Find the openness, unless it has been found: camera and scene stand still."""
        if not self._drawn:
            self.issue()

    def issue(self) -> None:
        """Find the openness of all pixels."""
        self._drawn = True
        self._chain.issue()

    def measure(self) -> tuple[list[PassRecord], list[Moved]]:
        """Do the same, waiting for every draw; return what each did, and the bytes it moved."""
        records: dict[str, PassRecord] = {}
        moved = self._chain.measure(records)
        return list(records.values()), moved

    def memory(self) -> list[tuple[str, int]]:
        """Return (texture, bytes)."""
        return self._chain.memory()

    def release(self) -> None:
        """Free the device's memory."""
        self._chain.release()


def _micrometres(radius: float) -> int:
    """Return a radius in metres as a positive integer that GLSL can hold."""
    return min(max(round(1e6 * radius), 1), 2**31 - 1)


def occlusion_of(
    device: Device, geometry: Geometry, size: tuple[int, int], effects: Effect
) -> Occlusion | None:
    """Return the ambient occlusion of a frame of `size`; None if nothing occludes."""
    return Occlusion(device, geometry, size) if occludes(geometry.scene, effects) else None

"""Screen-space ambient occlusion: the part of the environment that each visible surface receives.

Three passes: the depth of all opaque surfaces, with fragments of binary coverage that cover their
pixel completely; openness from that depth; a filter over the estimator's pattern.
"""

from __future__ import annotations

import numpy as np

from oitbench.effects import Effect
from oitbench.gl.device import Device
from oitbench.gl.draws.chain import Chain, Measurement
from oitbench.gl.draws.records import Lap, no_lap
from oitbench.gl.geometry import Geometry
from oitbench.gl.ownership import Owner
from oitbench.gl.program.passes import Blueprint
from oitbench.method.blending import REPLACE
from oitbench.method.passes import Gather, Resolve
from oitbench.method.storage import Target
from oitbench.scene import Scene

PLANES, STEPS = 2, 6
"""Planes through the view ray in which a pixel searches for horizons, and steps to either side."""
_AROUND = 9
"""Depths that a pixel reads for its position and its normal."""
_PATTERN = 25
"""Pixels that the filter averages."""
_TARGETS = {
    "occluders": Target("depth32f"),
    "raw": Target("r8", clear=(1.0,)),
    "openness": Target("r8", clear=(1.0,)),
}


def occludes(scene: Scene, effects: Effect) -> bool:
    """Return whether surfaces of `scene` hide its environment from each other under `effects`.

    Fragments of binary coverage that cover their pixel completely are then opaque.
    """
    requested = Effect.AMBIENT_OCCLUSION in effects and scene.ambient_occlusion > 0
    return requested and scene.environment is not None


class Occlusion(Owner):
    """The passes of ambient occlusion of one frame, at one sample per pixel, and their result.

    Parameters
    ----------
    device : Device
    geometry : Geometry
        Of a scene for which `occludes` holds.
    size : (int, int)
        Width and height of the frame in pixels.

    Attributes
    ----------
    samplers : dict of str to moderngl.Texture
        The depth of occluders, and the openness of each pixel.
    """

    def __init__(self, device: Device, geometry: Geometry, size: tuple[int, int]) -> None:
        super().__init__()
        sizes = dict.fromkeys(_TARGETS, size)
        self._geometry, self._size = geometry, size
        with self.building():
            self._view = self.own(device.context.buffer(geometry.view(size)))
            self._chain = self.own(Chain(device, geometry, _TARGETS, sizes, self._view))
            self._compile(geometry)
        kept = ("occluders", "openness")
        self.samplers = {f"{name}_texture": self._chain.textures[name] for name in kept}
        self._drawn = False

    def _compile(self, geometry: Geometry) -> None:
        blueprint = Blueprint("ambient occlusion")
        opaque = Gather("opaque_map.glsl", depth="occluders", clears=("occluders",))
        interior = Gather("opaque_map.glsl", depth="occluders", defines={"INTERIOR": 1})
        self._chain.add(opaque, blueprint, "occluders", geometry.opaque)
        self._chain.add(interior, blueprint, "occluders", geometry.cutouts)
        radius = {"RADIUS": float(np.float32(geometry.scene.ambient_occlusion))}
        taps = _AROUND + 2 * PLANES * STEPS
        for shader, result, reads, defines in (
            ("occlusion.glsl", "raw", {"occluders": taps}, {"PLANES": PLANES, "STEPS": STEPS}),
            ("occlusion_filter.glsl", "openness", {"occluders": 1 + _PATTERN, "raw": _PATTERN}, {}),
        ):
            step = Resolve(
                shader,
                reads=tuple(reads),
                writes={result: REPLACE},
                clears=(result,),
                defines=radius | defines,
            )
            label = shader.removesuffix(".glsl").replace("_", " ")
            self._chain.add(step, blueprint, label, taps=reads)

    def follow(self) -> None:
        """Look from the camera where it is now."""
        self._view.write(self._geometry.view(self._size))
        self._drawn = False

    def prepare(self) -> None:
        """Compute the openness unless it is known: camera and scene stand still."""
        if not self._drawn:
            self.issue()

    def issue(self, lap: Lap = no_lap) -> None:
        """Compute the openness of all pixels; `lap` ends each pass."""
        self._drawn = True
        self._chain.issue(lap=lap)

    def measure(self, into: Measurement) -> None:
        """Compute the openness, and add one record per pass to `into`."""
        self._drawn = True
        self._chain.measure(into)

    def memory(self) -> list[tuple[str, int]]:
        """Return (texture, bytes)."""
        return self._chain.memory()

"""The opaque picture behind all transparency, and the number of transparent fragments before it."""

from __future__ import annotations

import moderngl
import numpy as np
import numpy.typing as npt

from oitbench.effects import Effect
from oitbench.gl.device import Device
from oitbench.gl.draws.chain import Chain
from oitbench.gl.geometry import Geometry
from oitbench.gl.ownership import Owner
from oitbench.gl.program.passes import Blueprint
from oitbench.gl.program.shading_inputs import UNLIT, ShadingInputs
from oitbench.gl.shading.occlusion import occludes
from oitbench.method.blending import ADD, REPLACE
from oitbench.method.passes import OPAQUE_DEPTH, Gather, Resolve
from oitbench.method.storage import Target

DEPTH = Target("depth32f")
_COLOR, _COUNTED = Target("rgba16f"), Target("r32f")
_WRITES = {"color": REPLACE}
_OPAQUE = Gather("opaque.glsl", writes=_WRITES, depth=OPAQUE_DEPTH, defines={"OPAQUE": 1})
_INTERIOR = Gather(
    "opaque.glsl", writes=_WRITES, depth=OPAQUE_DEPTH, defines={"OPAQUE": 1, "INTERIOR": 1}
)
_BACKGROUND = Resolve("background.glsl", reads=(OPAQUE_DEPTH,), writes=_WRITES)
_COUNT = Gather("count.glsl", writes={"count": ADD}, clears=("count",))


class OpaquePicture(Owner):
    """Color and depth of everything behind all transparency.

    Under ambient occlusion this includes fragments of binary coverage that cover their pixel
    completely. Passes over transparent fragments test against its depth, and skip them.

    Parameters
    ----------
    device : Device
    geometry : Geometry
    color, depth : moderngl.Texture
        Textures to draw into; they belong to the caller.
    target : Target
        Description of the color texture.
    view : moderngl.Buffer
        The uniform block `View`.
    samples : int
        Samples per pixel of both textures.
    effects : Effect
        Running effects.
    shading : ShadingInputs
    """

    def __init__(
        self,
        device: Device,
        geometry: Geometry,
        color: moderngl.Texture,
        depth: moderngl.Texture,
        target: Target,
        view: moderngl.Buffer,
        samples: int = 1,
        effects: Effect = Effect.NONE,
        shading: ShadingInputs = UNLIT,
    ) -> None:
        super().__init__()
        scene = geometry.scene
        targets = {"color": target, OPAQUE_DEPTH: DEPTH}
        textures = {"color": color, OPAQUE_DEPTH: depth}
        self._device, self._background, self._target = device, scene.background, target
        sizes = dict.fromkeys(targets, color.size)
        blueprint = Blueprint("opaque", effects=effects, shading=shading, samples=samples)
        with self.building():
            self._surfaces, self._sky = (
                self.own(Chain(device, geometry, targets, sizes, view, textures)) for _ in range(2)
            )
            self._surfaces.add(_OPAQUE, blueprint, batch=geometry.opaque)
            if occludes(scene, effects):
                self._surfaces.add(_INTERIOR, blueprint, batch=geometry.cutouts)
            if scene.environment is not None and shading.lit:
                self._sky.add(_BACKGROUND, blueprint)

    def draw(self, transmittance: bool = False) -> None:
        """Draw color and depth.

        Parameters
        ----------
        transmittance : bool
            Show a background of one instead of radiance; `View` must agree.
        """
        background = (1.0, 1.0, 1.0) if transmittance else self._background
        for name, entry, value in (
            ("color", self._target.texel, (*background, 1.0)),
            (OPAQUE_DEPTH, DEPTH.texel, DEPTH.clear),
        ):
            framebuffer = self._surfaces.framebuffers[name]
            framebuffer.use()
            framebuffer.scissor = (0, 0, *framebuffer.size)
            self._device.clear(0, entry, value)
        self._surfaces.issue()
        if not transmittance:
            self._sky.issue()


def count_fragments(
    device: Device, geometry: Geometry, size: tuple[int, int], effects: Effect = Effect.NONE
) -> npt.NDArray[np.int64]:
    """Return the number of visible transparent fragments per pixel, shape (h, w), bottom row first.

    One sample per pixel is taken, at its center. `effects` are those that run: ambient occlusion
    makes some fragments opaque.
    """
    targets = {"count": _COUNTED, OPAQUE_DEPTH: DEPTH}
    with Owner() as owner:
        view = owner.own(device.context.buffer(geometry.view(size)))
        color = owner.own(device.texture(size, _COLOR.texel))
        depth = owner.own(device.texture(size, DEPTH.texel))
        opaque = owner.own(
            OpaquePicture(device, geometry, color, depth, _COLOR, view, effects=effects)
        )
        sizes = dict.fromkeys(targets, size)
        counting = owner.own(Chain(device, geometry, targets, sizes, view, {OPAQUE_DEPTH: depth}))
        counting.add(_COUNT, Blueprint("fragment count"), batch=geometry.transparent)
        opaque.draw()
        counting.issue()
        data = counting.textures["count"].read()
        return np.frombuffer(data, dtype=np.float32).reshape(size[::-1]).astype(np.int64)

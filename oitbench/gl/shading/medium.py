"""A scene's medium on the device: the uniform block `Medium` and the grid of densities."""

from __future__ import annotations

import moderngl
import numpy as np

from oitbench.gl.device import Device
from oitbench.gl.ownership import Owner
from oitbench.scene import Array, Medium, Scene
from oitbench.scene.checks import single_precision
from oitbench.scene.environment import ambient_of_medium

_VACUUM = Medium(extinction=0.0, low=(0.0, 0.0, 0.0), high=(1.0, 1.0, 1.0))


class UploadedMedium(Owner):
    """The inputs of `medium.glsl`.

    Parameters
    ----------
    device : Device
    scene : Scene
        Without a medium, vacuum fills it.

    Attributes
    ----------
    block : moderngl.Buffer
    density : moderngl.Texture3D or None
        None where the density is one everywhere.

    Raises
    ------
    CapabilityError
        The grid is larger than the driver allows.
    """

    def __init__(self, device: Device, scene: Scene) -> None:
        super().__init__()
        medium = scene.medium or _VACUUM
        rows = [
            [*medium.low, medium.extinction],
            [*medium.high, medium.anisotropy],
            [*medium.albedo, medium.collimation],
            [*ambient_of_medium(scene), 0.0],
        ]
        self.density: moderngl.Texture3D | None = None
        with self.building():
            block = single_precision("the medium of the scene", rows).tobytes()
            self.block = self.own(device.context.buffer(block))
            if medium.density is not None:
                self.density = self.own(_upload_density(device, medium.density))

    @property
    def macros(self) -> str:
        """Facts about the medium that shaders need at compile time."""
        return "#define MEDIUM 1" + ("\n#define DENSITY 1" if self.density is not None else "")


def _upload_density(device: Device, density: Array) -> moderngl.Texture3D:
    cells = np.ascontiguousarray(density, dtype=np.float32)
    depth, height, width = cells.shape
    owner = f"a medium of {width}x{height}x{depth} cells"
    device.within(owner, max(cells.shape), "GL_MAX_3D_TEXTURE_SIZE")
    texture = device.context.texture3d((width, height, depth), 1, cells, dtype="f4")
    texture.filter = (moderngl.LINEAR, moderngl.LINEAR)
    texture.repeat_x = texture.repeat_y = texture.repeat_z = False
    return texture

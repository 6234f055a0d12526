"""The environment light on the device: its map, and the means of its radiance by direction."""

from __future__ import annotations

from collections.abc import Sequence

import moderngl
import numpy as np

from oitbench.gl.device import Device
from oitbench.gl.ownership import Owner
from oitbench.scene import EnvironmentLight, Floats, Material
from oitbench.scene.environment import (
    cosine_weight,
    lobe_fit,
    lobe_weight,
    rough_lobes,
    tables_of_means,
)


class UploadedEnvironment(Owner):
    """The textures that `lighting.glsl` looks up.

    Parameters
    ----------
    device : Device
    light : EnvironmentLight
    materials : sequence of Material
        Of the scene: their lobes are those of `rough_lobes`, in this order.

    Attributes
    ----------
    samplers : dict of str to texture
        `environment_texture`: the map. `means_texture`: layer 0 has the irradiance over π, and each
        other layer the light that one lobe gathers around a direction. `lobes_texture`: a row of
        `lobe_fit` for each lobe, if there is any.
    macros : str

    Raises
    ------
    CapabilityError
        A texture is larger than the driver allows.
    """

    def __init__(
        self, device: Device, light: EnvironmentLight, materials: Sequence[Material]
    ) -> None:
        super().__init__()
        lobes, texels = rough_lobes(materials), light.texels
        height, width = texels.shape[:2]
        owner = f"an environment of {width}x{height} texels"
        device.within(owner, max(width, height), "GL_MAX_TEXTURE_SIZE")
        owner = f"a scene of {len(lobes)} different roughnesses"
        device.within(owner, len(lobes) + 1, "GL_MAX_ARRAY_TEXTURE_LAYERS")
        weights = [cosine_weight, *map(lobe_weight, lobes)]
        means = tables_of_means(texels, weights)
        self.macros = "#define ENVIRONMENT 1" + ("\n#define LOBES 1" if lobes else "")
        self.samplers: dict[str, moderngl.Texture | moderngl.TextureArray] = {}
        with self.building():
            self._add_table(device, "environment", texels[::-1])
            size = means.shape[2], means.shape[1], len(means)
            array = device.context.texture_array(size, 4, _texels(means), dtype="f4")
            self.samplers["means_texture"] = self.own(array)
            if lobes:
                self._add_table(device, "lobes", np.stack([lobe_fit(one) for one in lobes]))
            for name, texture in self.samplers.items():
                texture.filter = (moderngl.LINEAR, moderngl.LINEAR)
                # Columns are longitudes, or cosines.
                texture.repeat_x, texture.repeat_y = name != "lobes_texture", False

    def _add_table(self, device: Device, name: str, values: Floats) -> None:
        height, width = values.shape[:2]
        texture = device.context.texture((width, height), 4, _texels(values), dtype="f4")
        self.samplers[f"{name}_texture"] = self.own(texture)


def _texels(values: Floats) -> bytes:
    """Return values of three or four channels as texels of four, the last of which is one."""
    found = np.ones((*values.shape[:-1], 4), dtype=np.float32)
    found[..., : values.shape[-1]] = values
    return found.tobytes()

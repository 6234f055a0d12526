"""The environment light as a map on the device, and its irradiance as spherical harmonics."""

from __future__ import annotations

import math

import moderngl
import numpy as np

from oitbench.gl.device import Device
from oitbench.scene import Floats


def upload_environment(device: Device, texels: Floats) -> moderngl.Texture:
    """Return the map of latitude and longitude as a texture with mip levels.

    Raises
    ------
    CapabilityError
        The map is larger than the driver allows.
    """
    height, width = texels.shape[:2]
    owner = f"an environment of {width}x{height} texels"
    device.within(owner, max(width, height), "GL_MAX_TEXTURE_SIZE")
    data = np.ones((height, width, 4), dtype=np.float32)
    data[..., :3] = texels[::-1]
    texture = device.context.texture((width, height), 4, data.tobytes(), dtype="f4")
    texture.build_mipmaps()
    texture.filter = (moderngl.LINEAR_MIPMAP_LINEAR, moderngl.LINEAR)
    texture.repeat_x, texture.repeat_y = True, False
    return texture


def irradiance_harmonics(texels: Floats) -> Floats:
    """Return the coefficients of irradiance for `surrounding_irradiance` (lighting.glsl).

    Parameters
    ----------
    texels : array, shape (h, w, 3)
        Radiance by latitude (first row up, +y) and longitude (middle column −z, to the right +x).

    Returns
    -------
    array, shape (9, 3)
        Of 1, y, z, x, xy, yz, 3z² − 1, xz, x² − y², including normalization and cosine lobe.

    References
    ----------
    Ramamoorthi & Hanrahan 2001, "An efficient representation for irradiance environment maps".
    """
    # Cut the texels of a small map into patches over which the functions are almost constant.
    for axis, patches in enumerate((256, 512)):
        texels = texels.repeat(math.ceil(patches / texels.shape[axis]), axis=axis)
    height, width = texels.shape[:2]
    edges = np.linspace(0, math.pi, height + 1)
    polar = (edges[:-1] + edges[1:]) / 2
    weight = (np.cos(edges[:-1]) - np.cos(edges[1:]))[:, None] * (2 * math.pi / width)
    longitude = ((np.arange(width) + 0.5) / width - 0.5) * 2 * math.pi
    x = np.sin(polar)[:, None] * np.sin(longitude)
    y = np.broadcast_to(np.cos(polar)[:, None], x.shape)
    z = -np.sin(polar)[:, None] * np.cos(longitude)
    functions = [np.ones_like(x), y, z, x, x * y, y * z, 3 * z * z - 1, x * z, x * x - y * y]
    # Squares of the functions' normalization, times the cosine lobe's π, 2π/3, π/4 by band.
    norms = np.array([1 / (4 * math.pi), *[3 / (4 * math.pi)] * 3, *[15 / (4 * math.pi)] * 2,
                      5 / (16 * math.pi), 15 / (4 * math.pi), 15 / (16 * math.pi)])  # fmt: skip
    lobe = np.array([math.pi, *[2 * math.pi / 3] * 3, *[math.pi / 4] * 5])
    sums = [np.einsum("hw,hwc->c", weight * function, texels) for function in functions]
    return np.asarray(np.array(sums) * (norms * lobe)[:, None])

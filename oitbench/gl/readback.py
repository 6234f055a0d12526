"""Values of a texture as numbers, for every format of the table."""

from __future__ import annotations

import moderngl
import numpy as np

from oitbench.errors import UsageError
from oitbench.gl.device import Device
from oitbench.gl.ownership import Owner
from oitbench.gl.program.passes import attach
from oitbench.image.values import Values
from oitbench.method.formats import FORMATS, Format

_FLOAT, _UNSIGNED_INT, _DEPTH_COMPONENT = 0x1406, 0x1405, 0x1902
_CHANNELS = {1: 0x1903, 2: 0x8227, 3: 0x1907, 4: 0x1908}
_INTEGERS = {1: 0x8D94, 2: 0x8228, 3: 0x8D98, 4: 0x8D99}


def read_texels(
    device: Device, texture: moderngl.Texture, size: tuple[int, int], entry: Format
) -> Values:
    """Return all texels of a texture of one sample, as shaders would fetch them.

    Parameters
    ----------
    device : Device
    texture : moderngl.Texture
    size : (int, int)
        Width and height.
    entry : Format

    Returns
    -------
    array, shape (h, w, components)
        Top row first; uint32 for integers, else float32.
    """
    width, height = size
    kinds = _INTEGERS if entry.integer else _CHANNELS
    channels = _DEPTH_COMPONENT if entry.depth else kinds[entry.components]
    texels: Values = np.zeros(
        (height, width, entry.components), np.uint32 if entry.integer else np.float32
    )
    # moderngl reads the type that the texture stores, which it takes for unsigned.
    device.call(
        "glGetTextureImage",
        *(texture.glo, 0, channels, _UNSIGNED_INT if entry.integer else _FLOAT),
        *(texels.nbytes, texels.ctypes.data),
    )
    return np.ascontiguousarray(texels[::-1])


def read_averaged(
    device: Device,
    name: str,
    framebuffer: moderngl.Framebuffer | None,
    size: tuple[int, int],
    entry: Format,
) -> Values:
    """Return the texels of a multisampled target, averaged over the samples of each pixel.

    Raises
    ------
    UsageError
        The format has no mean: depths and integers.
    """
    if framebuffer is None or entry.depth or entry.integer:
        raise UsageError(
            f"target {name}: {entry.name} of several samples per pixel has no mean; choose one"
            " sample (msaa=1)"
        )
    with Owner() as owner:
        averaged = owner.own(device.texture(size, entry))
        copy = owner.own(attach(device, averaged, entry))
        copy.use()  # without a scissor
        device.context.copy_framebuffer(copy, framebuffer)
        return read_texels(device, averaged, size, entry)


def format_of(texture: moderngl.Texture) -> Format:
    """Return the format of a texture that `Device.texture` made; signed ones read as unsigned."""
    return next(
        entry
        for entry in FORMATS.values()
        if entry.internal is None
        and (entry.components, entry.dtype, entry.depth)
        == (texture.components, texture.dtype, texture.depth)
    )

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

_FLOAT, _UNSIGNED_INT, _BYTE, _DEPTH_COMPONENT = 0x1406, 0x1405, 0x1400, 0x1902
_PACK_ALIGNMENT = 0x0D05
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
    shape = height, width, entry.components
    kind = _FLOAT
    texels: Values = np.zeros(shape, np.float32)
    if entry.integer:
        kind, texels = _UNSIGNED_INT, np.zeros(shape, np.uint32)
    elif entry.signed:
        # As numbers, NVIDIA returns the fractions of old versions of OpenGL, which have no zero.
        kind, texels = _BYTE, np.zeros(shape, np.int8)
    device.call("glPixelStorei", _PACK_ALIGNMENT, 1)
    # moderngl reads the type that the texture stores, which it takes for unsigned.
    device.call(
        "glGetTextureImage", texture.glo, 0, channels, kind, texels.nbytes, texels.ctypes.data
    )
    if entry.signed:
        texels = np.maximum(texels.astype(np.float32) * np.float32(entry.step), np.float32(-1))
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

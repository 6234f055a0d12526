"""Reading pictures of users: PNG, JPEG, Radiance HDR and OpenEXR."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np

from oitbench.errors import UsageError
from oitbench.image import pictures, radiance
from oitbench.image.files import Image, read_channels, utf8_name

MOST_PIXELS = 1 << 28
"""Pixels of the largest picture that is read unless another limit is given."""
_OPENEXR = bytes([0x76, 0x2F, 0x31, 0x01])
"""The first bytes of an OpenEXR file."""


def read_image(source: Path | str | bytes, most_pixels: int = MOST_PIXELS) -> Image:
    """Read a picture of any of the usual kinds: PNG, JPEG, Radiance HDR or OpenEXR.

    Parameters
    ----------
    source : path or bytes
        A file, or the content of one (not of OpenEXR). Its first bytes tell its kind.
    most_pixels : int
        Larger pictures are refused before they are unpacked.

    Returns
    -------
    array, shape (h, w, 3) or (h, w, 4), float32
        Linear Rec.709, top row first. PNG and JPEG are taken for sRGB. A fourth channel is alpha,
        where the file has one; colors are as the file has them.

    Raises
    ------
    UsageError
        If the file is missing, damaged, too large or of another kind.
    """
    name = "the image" if isinstance(source, bytes) else str(source)
    try:
        content = source if isinstance(source, bytes) else Path(source).read_bytes()
    except OSError as error:
        raise UsageError(f"{name} cannot be read: {error.strerror}") from error
    try:
        if content.startswith(radiance.SIGNATURES):
            pictures.require_few(name, radiance.size_of(content)[:2], most_pixels)
            return radiance.decode(content)
        if content.startswith(_OPENEXR) and not isinstance(source, bytes):
            return _read_exr_image(Path(source), most_pixels)
        return pictures.decode(content, name, most_pixels)
    except pictures.UNREADABLE as error:
        raise UsageError(
            f"{name} is no readable PNG, JPEG, HDR or OpenEXR image ({error}); convert it"
        ) from error


def _read_exr_image(path: Path, most_pixels: int) -> Image:
    import OpenEXR

    with utf8_name(path, os.O_RDONLY) as name, OpenEXR.File(name, header_only=True) as file:
        low, high = file.header()["dataWindow"]
        height, width = int(high[1]) - int(low[1]) + 1, int(high[0]) - int(low[0]) + 1
    pictures.require_few(str(path), (height, width), most_pixels)
    channels = read_channels(path)
    pixels = next((channels[name] for name in ("RGBA", "RGB", "Y") if name in channels), None)
    if pixels is None:
        raise ValueError(f"its channels are {', '.join(channels)}, not RGB")
    colors = np.repeat(pixels[..., None], 3, axis=2) if pixels.ndim == 2 else pixels
    return np.ascontiguousarray(colors, dtype=np.float32)

"""Pictures of 8 bits or 16: PNG and JPEG, whose values are sRGB."""

from __future__ import annotations

import io

import numpy as np
import numpy.typing as npt

from oitbench.errors import UsageError

Image = npt.NDArray[np.float32]


def require_few(name: str, size: tuple[int, int], most_pixels: int) -> None:
    """Raise `UsageError` if a picture of `size` (height, width) has more pixels than allowed."""
    if size[0] * size[1] > most_pixels:
        raise UsageError(
            f"{name} has {size[1]}x{size[0]} pixels; at most {most_pixels} are read: make it"
            " smaller"
        )


def decode(content: bytes, name: str, most_pixels: int) -> Image:
    """Return the linear values of a PNG or JPEG file; see `oitbench.image.files.read_image`."""
    from PIL import Image as Picture

    with Picture.open(io.BytesIO(content), formats=("PNG", "JPEG")) as picture:
        require_few(name, (picture.height, picture.width), most_pixels)
        if picture.mode.startswith("I"):  # 16 bits of gray
            gray = np.asarray(picture, dtype=np.float64) / 65535
            return from_srgb(np.repeat(gray[..., None], 3, axis=2))
        clear = picture.has_transparency_data
        levels = np.asarray(picture.convert("RGBA" if clear else "RGB"), dtype=np.uint8)
    linear = from_srgb(np.arange(256) / 255)[levels]
    if clear:
        linear[..., 3] = levels[..., 3] / np.float32(255)
    return linear


def from_srgb(encoded: npt.ArrayLike) -> Image:
    """Return the linear values of sRGB ones in [0, 1]; the inverse of `to_srgb` at 0 stops."""
    values = np.asarray(encoded, dtype=np.float64)
    curve = ((values + 0.055) / 1.055) ** 2.4
    return np.where(values <= 0.04045, values / 12.92, curve).astype(np.float32)

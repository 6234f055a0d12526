"""Pictures of 8 bits or 16: PNG and JPEG, whose values are sRGB."""

from __future__ import annotations

import io
import struct
import warnings
from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from oitbench.errors import UsageError

Image = npt.NDArray[np.float32]
Levels = npt.NDArray[np.uint8] | npt.NDArray[np.uint16]
UNREADABLE = (
    OSError, ValueError, SyntaxError, EOFError, TypeError, LookupError, OverflowError, RuntimeError,
    MemoryError, struct.error,
)  # fmt: skip
"""Errors that libraries raise for damaged pictures."""


def require_few(name: str, size: tuple[int, int], most_pixels: int) -> None:
    """Raise `UsageError` if a picture of `size` (height, width) has more pixels than allowed."""
    if size[0] * size[1] > most_pixels:
        raise UsageError(
            f"{name} has {size[1]}x{size[0]} pixels; at most {most_pixels} are read: make it"
            " smaller"
        )


def unpacked(
    content: bytes | memoryview, formats: tuple[str, ...], check: Callable[[int, int], None]
) -> Levels:
    """Return the levels of a picture, as it encodes them.

    Parameters
    ----------
    content : bytes
        Of the file.
    formats : tuple of str
        Names by Pillow of the allowed kinds.
    check : callable
        Gets the height and the width before the picture is unpacked, and refuses it by an error.

    Returns
    -------
    array, shape (h, w, 3) or (h, w, 4), uint8; or shape (h, w), uint16

    Raises
    ------
    UNREADABLE
        The picture is damaged, or of another kind.
    """
    from PIL import Image as Picture

    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            with Picture.open(io.BytesIO(content), formats=formats) as picture:
                check(picture.height, picture.width)
                if picture.mode.startswith("I"):  # 16 bits of gray
                    return np.asarray(picture).astype(np.int64).clip(0, 65535).astype(np.uint16)
                mode = "RGBA" if picture.has_transparency_data else "RGB"
                return np.array(picture.convert(mode), dtype=np.uint8)
    except Picture.DecompressionBombError as error:
        raise ValueError("it has too many pixels") from error


def decode(content: bytes, name: str, most_pixels: int) -> Image:
    """Return the linear values of a PNG or JPEG file; see `oitbench.image.reading.read_image`."""
    levels = unpacked(
        content,
        ("PNG", "JPEG"),
        lambda height, width: require_few(name, (height, width), most_pixels),
    )
    if levels.dtype == np.uint16:
        gray = levels.astype(np.float64) / 65535
        return from_srgb(np.repeat(gray[..., None], 3, axis=2))
    linear = from_srgb(np.arange(256) / 255)[levels]
    if levels.shape[2] == 4:
        linear[..., 3] = levels[..., 3] / np.float32(255)
    return linear


def from_srgb(encoded: npt.ArrayLike) -> Image:
    """Return the linear values of sRGB ones in [0, 1]; the inverse of `to_srgb` at 0 stops."""
    values = np.asarray(encoded, dtype=np.float64)
    curve = ((values + 0.055) / 1.055) ** 2.4
    return np.where(values <= 0.04045, values / 12.92, curve).astype(np.float32)

"""Decodes pictures of untrusted files; their sizes are checked before they are decoded."""

from __future__ import annotations

import io
import struct
import warnings

import numpy as np
import numpy.typing as npt

from oitbench.errors import SceneError
from oitbench.image.pictures import from_srgb
from oitbench.importing.limits import Budget, short
from oitbench.scene import Array

Bytes = npt.NDArray[np.uint8]
_FORMATS = ("PNG", "JPEG", "WEBP")


def read_picture(content: bytes | memoryview, name: str, budget: Budget) -> Bytes:
    """Return the pixels of a picture, shape (h, w, 4): red, green, blue and alpha in [0, 255].

    Parameters
    ----------
    content : bytes
        Of the file.
    name : str
        For messages.
    budget : Budget

    Raises
    ------
    SceneError
        It is no such picture, damaged, or too large.
    """
    from PIL import Image

    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            with Image.open(io.BytesIO(content), formats=_FORMATS) as image:
                width, height = image.size
                budget.take("texels", width * height)
                if image.mode.startswith("I"):
                    # Sixteen bits of gray; Pillow would clip them.
                    high = (np.asarray(image).astype(np.int64) >> 8).clip(0, 255).astype(np.uint8)
                    return np.array(Image.fromarray(high).convert("RGBA"))
                return np.array(image.convert("RGBA"))
    except SceneError:
        raise
    except (
        OSError, ValueError, SyntaxError, EOFError, TypeError, IndexError, KeyError, OverflowError,
        struct.error, Image.DecompressionBombError, MemoryError,
    ) as error:  # fmt: skip
        message = short(error) or type(error).__name__
        raise SceneError(f"picture '{short(name)}' cannot be read: {message}") from error


def linear(encoded: Bytes) -> Array:
    """Return values of sRGB in [0, 255] as linear ones in [0, 1]."""
    return np.asarray(from_srgb(np.arange(256) / 255)[encoded])


def fractions(values: Bytes) -> Array:
    """Return values in [0, 255], which are linear already, in [0, 1]."""
    return np.asarray(values, dtype=np.float32) / np.float32(255)

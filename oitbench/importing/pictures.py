"""Decodes pictures of untrusted files; their sizes are checked before they are decoded."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from oitbench.errors import SceneError
from oitbench.image.pictures import UNREADABLE, from_srgb, unpacked
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

    def check(height: int, width: int) -> None:
        # While a material is computed, each of them needs tens of bytes.
        budget.require("texels of a picture", width * height)
        budget.take("texels of pictures", width * height)

    try:
        levels = unpacked(content, _FORMATS, check)
        if levels.dtype == np.uint16:
            levels = np.repeat((levels >> 8).astype(np.uint8)[..., None], 3, axis=2)
        found = np.full((*levels.shape[:2], 4), 255, dtype=np.uint8)
        found[..., : levels.shape[2]] = levels
    except UNREADABLE as error:
        message = short(error) or type(error).__name__
        raise SceneError(f"picture '{short(name)}' cannot be read: {message}") from error
    return found


def linear(encoded: Bytes) -> Array:
    """Return values of sRGB in [0, 255] as linear ones in [0, 1]."""
    return np.asarray(from_srgb(np.arange(256) / 255)[encoded])


def fractions(values: Bytes) -> Array:
    """Return values in [0, 255], which are linear already, in [0, 1]."""
    return np.asarray(values, dtype=np.float32) / np.float32(255)

"""Pixels of pictures without loss, in scripts that the page loads when a scene is opened.

A page that is opened from a disk may load scripts, but may read no other file. Such a script hands
over one object: for each picture its width, height, bits and packed numbers. To pack, each byte of
each channel is a plane, the high byte first; a byte of a plane is replaced by its difference from
the one to its left, modulo 256; and all planes are deflated (zlib) and written in base64.
`viewer/codec.js` unpacks.
"""

from __future__ import annotations

import base64
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
from isal import isal_zlib

from oitbench.image.files import Image

Codes = npt.NDArray[np.uint8] | npt.NDArray[np.uint16]
"""Numbers that stand for the values of a picture, shape (h, w) or (h, w, 3)."""
FUNCTION = "oitbenchPixels"
"""The function of the page that a script calls."""
_LEVEL = 1  # an eighth of the time that zlib takes at its level 3, for as many bytes
_LARGEST_HALF = float(np.finfo(np.float16).max)


def display_codes(srgb: Image) -> Codes:
    """Return the 8-bit levels of a displayed picture, whose values lie in [0, 1]."""
    levels: Codes = np.rint(255 * np.clip(srgb, 0, 1)).astype(np.uint8)
    return levels


def radiance_codes(image: Image) -> Codes:
    """Return the bits of linear radiance as half floats; finite values are limited to 65504."""
    limited = np.where(np.isfinite(image), np.clip(image, -_LARGEST_HALF, _LARGEST_HALF), image)
    halves: Codes = limited.astype(np.float16).view(np.uint16)
    return halves


def error_codes(errors: Image) -> Codes:
    """Return 255 times the square roots of errors in [0, 1], so that small ones stay distinct."""
    codes: Codes = np.rint(255 * np.sqrt(np.clip(errors, 0, 1))).astype(np.uint8)
    return codes


def pack(codes: Codes) -> dict[str, Any]:
    """Return the numbers of a picture as the page reads them."""
    height, width = codes.shape[:2]
    depth = codes.dtype.itemsize
    channels = np.moveaxis(codes.reshape(height, width, -1), 2, 0)
    # Big-endian numbers have their high byte first.
    octets = np.ascontiguousarray(channels.astype(f">u{depth}")).view(np.uint8)
    planes = np.moveaxis(octets.reshape(len(channels), height, width, depth), 3, 1)
    differences = np.diff(planes, axis=-1, prepend=np.uint8(0))
    data = base64.b64encode(isal_zlib.compress(differences.tobytes(), _LEVEL)).decode()
    return {"width": width, "height": height, "bits": 8 * depth, "data": data}


def write(path: Path, name: str, pictures: Mapping[str, Codes]) -> None:
    """Write the script of a scene.

    Parameters
    ----------
    path : Path
        Missing folders are created.
    name : str
        The scene's name on the page.
    pictures : mapping of str to array
        By the names that the page asks for.
    """
    packed = {key: pack(codes) for key, codes in pictures.items()}
    # Inside of a page, a `<` could end the script.
    texts = [json.dumps(value).replace("<", "\\u003c") for value in (name, packed)]
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(f"{FUNCTION}({', '.join(texts)});\n", encoding="utf-8")

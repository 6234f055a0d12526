"""Radiance pictures (`.hdr`): three mantissas of 8 bits that share an exponent.

No library that the suite needs anyway reads them without downloading a program. Reference: Ward
1991, "Real pixels", in Graphics Gems II; and the description of Radiance's file formats.
"""

from __future__ import annotations

import re

import numpy as np
import numpy.typing as npt

SIGNATURES = (b"#?RADIANCE", b"#?RGBE")
_HEAD = re.compile(rb"\n\n-Y (\d{1,6}) \+X (\d{1,6})\n")
_FORMAT = b"FORMAT=32-bit_rle_rgbe"
_LONGEST_HEAD = 1 << 16
_BIAS = 128 + 8


def size_of(content: bytes) -> tuple[int, int, int]:
    """Return height and width of a Radiance picture, and where its pixels begin.

    Raises
    ------
    ValueError
        The header is not one of a picture with its first row at the top.
    """
    head = _HEAD.search(content, 0, _LONGEST_HEAD)
    if not content.startswith(SIGNATURES) or head is None:
        raise ValueError("it has no header of a picture with its first row at the top")
    if _FORMAT not in content[: head.start() + 1]:
        raise ValueError("its pixels are not 32-bit_rle_rgbe")
    return int(head[1]), int(head[2]), head.end()


def decode(content: bytes) -> npt.NDArray[np.float32]:
    """Return the linear values of a Radiance picture, shape (h, w, 3), top row first.

    Raises
    ------
    ValueError
        The file is damaged, or of another kind.
    """
    height, width, at = size_of(content)
    data = np.frombuffer(content, np.uint8)
    # The least bytes that runs of 127 equal ones take.
    if len(data) - at < height * min(4 * width, 4 + 8 * (width // 127)):
        raise ValueError("it ends too early")
    packed = width >= 8 and data[at : at + 4].tolist() == [2, 2, width >> 8, width & 255]
    if not packed:
        flat = data[at : at + 4 * height * width]
        if len(flat) < 4 * height * width:
            raise ValueError("it ends too early")
        return _values(flat.reshape(height, width, 4))
    rows = np.empty((height, 4, width), dtype=np.uint8)
    for row in rows:
        if data[at : at + 4].tolist() != [2, 2, width >> 8, width & 255]:
            raise ValueError("a row has no mark of its length")
        at += 4
        for channel in row:
            at = _unpack(data, at, channel)
    return _values(rows.swapaxes(1, 2))


def _unpack(data: npt.NDArray[np.uint8], at: int, channel: npt.NDArray[np.uint8]) -> int:
    """Fill one channel of a row from runs and single bytes; return where the next one begins."""
    done, count = 0, len(channel)
    while done < count:
        if at + 1 >= len(data):
            raise ValueError("it ends too early")
        length = int(data[at])
        run = length > 128
        length -= 128 if run else 0
        part = data[at + 1 : at + 2] if run else data[at + 1 : at + 1 + length]
        if length == 0 or done + length > count or len(part) < (1 if run else length):
            raise ValueError("a run is longer than its row")
        channel[done : done + length] = part
        done, at = done + length, at + 1 + len(part)
    return at


def _values(rgbe: npt.NDArray[np.uint8]) -> npt.NDArray[np.float32]:
    # Mantissas are rounded down, so that the middle of a step is half of one higher.
    exponent = rgbe[..., 3:].astype(np.int32)
    values = np.ldexp(rgbe[..., :3].astype(np.float32) + np.float32(0.5), exponent - _BIAS)
    return np.where(exponent > 0, values, 0).astype(np.float32)

"""The hash functions of the shaders, bit for bit (Jarzynski & Olano 2020)."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

Words = npt.NDArray[np.uint32]


def pcg3d(x: npt.ArrayLike, y: npt.ArrayLike, z: npt.ArrayLike) -> tuple[Words, Words, Words]:
    """Return the hash of three arrays of words."""
    a, b, c = (
        np.asarray(v, np.uint32) * np.uint32(1664525) + np.uint32(1013904223) for v in (x, y, z)
    )
    a, b, c = _mixed(a, b, c)
    shift = np.uint32(16)
    return _mixed(a ^ (a >> shift), b ^ (b >> shift), c ^ (c >> shift))


def _mixed(a: Words, b: Words, c: Words) -> tuple[Words, Words, Words]:
    a = a + b * c
    b = b + c * a
    c = c + a * b
    return a, b, c


def pcg(v: Words) -> Words:
    """Return the hash of an array of words."""
    state = v * np.uint32(747796405) + np.uint32(2891336453)
    word = ((state >> ((state >> np.uint32(28)) + np.uint32(4))) ^ state) * np.uint32(277803737)
    return np.asarray((word >> np.uint32(22)) ^ word)


def fraction(words: Words) -> npt.NDArray[np.float32]:
    """Return the high 24 bits of words as numbers in [0, 1)."""
    return np.asarray((words >> np.uint32(8)).astype(np.float32) / np.float32(2**24))

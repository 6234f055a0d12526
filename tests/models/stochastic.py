"""Stochastic transparency with the very random numbers of the shaders: bit for bit the same masks.

After Enderton et al. 2010; hashes after Jarzynski & Olano 2020; selection sampling after Knuth,
The Art of Computer Programming, volume 2, algorithm 3.4.2 S.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from oitbench.scene import Floats, FragmentLists
from tests.models.commutative import layers_of

Words = npt.NDArray[np.uint32]


def hash_words(x: npt.ArrayLike, y: npt.ArrayLike, z: npt.ArrayLike) -> tuple[Words, Words, Words]:
    """Return pcg3d of three arrays of words."""
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


def hash_word(v: Words) -> Words:
    """Return pcg of an array of words."""
    state = v * np.uint32(747796405) + np.uint32(2891336453)
    word = ((state >> ((state >> np.uint32(28)) + np.uint32(4))) ^ state) * np.uint32(277803737)
    return np.asarray((word >> np.uint32(22)) ^ word)


def masks(
    opacity: npt.NDArray[np.float32], samples: int, seed: int = 1, iteration: int = 0
) -> npt.NDArray[np.bool_]:
    """Return which samples each layer takes, shape (n, h, w, samples); top row first.

    The layer's index is its primitive's.
    """
    height = opacity.shape[1]
    stream = hash_words(*(np.array([v], np.uint32) for v in (seed, iteration, 0)))
    layer, row, column = np.indices(opacity.shape)
    place = (column, height - 1 - row, layer)
    x, y, z = hash_words(
        *(np.asarray(p, np.uint32) ^ s for p, s in zip(place, stream, strict=True))
    )
    uniform = (x >> np.uint32(8)).astype(np.float32) / np.float32(2**24)
    wanted = (opacity * np.float32(samples) + uniform).astype(np.uint32)
    wanted = np.minimum(wanted, np.uint32(samples))
    taken = np.zeros((*opacity.shape, samples), dtype=np.bool_)
    state = y
    for sample in range(samples):
        state = hash_word(state + z)
        high = (state.astype(np.uint64) * np.uint64(samples - sample)) >> np.uint64(32)
        taken[..., sample] = high < wanted
        wanted = wanted - taken[..., sample]
    return taken


def composite(
    lists: FragmentLists,
    background: npt.ArrayLike,
    samples: int,
    correction: str,
    seed: int = 1,
) -> Floats:
    """Return the picture of lists in order of submission, gray or without transmission."""
    color, opacity = layers_of(lists)
    rounds = -(-samples // 32)
    each = samples // rounds
    share = np.zeros(opacity.shape)
    z = lists.z[..., None]
    for iteration in range(rounds):
        taken = masks(opacity.astype(np.float32), each, seed, iteration)
        nearest = np.where(taken, z, np.inf).min(axis=0)
        seen = z <= nearest
        share += (seen if correction == "depth" else seen & taken).sum(axis=-1) / samples
    if correction != "depth":
        share = np.divide(share, opacity, out=np.zeros_like(share), where=opacity > 0)
    total = (color * share[..., None]).sum(axis=0)
    covered = (opacity * share).sum(axis=0)
    if correction == "none":
        return np.asarray(total + np.asarray(background) * (1 - covered)[..., None])
    passed = (1 - opacity).prod(axis=0)
    plain = (covered == 0) | ((correction == "depth") & (1 - passed < 1 / 64))
    factor = np.divide(1 - passed, covered, out=np.ones_like(covered), where=~plain)
    return np.asarray(total * factor[..., None] + np.asarray(background) * passed[..., None])

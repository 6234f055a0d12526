"""Stochastic transparency with the random numbers of the shaders: masks are bit for bit the same.

Enderton et al. 2010. Selection sampling is algorithm 3.4.2 S of Knuth, The Art of Computer
Programming, volume 2.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from oitbench.method.blue_noise import SIDE, void_and_cluster
from oitbench.scene import Floats, FragmentLists
from tests.models.commutative import layers_of
from tests.models.hashing import Words, fraction, pcg, pcg3d

_NONE = np.uint32(0xFFFFFFFF)


def masks(
    opacity: npt.NDArray[np.float32],
    samples: int,
    seed: int = 1,
    iteration: int = 0,
    frame: int = 0,
    noise: str = "white",
) -> npt.NDArray[np.bool_]:
    """Return which samples each layer takes, shape (n, h, w, samples), top row first.

    The index of a layer is that of its primitive.
    """
    height = opacity.shape[1]
    stream = pcg3d(*(np.array([v], np.uint32) for v in (seed, iteration, frame)))
    layer, row, column = np.indices(opacity.shape)
    place = (column, height - 1 - row, layer)
    x, y, z = pcg3d(*(np.asarray(p, np.uint32) ^ s for p, s in zip(place, stream, strict=True)))
    if noise == "blue":
        source = (_NONE ^ stream[0], _NONE ^ stream[1], layer.astype(np.uint32) ^ stream[2])
        x = _blue(column, height - 1 - row, source, x)
    wanted = (opacity * np.float32(samples) + fraction(x)).astype(np.uint32)
    wanted = np.minimum(wanted, np.uint32(samples))
    taken = np.zeros((*opacity.shape, samples), dtype=np.bool_)
    state = y
    for sample in range(samples):
        state = pcg(state + z)
        high = (state.astype(np.uint64) * np.uint64(samples - sample)) >> np.uint64(32)
        taken[..., sample] = high < wanted
        wanted = wanted - taken[..., sample]
    return taken


def _blue(
    column: npt.ArrayLike, row: npt.ArrayLike, stream: tuple[Words, ...], low: Words
) -> Words:
    """Return words whose high 12 bits are the mask, shifted by the hash of a stream."""
    x, y = (
        (np.asarray(place) + (shift >> np.uint32(16))) % SIDE
        for place, shift in zip((column, row), pcg3d(*stream)[:2], strict=True)
    )
    rank = void_and_cluster(SIDE, 1)[y, x].astype(np.uint32)
    return np.asarray(rank << np.uint32(20) | low >> np.uint32(12))


def composite(
    lists: FragmentLists,
    background: npt.ArrayLike,
    samples: int,
    correction: str,
    seed: int = 1,
    frame: int = 0,
    noise: str = "white",
) -> Floats:
    """Return the picture of one frame of lists in submission order; transmission must be gray."""
    color, opacity = layers_of(lists)
    rounds = -(-samples // 32)
    each = samples // rounds
    share = np.zeros(opacity.shape)
    z = lists.z[..., None]
    for iteration in range(rounds):
        taken = masks(opacity.astype(np.float32), each, seed, iteration, frame, noise)
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

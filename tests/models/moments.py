"""Moment-based transparency in double precision, by the published steps: solve, roots, weights."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from oitbench.scene import Floats

GAP = 0.1 * np.pi
"""Angle without layers."""
BIASES = {
    ("power", "float"): {4: 5e-7, 6: 5e-6, 8: 5e-5},
    ("power", "unorm16"): {4: 6e-5, 6: 6e-4, 8: 2.5e-3},
    ("trigonometric", "float"): {4: 4e-7, 6: 8e-7, 8: 1.5e-6},
    ("trigonometric", "unorm16"): {4: 4e-4, 6: 6.5e-4, 8: 8.5e-4},
}
_EVEN = {
    "float": {
        4: (0.375, 0.375),
        6: (0.48, 0.451, 0.45),
        8: (0.75, 0.67666667, 0.63, 0.60030303),
    },
    "unorm16": {
        4: (0.628, 0.628),
        6: (0.5566, 0.489, 0.47869382),
        8: (0.42474916387959866, 0.22407802675585284, 0.15369230769230768, 0.12900440529089119),
    },
}


_ODD = {
    4: [[1.5, -2.0], [np.sqrt(3) / 2, -2 * np.sqrt(3) / 9]],
    6: [
        [2.5, -10.0, 8.0],
        [-1.87499864450, 4.20757543111, -1.83257678661],
        [1.26583039016, -1.47644882902, 0.71061660238],
    ],
    8: [
        [3.48044635732474, -27.5760737514826, 55.1267384344761, -31.5311110403183],
        [1.26797185782836, -0.928755808743913, -2.07520453231032, 1.23598848322588],
        [-2.1671560004294, 6.17950199592966, -0.276515571579297, -4.23583042392097],
        [0.974332879165755, -0.443426830933027, -0.360491648368785, 0.310149466050223],
    ],
}
_EVEN_ROWS = {
    4: [[4.0, -4.0], [0.5, 0.5]],
    6: [
        [4.0, -4.0, 0.0],
        [9.0, -24.0, 16.0],
        [-0.57759806484, 4.61936647543, -3.07953906655],
    ],
    8: [
        [0.280504133158527, -0.757633844606942, 0.392179589334688, -0.887531871812237],
        [-2.01362265883247, 0.221551373038988, -1.06107954265125, 2.83887201588367],
        [-7.31010494985321, 13.9855979699139, -0.114305766176437, -7.4361899359832],
        [-15.8954215629556, 79.6186327084103, -127.457278992502, 63.7349456687829],
    ],
}
_EVEN_OFFSETS = {
    4: (0.0, 0.0),
    6: (0.0, 0.0, 0.018888946),
    8: (0.972481993925964, 1.0, 0.999179192513328, 0.991778293073131),
}


def quantized(x: Floats, basis: str, count: int) -> Floats:
    """Return the moments of single places in [0, 1], as 16-bit storage keeps them, (..., count)."""
    if basis == "trigonometric":
        angle = ((x + 1) * (np.pi - GAP / 2))[..., None] * np.arange(1, count // 2 + 1)
        waves = np.stack([np.cos(angle), np.sin(angle)], axis=-1)
        return np.asarray(waves.reshape(*x.shape, count) / 2 + 0.5)
    powers = x[..., None] ** np.arange(1, count + 1)
    odd = powers[..., 0::2] @ np.transpose(_ODD[count]) + 0.5
    even = powers[..., 1::2] @ np.transpose(_EVEN_ROWS[count]) + _EVEN_OFFSETS[count]
    return np.concatenate([odd, even], axis=-1)


def neutral(count: int, storage: str) -> Floats:
    """Return the moments that the others are mixed with."""
    values = np.zeros(count)
    values[1::2] = _EVEN[storage][count]
    return values


def power_share(x: Floats, weights: Floats, at: float, count: int, storage: str) -> Floats:
    """Return the part of the weights before `at`, and the weight there."""
    half, bias = count // 2, BIASES["power", storage][count]
    moments = np.array([(weights * x**j).sum() for j in range(1, count + 1)]) / weights.sum()
    full = np.array([1.0, *((1 - bias) * moments + bias * neutral(count, storage))])
    hankel = full[np.add.outer(np.arange(half + 1), np.arange(half + 1))]
    solved = np.linalg.solve(hankel, at ** np.arange(half + 1))
    nodes = np.array([at, *np.roots(solved[::-1]).real])
    parts = np.linalg.solve(np.vander(nodes, half + 1, increasing=True).T, full[: half + 1])
    return np.array([parts[1:][nodes[1:] < at].sum(), parts[0]])


def trigonometric_share(x: Floats, weights: Floats, at: float, count: int, storage: str) -> Floats:
    """Return the same from moments on the circle; a root in the gap counts in part."""
    half, bias = count // 2, BIASES["trigonometric", storage][count]
    angles = (x + 1) * (np.pi - GAP / 2)
    orders = np.arange(1, half + 1)
    waves = np.exp(1j * orders[:, None] * angles)
    moments = (1 - bias) * (weights * waves).sum(axis=1) / weights.sum()
    full = np.array([1.0, *moments])
    index = np.subtract.outer(np.arange(half + 1), np.arange(half + 1))
    toeplitz = np.where(index >= 0, full[abs(index)], full[abs(index)].conj())
    angle = (at + 1) * (np.pi - GAP / 2)
    solved = np.linalg.solve(toeplitz, np.exp(1j * angle * np.arange(half + 1)))
    roots = np.roots(solved.conj()[::-1])
    nodes = np.array([np.exp(1j * angle), *(roots / abs(roots))])
    parts = np.linalg.solve(np.vander(nodes, half + 1, increasing=True).T, full).real
    found = np.angle(nodes[1:]) % (2 * np.pi)
    before = (found < angle) + np.clip((found - 2 * np.pi + GAP) / GAP, 0, 1)
    return np.array([(parts[1:] * before).sum(), parts[0]])


def composite(
    places: Floats,
    colors: Floats,
    opacities: Floats,
    background: npt.ArrayLike,
    basis: str,
    count: int,
    storage: str = "float",
    overestimation: float = 0.25,
) -> Floats:
    """Return the picture of lists.

    Parameters
    ----------
    places : array, shape (n, h, w)
        In [-1, 1].
    colors : array, shape (n, h, w, 3)
        alpha L.
    opacities : array, shape (n, h, w)
    background : array, shape (3,)
    basis, count, storage, overestimation
        Parameters of the method.
    """
    absorbance = -np.log(np.maximum(1 - opacities, 1e-5))
    share_at = power_share if basis == "power" else trigonometric_share
    image = np.zeros((*places.shape[1:], 3))
    for pixel in np.ndindex(*places.shape[1:]):
        at = (slice(None), *pixel)
        x, a = places[at], absorbance[at]
        seen = np.ones(len(x))
        for i in range(len(x) if a.sum() > 0 else 0):
            front, own = share_at(x, a, x[i], count, storage)
            share = np.clip(front + overestimation * own, 0, 1)
            seen[i] = np.exp(-min(a.sum() * share, 60))
        hidden = -np.expm1(-a.sum())
        weight = (-np.expm1(-a) * seen).sum()
        light = (colors[at] * seen[:, None]).sum(axis=0)
        light *= hidden / weight if hidden > 1e-4 else 1.0
        image[pixel] = light + (1 - hidden) * np.asarray(background)
    return image

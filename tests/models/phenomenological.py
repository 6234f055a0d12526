"""Phenomenological transparency in double precision (McGuire & Mara 2017), stage by stage."""

from __future__ import annotations

from itertools import product

import numpy as np
import numpy.typing as npt

from oitbench.measure.oracle import transmittances
from oitbench.scene import Floats, FragmentLists
from tests.models.commutative import layers_of

K0, K1 = 0.375, 0.5
CUTS = {"disk": 2.0, "gaussian": 3.5, "listing": 1.0}
"""Radius of each kernel in multiples of D."""


def depth_weight(opacity: Floats, depth: Floats, equation: str = "eq5") -> Floats:
    """Return the weight w for a net opacity and a window depth."""
    near = 1 - 0.99 * depth
    if equation == "g3d":
        return np.clip(opacity * np.clip(1e4 * near**3, 1e-3, 1), 1e-3, 150)
    return np.clip((10 * near * opacity) ** 3, 0.01, 30)


def self_modulation(beta: Floats, kind: str) -> Floats:
    """Return S, the factor on the mean layer."""
    most = beta.max(axis=-1, keepdims=True)
    if kind == "tvcg":
        return np.asarray(0.5 + np.maximum(beta, 1e-3) / np.maximum(2e-3, 2 * most))
    if kind == "i3d":
        return np.asarray(0.5 + 0.5 * beta / np.maximum(0.01, most))
    return np.ones_like(beta)


def composite(
    lists: FragmentLists,
    background: npt.ArrayLike,
    modulation: str = "tvcg",
    equation: str = "eq5",
    near: float = 0.1,
) -> Floats:
    """Return beta C0 + (1 − beta) S U for fragments without refraction and diffusion."""
    color, opacity = layers_of(lists)
    w = depth_weight(opacity, 1 - near / lists.z.astype(np.float64), equation)
    total = (w * opacity).sum(axis=0)[..., None]
    mean = (w[..., None] * color).sum(axis=0) / np.maximum(total, 1e-5)
    beta = transmittances(lists).prod(axis=0)
    return np.asarray(
        beta * np.asarray(background) + (1 - beta) * self_modulation(beta, modulation) * mean
    )


def blur(
    focal: float,
    collimation: float,
    weight: float,
    z: npt.ArrayLike,
    behind: npt.ArrayLike,
    k0: float = K0,
    k1: float = K1,
) -> Floats:
    """Return D of one layer in pixels; `focal` is in pixels, distances are in meters."""
    distance = np.asarray(z, dtype=np.float64)
    gap = np.abs(np.asarray(behind, dtype=np.float64) - distance)
    return np.asarray(focal * k0 * (1 - collimation) * weight * (1 - k1 / (k1 + gap)) / distance)


def medium_blur(
    focal: float, collimation: float, z: npt.ArrayLike, behind: npt.ArrayLike
) -> Floats:
    """Return D of one optical depth of a medium at distance z, in pixels."""
    distance = np.asarray(z, dtype=np.float64)
    total = np.asarray(behind, dtype=np.float64)
    slope = 2 * K0 / (K1 + 2.5) * (1 - collimation)
    return np.asarray(focal * slope * (total - distance) / total)


def bent(toward_eye: Floats, normal: Floats, eta: float) -> Floats:
    """Return the unit directions (..., 3) of refracted rays, by Snell; NaN for total reflection."""
    cosine = (toward_eye * normal).sum(axis=-1, keepdims=True)
    k = 1 - eta**2 * (1 - cosine**2)
    return np.asarray(
        -eta * toward_eye + (eta * cosine - np.sqrt(np.where(k < 0, np.nan, k))) * normal
    )


def offset(
    focal: float,
    position: Floats,
    normal: Floats,
    index: float,
    reach: npt.ArrayLike,
    *,
    entering: bool,
) -> Floats:
    """Return the offset (..., 2) of the background behind one surface, in pixels right and up.

    Parameters
    ----------
    focal : float
        Focal length, pixels.
    position, normal : array, shape (..., 3)
        Of the surface in camera space, meters; the normal on the side of the eye.
    index : float
        Of the solid that the surface bounds.
    reach : array, shape (...)
        Meters along the view axis from the surface to the background.
    entering : bool
        Whether the view ray enters the solid. Where it leaves, the ray inside is the one that the
        surface would bend the view ray to, and the offset has the opposite sign.
    """
    toward_eye = -position / np.linalg.norm(position, axis=-1, keepdims=True)
    inside = bent(toward_eye, normal, 1 / index)
    target = position + np.asarray(reach)[..., None] * inside / np.abs(inside[..., 2:])
    pixels = [focal * p[..., :2] / -p[..., 2:] for p in (target, position)]
    return np.asarray(pixels[0] - pixels[1] if entering else pixels[1] - pixels[0])


def gather(
    picture: Floats, blurs: Floats, offset: Floats, radius: float, kernel: str = "disk"
) -> Floats:
    """Return the picture blurred over D = `blurs`, at `offset` (..., 2) pixels right and down.

    Taps are two pixels apart and at most `radius` pixels from the center.
    """
    height, width = blurs.shape
    cut = CUTS[kernel]
    rows, columns = np.indices(blurs.shape)
    x = np.floor(columns + 0.5 + offset[..., 0]).astype(int)
    y = np.floor(rows + 0.5 + offset[..., 1]).astype(int)
    reach = np.minimum(cut * blurs, radius).astype(int)
    total, weights = np.zeros(picture.shape), np.zeros(blurs.shape)
    most = int(radius) // 2 * 2
    for dy, dx in product(range(-most, most + 1, 2), repeat=2):
        tap = np.clip(y + dy, 0, height - 1), np.clip(x + dx, 0, width - 1)
        there, square = blurs[tap], dx * dx + dy * dy
        variance = np.maximum(there**2, 1.0)
        gauss = kernel == "gaussian"
        weight = np.exp(-square / (2 * variance)) if gauss else 1 / variance + 1e-5
        within = square <= (cut * np.minimum(blurs, there)) ** 2
        weight = np.where(within & (max(abs(dx), abs(dy)) <= reach), weight, 0.0)
        total += weight[..., None] * picture[tap]
        weights += weight
    blurred = total / np.maximum(weights, 1e-20)[..., None]
    return np.where(blurs[..., None] > 0, blurred, picture)

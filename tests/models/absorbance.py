"""Opacity maps and Fourier maps in double precision."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from oitbench.scene import Floats

Curve = Callable[[Floats, Floats, Floats], Floats]
"""Takes u and a of the layers, (n, ...), and places, (m, ...); returns absorbances, (m, ...)."""


def opacity_map(slices: int) -> Curve:
    """Return the curve of the sums at slices, linear between slices."""
    edges = np.arange(slices + 1) / slices

    def absorbed(u: Floats, a: Floats, places: Floats) -> Floats:
        sums = [(np.where(u <= edge, a, 0)).sum(axis=0) for edge in edges]
        sums[0] = np.zeros_like(sums[0])
        index = np.minimum(np.floor(places * slices), slices - 1).astype(int)
        front = np.take_along_axis(np.stack(sums), index, axis=0)
        behind = np.take_along_axis(np.stack(sums), index + 1, axis=0)
        return np.asarray(front + (behind - front) * (places * slices - index))

    return absorbed


def fourier_map(coefficients: int, lanczos: bool) -> Curve:
    """Return the truncated Fourier series (Jansen & Bavoil 2010)."""
    harmonics = (coefficients - 1) // 2

    def absorbed(u: Floats, a: Floats, places: Floats) -> Floats:
        sum_: Floats = a.sum(axis=0) * places
        for k in range(1, harmonics + 1):
            frequency = 2 * np.pi * k
            cosine = 2 * (a * np.cos(frequency * u)).sum(axis=0)
            sine = 2 * (a * np.sin(frequency * u)).sum(axis=0)
            wave = cosine * np.sin(frequency * places) + sine * (1 - np.cos(frequency * places))
            sum_ = sum_ + wave / frequency * (np.sinc(k / (harmonics + 1)) if lanczos else 1)
        return sum_

    return absorbed


def composite(
    depths: Floats, colors: Floats, factors: Floats, background: npt.ArrayLike, absorbed: Curve
) -> Floats:
    """Return the picture of lists.

    Parameters
    ----------
    depths : array, shape (n, h, w)
    colors : array, shape (n, h, w, 3)
        alpha L.
    factors : array, shape (n, h, w, c)
        Transmittance of each layer: one channel, or three channels with separate curves.
    """
    dark = (factors < 1).any(axis=-1)
    nearest = np.where(dark, depths, np.inf).min(axis=0)
    farthest = np.where(dark, depths, -np.inf).max(axis=0)
    nearest = np.where(np.isinf(nearest), depths.max(axis=0), nearest)
    farthest = np.where(np.isinf(farthest), depths.max(axis=0), farthest)
    u = np.clip((depths - nearest) / np.maximum(farthest - nearest, 1e-6), 0, 1)[..., None]
    a = -np.log(np.maximum(factors, 1e-5))
    seen = np.exp(-np.maximum(absorbed(u, a, u), 0))
    through = np.exp(-a.sum(axis=0))
    return np.asarray((colors * seen).sum(axis=0) + through * np.asarray(background))

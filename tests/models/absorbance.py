"""Opacity maps, Fourier maps and wavelets in double precision."""

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


def bin_means(x: Floats, a: Floats, bins: int) -> Floats:
    """Return the mean of A(x) = sum of a_i with x_i < x over each bin, shape (bins, ...)."""
    parts = [(a * np.clip(b + 1 - bins * x, 0, 1)).sum(axis=0) for b in range(bins)]
    return np.stack(parts)


def wavelet(rank: int, correction: bool = True) -> Curve:
    """Return the means of bins, linear between bins; `places` must be those of the layers."""
    bins = 2 ** (rank + 1)

    def absorbed(u: Floats, a: Floats, places: Floats) -> Floats:
        x = u * (bins - 1) / bins
        means = np.concatenate([np.zeros((1, *a.shape[1:])), bin_means(x, a, bins)])
        place = places * (bins - 1)
        index = np.floor(place).astype(int)
        inside = place - index
        before = np.take_along_axis(means, index, axis=0)
        here = np.take_along_axis(means, index + 1, axis=0)
        own = a * (1 - inside) if correction else 0
        return np.asarray(before + (here - own - before) * inside)

    return absorbed


def composite(
    depths: Floats,
    colors: Floats,
    factors: Floats,
    background: npt.ArrayLike,
    absorbed: Curve,
    normalized: bool = False,
    margins: tuple[float, float] = (0.0, 0.0),
) -> Floats:
    """Return the picture of lists.

    Parameters
    ----------
    depths : array, shape (n, h, w)
    colors : array, shape (n, h, w, 3)
        alpha L.
    factors : array, shape (n, h, w, c)
        Transmittance of each layer: one channel, or three channels with separate curves.
    background : array, shape (3,)
    absorbed : callable
    normalized : bool
        Whether the sum of layers is divided by the sum of their weights.
    margins : (float, float)
        Meters before the nearest and behind the farthest layer.
    """
    dark = (factors < 1).any(axis=-1)
    nearest = np.where(dark, depths, np.inf).min(axis=0)
    farthest = np.where(dark, depths, -np.inf).max(axis=0)
    nearest = np.where(np.isinf(nearest), depths.max(axis=0), nearest)
    farthest = np.where(np.isinf(farthest), depths.max(axis=0), farthest)
    extent = np.maximum(farthest - nearest + sum(margins), 1e-6)
    u = np.clip((depths - nearest + margins[0]) / extent, 0, 1)[..., None]
    a = -np.log(np.maximum(factors, 1e-5))
    seen = np.exp(-np.clip(absorbed(u, a, u), 0, 60))
    light = (colors * seen).sum(axis=0)
    hidden = -np.expm1(-a.sum(axis=0))
    if normalized:
        weight = (-np.expm1(-a) * seen).sum(axis=0)
        bright = (hidden > 1e-4) & (weight > 0)
        light = light * np.where(bright, hidden / np.where(bright, weight, 1), 1)
    return np.asarray(light + (1 - hidden) * np.asarray(background))

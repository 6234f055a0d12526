"""Light that layers let through along one ray, by the forms of translucent shadows, in float64."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from oitbench.scene import Floats


def first_hits(taus: Sequence[float]) -> Floats:
    """Return the probability that a ray ends at each layer, and that it passes all of them."""
    passed = np.cumprod([1.0, *taus])
    return np.append(passed[:-1] - passed[1:], passed[-1])


def _moment_light(mean: float, variance: float, z: float, own: float) -> float:
    bound = variance / (variance + (z - mean) ** 2) if variance else float(z <= mean)
    return 1 - own * bound if z <= mean else (1 - own) * bound


def published_light(
    layers: Sequence[float], taus: Sequence[float], opaque: float, z: float | None = None
) -> float:
    """Return Chebyshev's bound at `z` of moments that include an opaque surface behind all layers.

    By default the opaque surface itself is lit.
    """
    ends, hits = np.array([*layers, opaque]), first_hits(taus)
    mean = float(hits @ ends)
    variance = float(hits @ (ends - mean) ** 2)
    return _moment_light(mean, variance, opaque if z is None else z, 0.0)


def occluder_light(
    layers: Sequence[float], taus: Sequence[float], z: float, own: float = 0.0
) -> float:
    """Return the light at `z` by the moments of the layers alone and their weight.

    `own` is 0 for Chebyshev's bound, and 1/2 for the middle of both bounds, as for particles.
    """
    hits = first_hits(taus)[:-1]
    weight, ends = float(hits.sum()), np.asarray(layers)
    mean = float(hits @ ends) / weight
    variance = float(hits @ (ends - mean) ** 2) / weight
    return 1 - weight + weight * _moment_light(mean, variance, z, own)


def traced_light(layers: Sequence[float], taus: Sequence[float], z: float) -> float:
    """Return the light at `z` behind all nearer layers."""
    return float(np.prod([tau for end, tau in zip(layers, taus, strict=True) if end < z]))

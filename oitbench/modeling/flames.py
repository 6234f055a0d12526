"""Light that is added to what lies behind it: its material, and pictures of flames and sparks."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from oitbench.modeling.baking import tint
from oitbench.scene import RGB, Floats, Material, Texture

SIDE = 128
"""Texels along a side of a picture."""
EDGE = 0.92
"""Half the width of a picture in [−1, 1]; the rest is an empty border."""


def added_light(coverage: Texture, radiance: RGB | Texture, opacity: float = 0.0) -> Material:
    """Return a material that adds `coverage` times `radiance` to what is behind it.

    Its transmission is 1 − `opacity`: at 0, its transmittance is exactly one for any coverage.
    """
    clear = 1 - opacity
    return Material(
        coverage=coverage, emission=radiance, transmission=(clear, clear, clear), specular=0.0
    )


def plane() -> tuple[Floats, Floats]:
    """Return x and y in [−1, 1] at the texels of a picture, each of shape (SIDE, SIDE); y is up."""
    line = (np.arange(SIDE) + 0.5) / SIDE * 2 - 1
    x, y = np.meshgrid(line, line[::-1])
    return x, y


def flame(bend: float, ramp: Sequence[RGB]) -> tuple[Texture, Texture]:
    """Return the coverage and the radiance of a lick of flame that rises from the lower edge.

    Parameters
    ----------
    bend : float
        How far the tip bends to the right; about 1.
    ramp : sequence of RGB
        Radiance from the rim of the flame to its heart.
    """
    x, y = plane()
    along = np.clip((y + EDGE) / (2 * EDGE), 0, 1)
    middle = bend * along * (0.30 * np.sin(4.2 * along + 0.4) + 0.10 * np.sin(11 * along))
    wide = 0.62 * along**0.45 * (1 - along) ** 0.85 + 1e-3
    shape = np.clip(1 - ((x - middle) / wide) ** 2, 0, 1) ** 1.3
    coverage = shape * np.clip(along / 0.25, 0, 1) * (1 - along) ** 0.35
    heat = np.clip(shape * (1.15 - 0.85 * along), 0, 1)
    radiance = tint(heat.ravel(), ramp).reshape(SIDE, SIDE, 3)
    coverage = coverage * (np.maximum(np.abs(x), np.abs(y)) < EDGE)
    return Texture(coverage.astype(np.float32)), Texture(radiance.astype(np.float32))


def spark() -> Texture:
    """Return the coverage of a round spark, which fades from its middle."""
    x, y = plane()
    return Texture((np.clip(1 - np.hypot(x, y) / EDGE, 0, 1) ** 2).astype(np.float32))


def halo(lines: Sequence[Floats], reach: float) -> Texture:
    """Return the coverage of the light around lines: it falls by e in a distance of `reach`.

    Parameters
    ----------
    lines : sequence of array, shape (n, 2)
        Points of each line in the picture, (x, y) in [−1, 1].
    reach : float
        Where 2 is the width of the picture.
    """
    x, y = plane()
    points = np.concatenate(lines)
    away = np.hypot(x[..., None] - points[:, 0], y[..., None] - points[:, 1]).min(axis=-1)
    fade = np.clip(1 - np.maximum(np.abs(x), np.abs(y)) / EDGE, 0, 1) ** 0.5
    return Texture((np.exp(-away / reach) * fade).astype(np.float32))

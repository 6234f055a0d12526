"""Surroundings whose radiance changes with height alone."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from oitbench.scene import RGB, EnvironmentLight, Texture

ROWS = 64  # texels from straight up to straight down; a map is twice as wide


def gradient_sky(stops: Sequence[tuple[float, RGB]]) -> EnvironmentLight:
    """Return surroundings that run through `stops` from below to above.

    Parameters
    ----------
    stops : sequence of (elevation, radiance)
        Elevation over the horizon in degrees, ascending in [−90, 90], and linear Rec.709 radiance;
        linear between, constant beyond the first and the last.
    """
    elevation = 90 - (np.arange(ROWS) + 0.5) / ROWS * 180
    heights, colors = zip(*stops, strict=True)
    column = np.stack(
        [np.interp(elevation, heights, part) for part in np.transpose(colors)], axis=1
    )
    texels = np.broadcast_to(column[:, None], (ROWS, 2 * ROWS, 3))
    return EnvironmentLight(Texture(np.ascontiguousarray(texels, dtype=np.float32)))

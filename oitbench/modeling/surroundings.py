"""Surroundings: environment lights of a sky, or of a room with windows.

A new sky or room is a function that returns an `EnvironmentLight`.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from oitbench.scene import RGB, EnvironmentLight, Floats, Texture

ROWS = 64
"""Texels of a map from straight up to straight down; it is twice as wide."""


def gradient_sky(stops: Sequence[tuple[float, RGB]]) -> EnvironmentLight:
    """Return surroundings whose radiance changes with elevation alone.

    Parameters
    ----------
    stops : sequence of (float, RGB)
        Elevations above the horizon in degrees, ascending in [−90, 90], with their radiance; linear
        in between, constant beyond the first and the last.
    """
    elevation = 90 - (np.arange(ROWS) + 0.5) / ROWS * 180
    heights, colors = zip(*stops, strict=True)
    column = np.stack(
        [np.interp(elevation, heights, part) for part in np.transpose(colors)], axis=1
    )
    texels = np.broadcast_to(column[:, None], (ROWS, 2 * ROWS, 3))
    return EnvironmentLight(Texture(np.ascontiguousarray(texels, dtype=np.float32)))


@dataclass(frozen=True)
class Window:
    """A bright rectangle of a room, with soft edges.

    Parameters
    ----------
    azimuth, elevation : float
        Direction of its middle in radians: to the right of straight ahead (−z), and above the
        horizon.
    width, height : float
        Full angles, radians.
    radiance : RGB
    """

    azimuth: float
    elevation: float
    width: float
    height: float
    radiance: RGB


def room(ceiling: RGB, walls: RGB, floor: RGB, windows: Sequence[Window] = ()) -> EnvironmentLight:
    """Return the surroundings of a room: a ceiling, walls, a floor and windows.

    Parameters
    ----------
    ceiling, walls, floor : RGB
        Radiance straight up, at the horizon and straight down; smooth in between.
    windows : sequence of Window
        A later one covers an earlier one. Default: none.
    """
    elevation = (0.5 - (np.arange(ROWS) + 0.5) / ROWS) * math.pi
    azimuth = ((np.arange(2 * ROWS) + 0.5) / ROWS - 1) * math.pi
    height = np.sin(elevation)[:, None, None]
    level, up, down = (np.asarray(color) for color in (walls, ceiling, floor))
    far = np.where(height > 0, up, down)
    picture = np.repeat(level + (far - level) * height**2, 2 * ROWS, axis=1)
    edge = 2 * math.pi / ROWS
    for window in windows:
        turn = (azimuth - window.azimuth + math.pi) % (2 * math.pi) - math.pi
        across = _plateau(turn, window.width, edge)
        along = _plateau(elevation - window.elevation, window.height, edge)
        covered = (along[:, None] * across[None])[..., None]
        picture = picture + covered * (np.asarray(window.radiance) - picture)
    return EnvironmentLight(Texture(picture.astype(np.float32)))


def _plateau(angle: Floats, width: float, edge: float) -> Floats:
    """Return 1 within `width` and 0 outside, with a ramp `edge` wide in between."""
    return np.asarray(np.clip((width / 2 - np.abs(angle)) / edge + 0.5, 0, 1))

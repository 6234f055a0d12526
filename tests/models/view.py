"""The rays of a camera in double precision."""

from __future__ import annotations

import numpy as np

from oitbench.scene import Camera, Floats


def rays(camera: Camera, size: tuple[int, int]) -> Floats:
    """Return the directions through the centers of pixels, shape (h, w, 3), top row first.

    Directions are in world space. Their component along the view axis is one meter.
    """
    width, height = size
    pixel = 2 * np.tan(camera.fov_y / 2) / height
    x = (np.arange(width) + 0.5 - width / 2) * pixel
    y = (height / 2 - np.arange(height) - 0.5) * pixel
    ahead = np.stack([*np.meshgrid(x, y), -np.ones((height, width))], axis=-1)
    return np.asarray(ahead @ camera.axes)

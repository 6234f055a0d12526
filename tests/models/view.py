"""The rays of a camera in double precision."""

from __future__ import annotations

import numpy as np

from oitbench.scene import Camera, Floats


def rays(camera: Camera, size: tuple[int, int]) -> Floats:
    """Return the directions through the centers of pixels, shape (h, w, 3), top row first.

    Directions are in world space. Their component along the view axis is one meter.
    """
    width, height = size
    slopes = np.zeros((height, width, 2)) if camera.orthographic else _on_picture(camera, size)
    ahead = np.concatenate([slopes, -np.ones((height, width, 1))], axis=-1)
    return np.asarray(ahead @ camera.axes)


def origins(camera: Camera, size: tuple[int, int]) -> Floats:
    """Return where the rays leave the plane of the camera, shape (h, w, 3), top row first."""
    position = np.asarray(camera.position, dtype=np.float64)
    if not camera.orthographic:
        return np.broadcast_to(position, (size[1], size[0], 3))
    return np.asarray(position + _on_picture(camera, size) @ camera.axes[:2])


def _on_picture(camera: Camera, size: tuple[int, int]) -> Floats:
    """Return the centers of pixels to the right and up, meters on a plane one meter ahead."""
    width, height = size
    tall = 2 * np.tan(camera.fov_y / 2) if camera.height is None else camera.height
    x = (np.arange(width) + 0.5 - width / 2) * (tall / height)
    y = (height / 2 - np.arange(height) - 0.5) * (tall / height)
    return np.stack(np.meshgrid(x, y), axis=-1)

"""The cameras of a path."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from oitbench.scene import Camera, Scene, Vector
from oitbench.scene.vectors import Floats


def cameras_of(scene: Scene, frames: int, turns: float) -> tuple[Camera, ...]:
    """Return the cameras of a path: an orbit about the target of the scene's camera.

    Parameters
    ----------
    scene : Scene
    frames : int
    turns : float
        Length of the orbit in full turns.
    """
    return orbit(scene.camera, frames, turns)


def orbit(camera: Camera, frames: int, turns: float = 1.0) -> tuple[Camera, ...]:
    """Return cameras on a circle about the target and the camera's upward direction."""
    axis = np.asarray(camera.up, dtype=np.float64) / np.linalg.norm(camera.up)
    offset = np.subtract(camera.position, camera.target)
    placed = []
    for frame in range(frames):
        angle = 2 * math.pi * turns * frame / frames
        across = np.cross(axis, offset)
        along = axis * (axis @ offset)
        moved = along + (offset - along) * math.cos(angle) + across * math.sin(angle)
        placed.append(replace(camera, position=_vector(np.asarray(camera.target) + moved)))
    return tuple(placed)


def middle(one: Camera, other: Camera) -> Camera:
    """Return the camera half-way between two."""
    return replace(
        one,
        position=_vector(np.add(one.position, other.position) / 2),
        target=_vector(np.add(one.target, other.target) / 2),
        up=_vector(np.add(one.up, other.up) / 2),
        fov_y=(one.fov_y + other.fov_y) / 2,
    )


def _vector(values: Floats) -> Vector:
    x, y, z = values.tolist()
    return x, y, z

"""The cameras of a path."""

from __future__ import annotations

import numpy as np

from oitbench.scene import Camera, Scene
from oitbench.scene.paths import between, orbit

FRAMES, TURNS = 32, 0.125
"""Frames of a path, and full turns of an orbit, by default."""
_STEPS = 64
"""Places between two cameras of a scene's own path."""


def cameras_of(
    scene: Scene, frames: int | None = None, turns: float | None = None
) -> tuple[Camera, ...]:
    """Return the cameras of a path: the scene's own one, or an orbit about the target.

    Parameters
    ----------
    scene : Scene
    frames : int, optional
        Evenly spaced along the path. Default: those of the scene's own path, or `FRAMES`.
    turns : float, optional
        Length of an orbit in full turns, even if the scene has a path. Default: `TURNS`, for a
        scene that has none.
    """
    if turns is not None or len(scene.path) < 2:
        return orbit(scene.camera, frames or FRAMES, TURNS if turns is None else turns)
    if frames is None:
        return scene.path
    places = np.rint(np.linspace(0, _STEPS * (len(scene.path) - 1), frames)).astype(int)
    return tuple(_at(scene.path, *divmod(place, _STEPS)) for place in places.tolist())


def _at(path: tuple[Camera, ...], number: int, step: int) -> Camera:
    """Return the camera some steps after one of a path."""
    return between(path[number], path[number + 1], _STEPS + 1)[step] if step else path[number]


def middle(one: Camera, other: Camera) -> Camera:
    """Return the camera half-way between two."""
    return between(one, other, 3)[1]

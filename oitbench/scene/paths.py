"""Cameras that belong together: a stereo pair, and the frames of a moving camera."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from oitbench.scene.camera import Camera
from oitbench.scene.checks import require
from oitbench.scene.vectors import as_vector, unit

EYE_DISTANCE = 1 / 30
"""Distance of the eyes of a stereo pair, relative to the distance of the target."""


def stereo(camera: Camera, eye_distance: float | None = None) -> tuple[Camera, Camera]:
    """Return the cameras of the left and the right eye, on both sides of `camera`.

    Both look in the direction of `camera`: a point has one distance along the view axis and one
    height in both pictures. Eyes that turn in to the target would have neither. The pictures
    coincide at infinity. For a pair that coincides at the target, as with frusta that are off axis,
    shift the finished pictures horizontally.

    Parameters
    ----------
    camera : Camera
    eye_distance : float, optional
        In the scene's unit. Default: 1/30 of the distance of the target.

    Raises
    ------
    SceneError
        If the camera is orthographic, or the distance is not above 0: the pictures would be alike.
    """
    require(not camera.orthographic, "stereo: an orthographic camera has no parallax")
    if eye_distance is None:
        eye_distance = EYE_DISTANCE * math.dist(camera.position, camera.target)
    require(0 < eye_distance < math.inf, "stereo: eye_distance must be a length above 0")
    aside = eye_distance / 2 * camera.axes[0]
    left, right = (
        replace(
            camera,
            position=as_vector(np.asarray(camera.position) + sign * aside),
            target=as_vector(np.asarray(camera.target) + sign * aside),
        )
        for sign in (-1, 1)
    )
    return left, right


def orbit(camera: Camera, frames: int, turns: float = 1.0) -> tuple[Camera, ...]:
    """Return the frames of a camera that moves on a circle about its target, around `up`.

    The first frame is `camera`. The frame after the last one ends the path, so that whole turns can
    be shown in an endless loop.

    Parameters
    ----------
    camera : Camera
    frames : int
    turns : float
        Counterclockwise seen from above, and clockwise if negative.

    Raises
    ------
    SceneError
        If there is no frame.
    """
    require(frames >= 1, "orbit: give at least one frame")
    axis = unit(np.asarray(camera.up, dtype=np.float64))
    arm = np.subtract(camera.position, camera.target, dtype=np.float64)
    along = (arm @ axis) * axis
    found = []
    for angle in 2 * math.pi * turns * np.arange(frames) / frames:
        # Rodrigues' rotation of the part of the arm that is perpendicular to the axis.
        turned = math.cos(angle) * (arm - along) + math.sin(angle) * np.cross(axis, arm)
        position = as_vector(np.asarray(camera.target) + along + turned)
        found.append(replace(camera, position=position) if angle else camera)
    return tuple(found)


def between(first: Camera, last: Camera, frames: int) -> tuple[Camera, ...]:
    """Return the frames of a camera that moves on straight lines from `first` to `last`.

    Parameters
    ----------
    first, last : Camera
        Both frames are part of the path.
    frames : int
        Two or more.

    Raises
    ------
    SceneError
        If there are fewer than two frames, or only one of the cameras is orthographic.
    """
    require(frames >= 2, "between: give at least two frames")
    same = first.orthographic == last.orthographic
    require(same, "between: one camera is orthographic and the other is not; give two of a kind")
    parts = np.linspace(0, 1, frames)[1:-1]
    return (first, *(_mixed(first, last, float(part)) for part in parts), last)


def _mixed(first: Camera, last: Camera, part: float) -> Camera:
    def mix(one: float, other: float) -> float:
        return one if one == other else (1 - part) * one + part * other

    def moved(name: str) -> tuple[float, float, float]:
        one, other = getattr(first, name), getattr(last, name)
        return (mix(one[0], other[0]), mix(one[1], other[1]), mix(one[2], other[2]))

    height = None
    if first.height is not None and last.height is not None:
        height = mix(first.height, last.height)
    return Camera(
        moved("position"),
        moved("target"),
        moved("up"),
        mix(first.fov_y, last.fov_y),
        mix(first.near, last.near),
        mix(first.far, last.far),
        height,
    )

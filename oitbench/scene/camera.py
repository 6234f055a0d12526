"""The camera, and its view of points in the world."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from oitbench.scene.checks import require, require_finite
from oitbench.scene.vectors import Floats, Vector, axes_along


@dataclass(frozen=True)
class Camera:
    """A pinhole camera.

    Parameters
    ----------
    position, target : Vector
        Meters in world space.
    up : Vector
        Direction that points up in the image, not parallel to the view direction.
    fov_y : float
        Full vertical opening angle, radians.
    near, far : float
        Clip distances in meters. With the default, an infinite far plane, window depth is
        d = 1 − near/z.

    Raises
    ------
    SceneError
        If a value is not finite, `target` equals `position`, `up` is parallel to the view
        direction, or an angle or distance is out of range.
    """

    position: Vector
    target: Vector = (0.0, 0.0, 0.0)
    up: Vector = (0.0, 1.0, 0.0)
    fov_y: float = math.radians(45)
    near: float = 0.1
    far: float = math.inf

    def __post_init__(self) -> None:
        require_finite("camera", position=self.position, target=self.target, up=self.up)
        require(0 < self.fov_y < math.pi, "camera: fov_y must lie between 0 and π radians")
        require(0 < self.near < self.far, "camera: near must be above 0 and below far")
        require(self.position != self.target, "camera: position and target coincide; move one")
        across = np.cross(np.asarray(self.up), np.subtract(self.position, self.target))
        require(bool(across.any()), "camera: up is parallel to the view direction; turn it")

    @property
    def axes(self) -> Floats:
        """Unit vectors right, up and back (away from the target) as rows, shape (3, 3)."""
        return axes_along(np.subtract(self.position, self.target), self.up)

    def view_distance(self, points: npt.ArrayLike) -> Floats:
        """Return the distance of `points`, shape (..., 3), along the view axis, in meters."""
        offset = np.asarray(points, dtype=np.float64) - np.asarray(self.position)
        return np.asarray(-(offset @ self.axes[2]))

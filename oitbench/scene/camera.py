"""Cameras, and their views of points in the world."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import numpy.typing as npt

from oitbench.scene.checks import require, require_finite
from oitbench.scene.vectors import Floats, Vector, axes_along, relocated, unit

_PARALLEL = 1e-9
"""Sine of the angle to the view direction below which `up` gives no direction in the image."""
_NEAR_Z = 0.9
"""Cosine of the angle to the z axis above which y takes the place of −z."""


@dataclass(frozen=True)
class Camera:
    """A pinhole camera, or an orthographic one. Lengths are in the scene's unit.

    Parameters
    ----------
    position, target : Vector
        In world space.
    up : Vector
        Direction that points up in the image. If the camera looks along it, straight down or
        straight up, it is as if the camera had turned there from looking along −z (along y, if `up`
        lies near z): straight down, −z points up in the image.
    fov_y : float
        Full vertical opening angle, radians; unused if there is a `height`.
    near, far : float
        Clip distances. With the default, an infinite far plane, window depth is d = 1 − near/z. It
        is d = (z − near)/(far − near) if the camera is orthographic; an infinite far plane then
        counts as one just behind the scene.
    height : float, optional
        Full height of the picture of an orthographic camera, whose rays are parallel. Default: the
        camera is a pinhole.

    Raises
    ------
    SceneError
        If a value is not finite, `target` equals `position`, `up` has no length, or an angle, a
        distance or the height is out of range.
    """

    position: Vector
    target: Vector = (0.0, 0.0, 0.0)
    up: Vector = (0.0, 1.0, 0.0)
    fov_y: float = math.radians(45)
    near: float = 0.1
    far: float = math.inf
    height: float | None = None

    def __post_init__(self) -> None:
        require_finite("camera", position=self.position, target=self.target, up=self.up)
        require(0 < self.fov_y < math.pi, "camera: fov_y must lie between 0 and π radians")
        require(0 < self.near < self.far, "camera: near must be above 0 and below far")
        if self.height is not None:
            require(0 < self.height < math.inf, "camera: height must be a length above 0")
        require(any(self._back), "camera: position and target coincide; move one")
        require(any(self.up), "camera: up has no length; give a nonzero vector")

    @property
    def _back(self) -> Floats:
        return np.subtract(self.position, self.target, dtype=np.float64)

    @cached_property
    def axes(self) -> Floats:
        """Unit vectors right, up and back (away from the target) as rows, shape (3, 3)."""
        back, up = unit(self._back), unit(np.asarray(self.up, dtype=np.float64))
        if np.linalg.norm(np.cross(up, back)) < _PARALLEL:
            ahead = np.array([0.0, 1.0, 0.0] if abs(up[2]) > _NEAR_Z else [0.0, 0.0, -1.0])
            up = ahead * np.sign(up @ back)
        return axes_along(back, up)

    def relocated(self, origin: Vector, scale: float) -> Camera:
        """Return the camera relative to `origin`, in units that are `scale` times smaller."""
        return replace(
            self,
            position=relocated(self.position, origin, scale),
            target=relocated(self.target, origin, scale),
            near=self.near * scale,
            far=self.far * scale,
            height=None if self.height is None else self.height * scale,
        )

    @property
    def orthographic(self) -> bool:
        """Whether all rays are parallel to the view axis."""
        return self.height is not None

    @property
    def span(self) -> float:
        """Full height of the picture at a distance of one; at any distance, if orthographic."""
        return 2 * math.tan(self.fov_y / 2) if self.height is None else self.height

    def pixel_size(self, points: npt.ArrayLike, pixel_height: int) -> Floats:
        """Return the side of a pixel at `points`, shape (...), in a picture of `pixel_height`.

        Parameters
        ----------
        points : array, shape (..., 3)
            In front of the camera.
        pixel_height : int
            Height of the picture in pixels.
        """
        distance = self.view_distance(points)
        shown = np.ones_like(distance) if self.orthographic else np.maximum(distance, self.near)
        return np.asarray(shown * (self.span / pixel_height))

    def view_distance(self, points: npt.ArrayLike) -> Floats:
        """Return the distance of `points`, shape (..., 3), along the view axis."""
        offset = np.asarray(points, dtype=np.float64) - np.asarray(self.position)
        return np.asarray(-(offset @ self.axes[2]))

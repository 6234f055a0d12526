"""The camera as rays through a grid of sub-pixels, by default through the points of OpenGL."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from oitbench.scene import Camera


@dataclass(frozen=True)
class View:
    """A camera with its grid of sub-pixels.

    Parameters
    ----------
    camera : Camera
    width, height : int
        Number of sub-pixels along each side: the size of the image times `ssaa`.
    """

    camera: Camera
    width: int
    height: int

    @property
    def step(self) -> tuple[float, float]:
        """Distance between sub-pixels to the right and up, on the plane one meter in front.

        On any plane, if the camera is orthographic.
        """
        tall = self.camera.span
        return tall * (self.width / self.height) / self.width, tall / self.height

    def rays(
        self, first: int, last: int, seed: Sequence[int] = ()
    ) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]:
        """Return the rays of the sub-pixels `first` … `last` − 1, row by row from the top.

        Parameters
        ----------
        first, last : int
        seed : sequence of int
            If it is not empty, each ray passes through its sub-pixel at a random place.

        Returns
        -------
        origins : array, shape (n, 3)
            On the near plane, in meters.
        directions : array, shape (n, 3)
            Unit vectors.
        """
        index = np.arange(first, last)
        right, up, back = self.camera.axes
        step_x, step_y = self.step
        across, down = 0.5, 0.5
        if seed:
            across, down = np.random.default_rng(seed).random((2, last - first))
        x = (index % self.width + across - self.width / 2) * step_x
        y = (self.height / 2 - index // self.width - down) * step_y
        aside = x[:, None] * right + y[:, None] * up
        if self.camera.orthographic:
            starts = np.asarray(self.camera.position) + aside - self.camera.near * back
            return starts, np.broadcast_to(-back, starts.shape)
        forward = aside - back
        origins = np.asarray(self.camera.position) + self.camera.near * forward
        return origins, forward / np.linalg.norm(forward, axis=1, keepdims=True)

    def before_far_plane(self, mitsuba: Any, drjit: Any, p: Any) -> Any:
        """Return whether the point `p`, Point3f in meters, is not beyond the far plane; Bool."""
        if math.isinf(self.camera.far):
            return mitsuba.Bool(True)
        back = mitsuba.Vector3f(*map(float, self.camera.axes[2]))
        offset = p - mitsuba.Point3f(*map(float, self.camera.position))
        return -drjit.dot(offset, back) <= self.camera.far

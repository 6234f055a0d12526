"""Views of a scene on the device, and the error of a method in them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from oitbench.effects import Effect
from oitbench.errors import UsageError
from oitbench.gl.device import Device
from oitbench.gl.frame import Frame
from oitbench.gl.ownership import Owner
from oitbench.gl.uploaded_scene import UploadedScene
from oitbench.image import files
from oitbench.image.files import Image
from oitbench.method.declaration import Method
from oitbench.scene import Scene
from oitbench.scene.paths import orbit

WORST = 1.0
"""The error of a picture with pixels that are not finite: that of white for black."""


def seen_from(scene: Scene, views: int, degrees: float) -> tuple[Scene, ...]:
    """Return a scene from its own camera and from cameras on a circle about its target.

    Parameters
    ----------
    scene : Scene
    views : int
    degrees : float
        Angle between neighbors.

    Raises
    ------
    UsageError
        The scene has no camera to move: it consists of lists of fragments.
    """
    if scene.lists is not None:
        raise UsageError(f"{scene.name} has no views to hold out; name a scene of meshes")
    cameras = orbit(scene.camera, views, views * degrees / 360)
    return tuple(replace(scene, camera=camera) for camera in cameras)


class Views(Owner):
    """Views of one scene, each with its exact picture; a context manager.

    Every other view is for training, from the first one on. The others are held out.

    Parameters
    ----------
    device : Device
    scenes : sequence of Scene
        The same scene from several cameras.
    exact : Method
        Renders the truth.
    size : (int, int)
        Width and height in pixels.
    """

    def __init__(
        self, device: Device, scenes: Sequence[Scene], exact: Method, size: tuple[int, int]
    ) -> None:
        super().__init__()
        self._size = size
        with self.building():
            self._uploaded = [
                self.own(UploadedScene(device, scene, rows=size[1])) for scene in scenes
            ]
            self._truths = [self._draw(uploaded, exact) for uploaded in self._uploaded]

    def training(self, method: Method) -> float:
        """Return the mean squared error over the views for training."""
        return self._error(method, 0)

    def held_out(self, method: Method) -> float:
        """Return the mean squared error over the other views."""
        return self._error(method, 1)

    def _error(self, method: Method, first: int) -> float:
        """Return the mean over every other view; pictures are compared as they are displayed."""
        pairs = zip(self._uploaded[first::2], self._truths[first::2], strict=True)
        errors = [
            float(np.mean((self._draw(uploaded, method) - truth) ** 2, dtype=np.float64))
            for uploaded, truth in pairs
        ]
        mean = float(np.mean(errors))
        return mean if np.isfinite(mean) else WORST

    def _draw(self, uploaded: UploadedScene, method: Method) -> Image:
        running: Effect = uploaded.scene.effects & method.shows
        with Frame(uploaded, method, self._size, running) as frame:
            frame.render()
            return files.to_srgb(frame.image(), uploaded.scene.exposure)

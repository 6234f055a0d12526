"""A scene on the device, with everything that its frames share."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from oitbench.effects import SHADING, Effect
from oitbench.gl.device import Device
from oitbench.gl.geometry import Geometry
from oitbench.gl.ownership import Owner
from oitbench.gl.shading.lighting import Lighting
from oitbench.gl.shading.occlusion import occludes
from oitbench.gl.shading.opaque import count_fragments
from oitbench.scene import Scene
from oitbench.shading import DEFAULT, ShadingSettings


class UploadedScene(Owner):
    """Geometry, lightings and fragment counts of a scene. Frames must be released before it.

    Parameters
    ----------
    device : Device
    scene : Scene
    settings : ShadingSettings
        Settings of shared shading.
    rows : int
        Height of the frames in pixels, sub-pixels included, for strands (see `Scene.resolved`).
        Default: 0, unknown.

    Attributes
    ----------
    scene : Scene
        As it is given.
    geometry : Geometry
        Of the scene as its camera sees it.

    Raises
    ------
    SceneError, CapabilityError
        The scene cannot be uploaded; see `Geometry`.
    """

    def __init__(
        self, device: Device, scene: Scene, settings: ShadingSettings = DEFAULT, rows: int = 0
    ) -> None:
        super().__init__()
        self.device, self.scene = device, scene
        self.settings = settings
        self._lightings: dict[Effect, Lighting] = {}
        self._counts: dict[tuple[tuple[int, int], bool], npt.NDArray[np.int64]] = {}
        with self.building(), device.checked(f"scene {scene.name}"):
            self.geometry = self.own(Geometry(device, scene.resolved(rows)))

    def lighting(self, effects: Effect) -> Lighting | None:
        """Return the lighting that all frames under the same effects of shading share.

        None for a scene that is lit by emission alone, unless its medium is requested: a medium
        comes with the lights that it scatters, even if there are none.
        """
        if not self.scene.lights and Effect.VOLUME not in effects:
            return None
        shading = effects & SHADING
        if shading not in self._lightings:
            with self.device.checked(f"scene {self.scene.name}"):
                lighting = Lighting(self.device, self.geometry, shading, self.settings)
                self._lightings[shading] = self.own(lighting)
        return self._lightings[shading]

    def fragment_counts(
        self, size: tuple[int, int], effects: Effect = Effect.NONE
    ) -> npt.NDArray[np.int64]:
        """Return the visible transparent fragments per pixel, shape (h, w), bottom row first.

        Parameters
        ----------
        size : (int, int)
            Width and height in pixels.
        effects : Effect
            Running effects: ambient occlusion makes some fragments opaque.
        """
        key = (size, occludes(self.scene, effects))
        if key not in self._counts:
            self._counts[key] = count_fragments(self.device, self.geometry, size, effects)
        return self._counts[key]

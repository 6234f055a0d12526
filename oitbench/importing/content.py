"""What a file holds, before a camera, lights and a ground are added where it has none."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field

import numpy as np

from oitbench.errors import SceneError, printable
from oitbench.scene import Camera, DirectionalLight, Floats, Object, SpotLight, Vector
from oitbench.scene.vectors import RGB

_LONGEST = 60


@dataclass(frozen=True)
class PointLight:
    """A light that shines to all sides: intensity as in `SpotLight`."""

    position: Vector
    intensity: RGB


@dataclass
class Content:
    """Objects, cameras and lights of a file.

    Parameters
    ----------
    objects : list of Object
    cameras : dict of str to Camera
        Their targets are any points on their axes.
    lights : list of DirectionalLight or SpotLight
    points : list of PointLight
    """

    objects: list[Object] = field(default_factory=list)
    cameras: dict[str, Camera] = field(default_factory=dict)
    lights: list[DirectionalLight | SpotLight] = field(default_factory=list)
    points: list[PointLight] = field(default_factory=list)

    @property
    def bounds(self) -> tuple[Floats, Floats]:
        """The lowest and the highest coordinates of all objects."""
        if not self.objects:
            raise SceneError("it has no triangle that can be seen; export meshes")
        used = [item.mesh.used_positions for item in self.objects]
        low = np.min([points.min(axis=0) for points in used], axis=0)
        return low, np.max([points.max(axis=0) for points in used], axis=0)


class Names:
    """Names that are given once: texts of a file in printable signs, with numbers."""

    def __init__(self, taken: Iterable[str] = ()) -> None:
        self._counts = dict.fromkeys(taken, 1)

    def free(self, name: str) -> str:
        """Return a name that is not taken, and take it."""
        plain = printable(name[:_LONGEST]).strip() or "unnamed"
        found = plain
        while found in self._counts:
            # The count only rises, so that many equal names take no long search.
            self._counts[plain] = self._counts.get(plain, 1) + 1
            found = f"{plain} {self._counts[plain]}"
        self._counts[found] = 1
        return found

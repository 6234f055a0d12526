"""Small scenes that the tests of the matched reference share."""

from __future__ import annotations

from oitbench.effects import Effect
from oitbench.modeling.mesh import quad
from oitbench.path_traced.matched.render import matched
from oitbench.scene import RGB, Camera, DirectionalLight, Floats, Material, Object, Scene

SIZE = (6, 5)
ABOVE = Camera((0.3, 4.0, 3.0))
SUN = DirectionalLight((0.3, -1.0, -0.2), (2.0, 3.0, 4.0))
PAPER: RGB = (0.8, 0.5, 0.2)


def floor(material: Material, half: float = 50.0, height: float = 0.0) -> Object:
    """Return a horizontal square that is named by its height."""
    return Object(f"floor {height}", quad((0, height, 0), (half, 0, 0), (0, 0, -half)), material)


def image(scene: Scene, effects: Effect | None = None) -> Floats:
    """Return the pixels of a matched picture, shape (n, 3)."""
    found = matched(scene, SIZE, 1, effects)
    return found.reshape(-1, 3).astype(float)

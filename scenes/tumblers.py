"""Drinking glasses on a checkered cloth, with colored shadows and caustics.

Subject of figure 1 (center) of McGuire & Mara 2017, "Phenomenological Transparency".

Parameters
----------
detail : float
    Factor on the number of triangles.
near : float
    Distance of the near plane from the camera, m. The cloth begins at 0.4 m in the picture, and the
    glasses stand at 0.45 to 0.6 m.

Each glass is one closed solid, and a drink in it is another with a thin gap of air between them, so
that a ray crosses up to six refracting surfaces. A spot light behind the glasses casts their
colored shadows towards the viewer. Lengths are in decimeters and as in life: the tumbler is 9.5 cm
tall.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from oitbench.modeling.detail import DETAIL
from oitbench.modeling.patterns import checkers
from oitbench.modeling.placement import merge, rotation, transform, translation
from oitbench.modeling.props.glassware import Vessel, ice_cube, tumbler, wine_glass
from oitbench.modeling.surroundings import Window, room
from oitbench.scene import (
    RGB,
    Camera,
    EnvironmentLight,
    Material,
    Mesh,
    Object,
    Scene,
    SpotLight,
)

FOOT_GAP = 0.005
"""Decimeters between cloth and glasses: coincident surfaces have no right picture."""
DRINK_GAP = 0.005
"""Air between a drink and its glass, decimeters."""
SQUARE, COLUMNS, ROWS = 0.5, 28, 24
"""Edge length in decimeters and numbers of the squares of the cloth."""

# Transmissions are those of one surface; light crosses at least two of them.
CLEAR: RGB = (0.97, 0.97, 0.97)
GLASS = Material(transmission=CLEAR, index=1.5, roughness=0.0, solid=True)
ICE = Material(transmission=(0.98, 0.98, 0.98), index=1.31, roughness=0.0, solid=True)
DRINKS: dict[str, RGB] = {
    "pomegranate": (0.95, 0.22, 0.20),
    "lime": (0.52, 0.90, 0.22),
    "amber": (0.99, 0.73, 0.10),
}
PALE_CLOTH = Material(albedo=(0.74, 0.72, 0.68), specular=0.0)
BLUE_CLOTH = Material(albedo=(0.22, 0.32, 0.46), specular=0.0)

subject = "glass"
quick = False
near = 0.36
crops = {"green_glass": (0.4, 0.54, 0.24, 0.24), "red_glass": (0.08, 0.4, 0.24, 0.28)}
parameters = {
    "detail": DETAIL,
}


@dataclass(frozen=True)
class Serving:
    """A glass, (x, z) of its foot, and a drink ("" for none) up to a level; decimeters."""

    name: str
    vessel: Vessel
    place: tuple[float, float]
    drink: str = ""
    level: float = 0.0


SERVINGS = (
    Serving("tumbler", tumbler(0.30, 0.37, 0.95, 0.03, 0.09), (-1.0, 0.1), "pomegranate", 0.66),
    Serving("wine glass", wine_glass(0.43, 1.75, 0.022), (-0.05, -0.85), "amber", 1.13),
    Serving("shot glass", tumbler(0.21, 0.28, 0.62, 0.03, 0.09), (0.1, 0.75), "lime", 0.42),
    Serving("rocks glass", tumbler(0.37, 0.44, 0.80, 0.03, 0.08), (0.95, -0.1)),
)
# Center of each ice cube relative to the foot of the rocks glass, edge length, and turn about y.
CUBES = (
    ((-0.155, 0.225, 0.02), 0.26, 0.08),
    ((0.150, 0.225, -0.02), 0.25, 1.5),
    ((0.01, 0.50, 0.01), 0.27, 0.72),
    ((-0.15, 0.145, 1.0), 0.27, 0.35),
)


def build(*, name: str, detail: float) -> Scene:
    """Return the cloth, glasses, drinks and ice. The cloth casts no shadow, all others do."""
    objects = _cloth()
    for serving in SERVINGS:
        foot = translation((serving.place[0], FOOT_GAP, serving.place[1]))
        glass = transform(serving.vessel.glass(detail), foot)
        objects.append(Object(serving.name, glass, GLASS))
        if serving.drink:
            drink = transform(serving.vessel.filling(serving.level, DRINK_GAP, detail), foot)
            objects.append(Object(serving.drink, drink, _liquid(DRINKS[serving.drink])))
    objects.append(Object("ice", _ice(detail), ICE))
    return Scene(
        name=name,
        camera=Camera(position=(0.3, 2.35, 5.4), target=(0, 0.5, 0), fov_y=math.radians(32)),
        views={
            "above": Camera(position=(0, 7.5, 0), target=(0, 0, 0), fov_y=math.radians(30)),
            "low": Camera(position=(-3.4, 0.9, 3.9), target=(0, 0.55, 0), fov_y=math.radians(30)),
        },
        objects=tuple(objects),
        lights=(
            SpotLight(
                position=(-1.6, 6.0, -4.5),
                target=(0, 0, 0.3),
                intensity=(1.18, 1.14, 1.06),
                angle=math.radians(50),
            ),
            _room(),
        ),
        meters_per_unit=0.1,
        full_samples=64,
    )


def _liquid(transmission: RGB) -> Material:
    """Return the material of a drink."""
    return Material(transmission=transmission, index=1.33, roughness=0.0, solid=True)


def _ice(detail: float) -> Mesh:
    """Return all ice cubes: three in the rocks glass and one on the cloth."""
    x, z = SERVINGS[-1].place
    cubes = []
    for middle, edge, turn in CUBES:
        cube = ice_cube((edge, edge, edge), 0.16 * edge, detail)
        place = translation((x + middle[0], FOOT_GAP + middle[1], z + middle[2]))
        cubes.append(transform(cube, place @ rotation((0, 1, 0), turn)))
    return merge(cubes)


def _cloth() -> list[Object]:
    """Return the pale and the blue squares."""
    across, along = (COLUMNS * SQUARE / 2, 0.0, 0.0), (0.0, 0.0, -ROWS * SQUARE / 2)
    pale, blue = checkers((0, 0, 0), across, along, COLUMNS, ROWS)
    return [
        Object("pale squares", pale, PALE_CLOTH, casts=False),
        Object("blue squares", blue, BLUE_CLOTH, casts=False),
    ]


def _room() -> EnvironmentLight:
    """Return a dim room with a window ahead on the left and one behind the viewer."""
    windows = (
        Window(azimuth=-0.6, elevation=0.35, width=0.7, height=0.6, radiance=(3.0, 3.2, 3.5)),
        Window(azimuth=2.5, elevation=0.4, width=0.9, height=0.6, radiance=(2.2, 2.1, 1.9)),
    )
    return room((0.42, 0.44, 0.47), (0.62, 0.55, 0.46), (0.10, 0.09, 0.08), windows)

"""A ball of smoke above a plain, and an opaque cube in it, above it or beside it.

Stands for figure 16 (`cube=inside`) and figure 17 (`cube=away` and `cube=above`) of McGuire &
Mara 2017, "Phenomenological Transparency".

Parameters
----------
detail : float
    Factor on the number of particles. The optical thickness stays the same.
alpha : float
    Coverage at the middle of a particle at detail 1, in [0, 1].
seed : int
    Seed of the particles.
cube : str
    "inside" for a cube that is partly inside the smoke, "above" for one between the smoke and the
    sun, whose shadow falls through the smoke, "away" for one beside the smoke, seen as "above".
self_shadow : bool
    Whether the smoke receives shadows, of itself and of the cube. Figure 16 shows it with and
    without them.
near : float
    Distance of the near plane from the camera, m. The ground begins at 4.5 m in the picture, as
    does the smoke.

The smoke is made of 1,000 particles, one object in random order of submission, so that sorting
objects does not help and no order is right by chance. Coverage is low and soft, and the number of
layers is high. The smoke scatters sunlight equally to all sides, and is dark where the sun reaches
it through much smoke.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from oitbench.modeling.detail import PARTICLE_DETAIL, copies
from oitbench.modeling.mesh import box, quad
from oitbench.modeling.particles import smoke, sprites
from oitbench.modeling.placement import random_directions
from oitbench.modeling.surroundings import gradient_sky
from oitbench.parameters import Parameter
from oitbench.scene import (
    RGB,
    Camera,
    DirectionalLight,
    Material,
    Object,
    Scene,
    Sprites,
    Vector,
    opposite,
)


@dataclass(frozen=True)
class View:
    """Center and size of the cube in meters, and a camera that sees its shadow."""

    center: Vector
    size: Vector
    camera: Camera


ABOVE = Camera((1.6, 3.9, 5.6), (0.0, 1.2, 0.0), fov_y=math.radians(34))
VIEWS = {
    "inside": View(
        # The foot of the cube is in the ground, so that no two surfaces coincide.
        center=(0.775, 0.565, -0.225),
        size=(1.15, 1.17, 1.15),
        camera=Camera((-1.9, 2.55, 4.9), (0.22, 0.82, 0.0), fov_y=math.radians(31)),
    ),
    "above": View(center=(-0.92, 2.62, 0.55), size=(0.62, 0.62, 0.62), camera=ABOVE),
    "away": View(center=(1.15, 2.4, -0.1), size=(0.62, 0.62, 0.62), camera=ABOVE),
}
subject = "smoke"
quick = False
near = 4.0
crops = {
    "before_the_box": (0.5, 0.3, 0.3, 0.3),
    "sunny_smoke": (0.2, 0.2, 0.14, 0.14),
    "dark_smoke": (0.36, 0.54, 0.14, 0.14),
    "shadow_of_the_cube": (0.33, 0.3, 0.2, 0.2),
}
parameters = {
    "detail": PARTICLE_DETAIL,
    "alpha": Parameter(
        0.2, low=0.0, high=1.0, help="coverage at the middle of a particle at detail 1"
    ),
    "seed": Parameter(1, low=0, help="seed of the particles"),
    "cube": Parameter(
        "inside",
        choices=tuple(VIEWS),
        help="partly inside the smoke, between the smoke and the sun, or beside the smoke",
    ),
    "self_shadow": Parameter(True, help="whether the smoke receives shadows"),
}

PARTICLES = 1000
BALL: Vector = (0.0, 1.08, 0.0)
RADIUS = 0.92
PARTICLE_RADII = (0.11, 0.25)
SUNWARD: Vector = (-0.75, 1.0, 0.45)
SUN: RGB = (7.6, 6.9, 5.9)  # irradiance
# The ground hides the lower half.
SKY = ((-2.0, (0.0, 0.0, 0.0)), (0.0, (0.22, 0.25, 0.29)), (90.0, (0.14, 0.20, 0.30)))
GROUND: RGB = (0.15, 0.16, 0.18)
PAINT: RGB = (0.62, 0.20, 0.07)


def build(
    *, name: str, detail: float, alpha: float, seed: int, cube: str, self_shadow: bool
) -> Scene:
    """Return the ground, the cube and the smoke."""
    view = VIEWS[cube]
    count = copies(PARTICLES, detail)
    vapor = smoke(alpha, 0.9, PARTICLES, count)
    particles = _particles(np.random.default_rng(seed), count)
    plain = quad((0, 0, 0), (80, 0, 0), (0, 0, -80))
    objects = (
        Object("ground", plain, Material(albedo=GROUND, specular=0.0), casts=False),
        Object("cube", box(view.center, view.size), Material(albedo=PAINT, specular=0.0)),
        Object("smoke", particles, vapor, particles=True, receives_shadows=self_shadow),
    )
    sun = DirectionalLight(opposite(SUNWARD), SUN)
    return Scene(name, view.camera, objects, lights=(sun, gradient_sky(SKY)), full_samples=12)


def _particles(random: np.random.Generator, count: int) -> Sprites:
    """Return the particles, in random order."""
    directions = random_directions(random, count)
    # Slow waves over the ball make its outline billow.
    billow = 1 + 0.07 * np.sin(directions @ np.array([3.1, 5.3, 4.2]) + 1.0)
    billow += 0.05 * np.sin(directions @ np.array([-7.0, 4.4, 6.1]))
    reach = RADIUS * billow * random.random(count) ** 0.4
    centers = np.asarray(BALL) + reach[:, None] * directions
    return sprites(random, centers, random.uniform(*PARTICLE_RADII, count), SUNWARD)

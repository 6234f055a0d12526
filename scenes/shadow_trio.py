"""A cloud of particles and a tinted glass ball above a tiled floor, with three kinds of shadow.

Stands for figure 9 of McGuire & Mara 2017, "Phenomenological Transparency".

Parameters
----------
detail : float
    Factor on the number of particles and triangles. The optical thickness stays the same.
alpha : float
    Coverage at the middle of a particle at detail 1, in [0, 1].
seed : int
    Seed of the particles.
near : float
    Distance of the near plane from the camera, m. The floor begins at 4.8 m in the picture, and
    cloud and ball hang at 5.3 m.

The option `--effects` chooses the kind of shadow. Under
`-translucent_shadows,-colored_shadows,-caustics`, a surface that blocks at least half of the light
blocks all of it: cloud and ball cast black shadows. Under `-caustics`, the shadow of the cloud
depends on its thickness, and that of the ball is a disc of colored light. Under all requested
effects, the ball focuses light in the middle of its shadow. The cloud shadows itself, so that its
lower part is darker. The tiles show how the ball bends the view.
"""

from __future__ import annotations

import math

import numpy as np

from oitbench.modeling.detail import PARTICLE_DETAIL, copies, divisions
from oitbench.modeling.mesh import sphere
from oitbench.modeling.particles import fill, smoke, sprites
from oitbench.modeling.patterns import checkers
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

subject = "smoke and glass"
quick = False
near = 4.3
crops = {
    "glass_ball": (0.56, 0.22, 0.38, 0.34),
    "smoke": (0.02, 0.19, 0.44, 0.32),
    "top_of_smoke": (0.17, 0.25, 0.18, 0.06),
    "foot_of_smoke": (0.17, 0.39, 0.18, 0.06),
    "shadow_of_smoke": (0.1, 0.56, 0.42, 0.24),
    "shadow_of_ball": (0.62, 0.55, 0.36, 0.26),
    "middle_of_shadow": (0.77, 0.64, 0.08, 0.06),
    "rim_of_shadow": (0.68, 0.63, 0.04, 0.06),
}
parameters = {
    "detail": PARTICLE_DETAIL,
    "alpha": Parameter(
        0.7, low=0.0, high=1.0, help="coverage at the middle of a particle at detail 1"
    ),
    "seed": Parameter(1, low=0, help="seed of the particles"),
}

PARTICLES = 110
# Centers of the cloud's lobes, meters.
LOBES: tuple[Vector, ...] = (
    (-1.30, 1.15, 0.02), (-0.95, 1.28, -0.06), (-0.62, 1.17, 0.04), (-0.92, 1.08, 0.08),
)  # fmt: skip
LOBE_RADII = (0.34, 0.42, 0.34, 0.40)
PARTICLE_RADII = (0.14, 0.24)
BALL: Vector = (0.95, 1.02, 0.0)
RADIUS = 0.52
GLASS: RGB = (0.34, 0.48, 0.60)  # transmission of one wall of the ball
SUNWARD: Vector = (-0.22, 1.0, -0.32)
SUN: RGB = (3.4, 3.3, 3.1)  # irradiance
# The floor hides the lower half.
SURROUNDINGS = ((-2.0, (0.0, 0.0, 0.0)), (0.0, (0.16, 0.17, 0.18)), (90.0, (0.10, 0.13, 0.18)))
TILE, COLUMNS, ROWS, FRONT = 0.6, 40, 32, 4.2
"""Edge length of a tile, their numbers, and z of the nearest edge, meters."""
PALE_TILE = Material(albedo=(0.62, 0.61, 0.58), specular=0.0)
DARK_TILE = Material(albedo=(0.48, 0.49, 0.50), specular=0.0)


def build(*, name: str, detail: float, alpha: float, seed: int) -> Scene:
    """Return the floor, the cloud and the ball."""
    camera = Camera(position=(0.0, 3.7, 5.3), target=(0.02, 0.62, 0.1), fov_y=math.radians(34))
    count = copies(PARTICLES, detail)
    vapor = smoke(alpha, 0.96, PARTICLES, count)
    glass = Material(transmission=GLASS, index=1.5, roughness=0.0, solid=True)
    slices = divisions(96, detail, 12)
    length = ROWS * TILE / 2
    middle, across = (0.0, 0.0, FRONT - length), (COLUMNS * TILE / 2, 0.0, 0.0)
    pale, dark = checkers(middle, across, (0.0, 0.0, -length), COLUMNS, ROWS)
    objects = (
        Object("pale tiles", pale, PALE_TILE, casts=False),
        Object("dark tiles", dark, DARK_TILE, casts=False),
        Object("cloud", _cloud(np.random.default_rng(seed), count), vapor, particles=True),
        Object("ball", sphere(BALL, RADIUS, slices, slices // 2), glass),
    )
    sun = DirectionalLight(opposite(SUNWARD), SUN)
    return Scene(name, camera, objects, lights=(sun, gradient_sky(SURROUNDINGS)), full_samples=16)


def _cloud(random: np.random.Generator, count: int) -> Sprites:
    """Return the particles of the cloud."""
    centers = fill(random, count, LOBES, LOBE_RADII, stretch=(1.0, 0.75, 1.0))
    return sprites(random, centers, random.uniform(*PARTICLE_RADII, count), SUNWARD)

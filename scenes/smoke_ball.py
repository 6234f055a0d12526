"""A ball of smoke made of 1,000 particles over a plain, and an opaque cube in it or above it.

All particles are one object in random order of submission, so neither sorting objects nor luck
helps. Their coverage is low and soft; the number of layers is high. The smoke scatters sunlight to
all sides, and is dark where the sun has come through much smoke. With `cube=inside` the cube stands
partly in the smoke (figure 16 of McGuire & Mara 2017, "Phenomenological Transparency"); with
`cube=above` it floats between sun and smoke, and its shadow goes through the smoke (figure 17).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from oitbench.modeling.mesh import box, quad
from oitbench.modeling.particles import puff, random_directions, shared_coverage, sprites
from oitbench.modeling.skies import gradient_sky
from oitbench.parameters import Parameter
from oitbench.scene import RGB, Camera, DirectionalLight, Material, Mesh, Object, Scene


@dataclass(frozen=True)
class View:
    """Center and size of the cube, in metres, and the camera that shows its shadow."""

    center: RGB
    size: RGB
    camera: Camera


VIEWS = {
    "inside": View(
        # Its foot is in the ground, so that no two surfaces coincide.
        center=(0.775, 0.565, -0.225),
        size=(1.15, 1.17, 1.15),
        camera=Camera((-1.9, 2.55, 4.9), (0.22, 0.82, 0.0), fov_y=math.radians(31)),
    ),
    "above": View(
        center=(-0.92, 2.62, 0.55),
        size=(0.62, 0.62, 0.62),
        camera=Camera((1.6, 3.9, 5.6), (0.0, 1.2, 0.0), fov_y=math.radians(34)),
    ),
}
quick = False
parameters = {
    "detail": Parameter(
        1.0, low=0.0, high=100.0, help="factor on the number of particles; thickness stays the same"
    ),
    "alpha": Parameter(0.2, low=0.0, high=1.0, help="coverage at a particle's middle at detail 1"),
    "seed": Parameter(1, low=0, help="seed of the particles"),
    "cube": Parameter(
        "inside", choices=tuple(VIEWS), help="partly inside the smoke, or between it and the sun"
    ),
}

PARTICLES = 1000
BALL: RGB = (0.0, 1.08, 0.0)
RADIUS = 0.92
PARTICLE_RADII = (0.11, 0.25)
SUNWARD: RGB = (-0.75, 1.0, 0.45)
SUN: RGB = (7.6, 6.9, 5.9)  # irradiance
SKY = ((-90.0, (0.12, 0.12, 0.12)), (0.0, (0.22, 0.25, 0.29)), (90.0, (0.14, 0.20, 0.30)))
GROUND: RGB = (0.24, 0.25, 0.27)
PAINT: RGB = (0.62, 0.20, 0.07)


def build(*, name: str, detail: float, alpha: float, seed: int, cube: str) -> Scene:
    """Return ground, cube and smoke."""
    view = VIEWS[cube]
    count = max(8, round(PARTICLES * detail))
    smoke = Material(
        coverage=puff(shared_coverage(alpha, PARTICLES, count)),
        albedo=(0.9, 0.9, 0.9),
        isotropic=True,
    )
    puffs = _particles(np.random.default_rng(seed), count, view.camera)
    plain = quad((0, 0, 0), (80, 0, 0), (0, 0, -80))
    objects = (
        Object("ground", plain, Material(albedo=GROUND, specular=0.0), casts=False),
        Object("cube", box(view.center, view.size), Material(albedo=PAINT, specular=0.0)),
        Object("smoke", puffs, smoke, particles=True),
    )
    sun = DirectionalLight((-SUNWARD[0], -SUNWARD[1], -SUNWARD[2]), SUN)
    return Scene(name, view.camera, objects, lights=(sun, gradient_sky(SKY)))


def _particles(random: np.random.Generator, count: int, camera: Camera) -> Mesh:
    """Return the particles, in an order that is as random as their places."""
    directions = random_directions(random, count)
    # Slow waves over the ball make its outline billow.
    billow = 1 + 0.07 * np.sin(directions @ np.array([3.1, 5.3, 4.2]) + 1.0)
    billow += 0.05 * np.sin(directions @ np.array([-7.0, 4.4, 6.1]))
    reach = RADIUS * billow * random.random(count) ** 0.4
    centers = np.asarray(BALL) + reach[:, None] * directions
    return sprites(random, centers, random.uniform(*PARTICLE_RADII, count), camera, SUNWARD)

"""A cloud of particles and a tinted glass ball over a light floor: three kinds of shadow.

Under `-translucent_shadows,-colored_shadows,-caustics` whatever keeps back half of the light hides
all of it: both throw black shadows. Under `-caustics` the cloud's shadow is as deep as the cloud is
thick, and the ball's is a disc of colored light. Under all effects called for, the ball gathers
light in the middle of its shadow. The cloud shades itself, so that its lower part is darker.
Figure 9 of McGuire & Mara 2017, "Phenomenological Transparency".
"""

from __future__ import annotations

import math

import numpy as np

from oitbench.modeling.mesh import divisions, quad, sphere
from oitbench.modeling.particles import fill, puff, shared_coverage, sprites
from oitbench.modeling.skies import gradient_sky
from oitbench.parameters import Parameter
from oitbench.scene import RGB, Camera, DirectionalLight, Material, Mesh, Object, Scene

quick = False
parameters = {
    "detail": Parameter(
        1.0, low=0.0, high=100.0, help="factor on particles and triangles; thickness stays the same"
    ),
    "alpha": Parameter(0.7, low=0.0, high=1.0, help="coverage at a particle's middle at detail 1"),
    "seed": Parameter(1, low=0, help="seed of the particles"),
}

PARTICLES = 110
# Four lobes of the cloud, metres.
LOBES: tuple[RGB, ...] = (
    (-1.30, 1.15, 0.02), (-0.95, 1.28, -0.06), (-0.62, 1.17, 0.04), (-0.92, 1.08, 0.08),
)  # fmt: skip
LOBE_RADII = (0.34, 0.42, 0.34, 0.40)
PARTICLE_RADII = (0.14, 0.24)
BALL: RGB = (0.95, 1.02, 0.0)
RADIUS = 0.52
GLASS: RGB = (0.34, 0.48, 0.60)  # transmission of one wall of the ball
SUNWARD: RGB = (-0.22, 1.0, -0.32)
SUN: RGB = (3.4, 3.3, 3.1)  # irradiance
SURROUNDINGS = ((-90.0, (0.10, 0.10, 0.10)), (0.0, (0.16, 0.17, 0.18)), (90.0, (0.10, 0.13, 0.18)))


def build(*, name: str, detail: float, alpha: float, seed: int) -> Scene:
    """Return floor, cloud and ball."""
    camera = Camera(position=(0.0, 2.75, 4.75), target=(0.03, 0.66, 0.1), fov_y=math.radians(34))
    count = max(8, round(PARTICLES * detail))
    vapor = Material(
        coverage=puff(shared_coverage(alpha, PARTICLES, count)),
        albedo=(0.96, 0.96, 0.96),
        isotropic=True,
    )
    glass = Material(transmission=GLASS, index=1.5, roughness=0.0, solid=True)
    slices = divisions(96, detail, 12)
    objects = (
        Object(
            "floor",
            quad((0, 0, 0), (30, 0, 0), (0, 0, -30)),
            Material(albedo=(0.60, 0.60, 0.58), specular=0.0),
            casts=False,
        ),
        Object("cloud", _cloud(np.random.default_rng(seed), count, camera), vapor, particles=True),
        Object("ball", sphere(BALL, RADIUS, slices, slices // 2), glass),
    )
    sun = DirectionalLight(_reversed(SUNWARD), SUN)
    return Scene(name, camera, objects, lights=(sun, gradient_sky(SURROUNDINGS)))


def _cloud(random: np.random.Generator, count: int, camera: Camera) -> Mesh:
    centers = fill(random, count, LOBES, LOBE_RADII, stretch=(1.0, 0.75, 1.0))
    return sprites(random, centers, random.uniform(*PARTICLE_RADII, count), camera, SUNWARD)


def _reversed(direction: RGB) -> RGB:
    x, y, z = direction
    return (-x, -y, -z)

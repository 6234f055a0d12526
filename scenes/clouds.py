"""Four clouds before a sky, dark below because they shade themselves.

The sun stands high on the left, behind the viewer's shoulder, so that the leftmost cloud throws its
shadow on a part of the center one. Nothing in the scene is opaque. Figure 18 of McGuire & Mara
2017, "Phenomenological Transparency".
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from oitbench.modeling.particles import fill, puff, shared_coverage, sprites
from oitbench.modeling.skies import gradient_sky
from oitbench.parameters import Parameter
from oitbench.scene import RGB, Camera, DirectionalLight, Material, Mesh, Object, Scene

quick = False
parameters = {
    "detail": Parameter(
        1.0, low=0.0, high=100.0, help="factor on the number of particles; thickness stays the same"
    ),
    "alpha": Parameter(0.25, low=0.0, high=1.0, help="coverage at a particle's middle at detail 1"),
    "seed": Parameter(1, low=0, help="seed of the particles"),
}


@dataclass(frozen=True)
class Cloud:
    """A heap of lobes (x, y, z, radius) round `center`, in metres, of `count` particles."""

    name: str
    center: RGB
    scale: float
    count: int
    lobes: tuple[tuple[float, float, float, float], ...]


# Heaps on a level base, in units of the cloud's scale.
BROAD = (
    (-0.95, 0.05, 0.0, 0.42), (-0.45, 0.22, 0.1, 0.55), (0.10, 0.36, -0.1, 0.66),
    (0.60, 0.18, 0.1, 0.52), (1.02, 0.02, 0.0, 0.38), (0.0, 0.0, 0.25, 0.50),
)  # fmt: skip
TALL = (
    (-0.55, 0.0, 0.0, 0.45), (-0.15, 0.25, 0.1, 0.55), (0.15, 0.62, 0.0, 0.50),
    (0.55, 0.05, -0.1, 0.48), (0.0, 0.0, 0.2, 0.5),
)  # fmt: skip
CLOUDS = (
    Cloud("left cloud", (-85, 112, -326), 40.0, 420, BROAD),
    Cloud("center cloud", (50, 28, -334), 50.0, 520, BROAD),
    Cloud("right cloud", (104, 112, -320), 36.0, 320, TALL),
    Cloud("far cloud", (150, 34, -520), 46.0, 260, BROAD),
)
PARTICLE_RADII = (0.20, 0.38)  # in units of the cloud's scale
FLATNESS = 0.75  # of the lobes' heights
SUNWARD: RGB = (-0.70, 0.72, 0.06)
SUN: RGB = (10.5, 9.8, 8.8)  # irradiance
SKY = (
    (-30.0, (0.16, 0.19, 0.20)),
    (-1.0, (0.36, 0.42, 0.46)),
    (1.0, (0.60, 0.70, 0.78)),
    (12.0, (0.30, 0.48, 0.72)),
    (35.0, (0.10, 0.24, 0.52)),
    (90.0, (0.05, 0.13, 0.36)),
)


def build(*, name: str, detail: float, alpha: float, seed: int) -> Scene:
    """Return the clouds, the nearer ones first."""
    camera = Camera(position=(0, 2, 0), target=(8, 70, -320), fov_y=math.radians(38), near=10.0)
    objects = []
    for stream, cloud in enumerate(CLOUDS):
        # A stream of its own, so that no cloud changes with the others' numbers of particles.
        random = np.random.default_rng([seed, stream])
        count = max(8, round(cloud.count * detail))
        vapor = Material(
            coverage=puff(shared_coverage(alpha, cloud.count, count)),
            albedo=(0.99, 0.99, 0.99),
            isotropic=True,
        )
        mesh = _particles(cloud, random, count, camera)
        objects.append(Object(cloud.name, mesh, vapor, particles=True))
    sun = DirectionalLight((-SUNWARD[0], -SUNWARD[1], -SUNWARD[2]), SUN)
    return Scene(name, camera, tuple(objects), lights=(sun, gradient_sky(SKY)))


def _particles(cloud: Cloud, random: np.random.Generator, count: int, camera: Camera) -> Mesh:
    lobes = np.asarray(cloud.lobes)
    places = fill(random, count, lobes[:, :3], lobes[:, 3], stretch=(1.0, FLATNESS, 1.0))
    centers = np.asarray(cloud.center) + cloud.scale * places
    radii = cloud.scale * random.uniform(*PARTICLE_RADII, count)
    return sprites(random, centers, radii, camera, SUNWARD)

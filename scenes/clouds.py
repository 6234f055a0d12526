"""Four clouds in front of a sky, dark below because they shadow themselves.

Stands for figure 18 of McGuire & Mara 2017, "Phenomenological Transparency".

Parameters
----------
detail : float
    Factor on the number of particles. The optical thickness stays the same.
alpha : float
    Coverage at the middle of a particle at detail 1, in [0, 1].
seed : int
    Seed of the particles.
near : float
    Distance of the near plane from the camera, m. The nearest cloud is 290 m away.

The sun is high on the left behind the viewer, so that the leftmost cloud casts its shadow on a part
of the center one. Nothing in the scene is opaque.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from oitbench.modeling.detail import PARTICLE_DETAIL, copies
from oitbench.modeling.particles import fill, smoke, sprites
from oitbench.modeling.surroundings import gradient_sky
from oitbench.parameters import Parameter
from oitbench.scene import RGB, Camera, DirectionalLight, Object, Scene, Sprites, Vector, opposite

subject = "smoke"
quick = False
near = 240.0
crops = {
    "center_cloud": (0.28, 0.38, 0.66, 0.36),
    "lit_side": (0.62, 0.48, 0.1, 0.07),
    "shaded_side": (0.42, 0.48, 0.1, 0.07),
    "foot": (0.62, 0.62, 0.1, 0.07),
}
parameters = {
    "detail": PARTICLE_DETAIL,
    "alpha": Parameter(
        0.25, low=0.0, high=1.0, help="coverage at the middle of a particle at detail 1"
    ),
    "seed": Parameter(1, low=0, help="seed of the particles"),
}


@dataclass(frozen=True)
class Cloud:
    """A heap of spherical lobes that is filled with particles.

    Parameters
    ----------
    name : str
    center : Vector
        Meters.
    scale : float
        Meters per unit of the lobes.
    count : int
        Number of particles at detail 1.
    lobes : tuple
        (x, y, z, radius) of each lobe, in units of `scale`.
    """

    name: str
    center: Vector
    scale: float
    count: int
    lobes: tuple[tuple[float, float, float, float], ...]


# Lobes on a level base.
BROAD = (
    (-0.95, 0.05, 0.0, 0.42), (-0.45, 0.22, 0.1, 0.55), (0.10, 0.36, -0.1, 0.66),
    (0.60, 0.18, 0.1, 0.52), (1.02, 0.02, 0.0, 0.38), (0.0, 0.0, 0.25, 0.50),
)  # fmt: skip
TALL = (
    (-0.55, 0.0, 0.0, 0.45), (-0.15, 0.25, 0.1, 0.55), (0.15, 0.62, 0.0, 0.50),
    (0.55, 0.05, -0.1, 0.48), (0.0, 0.0, 0.2, 0.5),
)  # fmt: skip
CLOUDS = (
    Cloud("left cloud", (-58, 138, -322), 34.0, 700, BROAD),
    Cloud("center cloud", (24, 64, -340), 53.0, 1100, BROAD),
    Cloud("right cloud", (72, 142, -352), 31.0, 500, TALL),
    Cloud("far cloud", (-112, 34, -520), 35.0, 450, BROAD),
)
PARTICLE_RADII = (0.15, 0.29)  # in units of the cloud's scale
FLATNESS = 0.75  # factor on the heights of the lobes
SUNWARD: Vector = (-0.62, 0.76, 0.26)
SUN: RGB = (9.6, 9.0, 8.1)  # irradiance
SKY = (
    (-90.0, (0.04, 0.05, 0.06)),
    (-30.0, (0.10, 0.12, 0.14)),
    (-5.0, (0.50, 0.58, 0.64)),
    (1.0, (0.60, 0.70, 0.78)),
    (12.0, (0.30, 0.48, 0.72)),
    (35.0, (0.10, 0.24, 0.52)),
    (90.0, (0.05, 0.13, 0.36)),
)


def build(*, name: str, detail: float, alpha: float, seed: int) -> Scene:
    """Return the clouds."""
    camera = Camera(position=(0, 2, 0), target=(0, 92, -320), fov_y=math.radians(40))
    objects = []
    for stream, cloud in enumerate(CLOUDS):
        # With a stream of its own, no cloud depends on the number of particles of the others.
        random = np.random.default_rng([seed, stream])
        count = copies(cloud.count, detail)
        vapor = smoke(alpha, 0.99, cloud.count, count)
        mesh = _particles(cloud, random, count)
        objects.append(Object(cloud.name, mesh, vapor, particles=True))
    sun = DirectionalLight(opposite(SUNWARD), SUN)
    return Scene(name, camera, tuple(objects), lights=(sun, gradient_sky(SKY)), full_samples=4)


def _particles(cloud: Cloud, random: np.random.Generator, count: int) -> Sprites:
    """Return the particles of one cloud."""
    lobes = np.asarray(cloud.lobes)
    places = fill(random, count, lobes[:, :3], lobes[:, 3], stretch=(1.0, FLATNESS, 1.0))
    centers = np.asarray(cloud.center) + cloud.scale * places
    radii = cloud.scale * random.uniform(*PARTICLE_RADII, count)
    return sprites(random, centers, radii, SUNWARD)

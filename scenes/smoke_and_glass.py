"""Drifting smoke among glass panes, glass balls and a vase, between a fence and crates.

Stands for figure 23 of McGuire & Mara 2017, "Phenomenological Transparency".

Parameters
----------
detail : float
    Factor on the number of particles and triangles. The optical thickness stays the same.
alpha : float
    Coverage at the middle of a particle at detail 1, in [0, 1].
seed : int
    Seed of the particles.
near : float
    Distance of the near plane from the camera, m. The smoke begins at 3.3 m.

Two thousand large, soft particles fill the view, more than twenty deep nearly everywhere, while
glass covers a small part of it: almost all fragments are smoke without fine detail. Accumulating
the particles at a quarter of the width and height therefore saves nearly all of the work, as long
as opaque edges and glass, which are drawn at full resolution, stay sharp.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from oitbench.modeling.detail import PARTICLE_DETAIL, copies, divisions
from oitbench.modeling.mesh import box, lathe, quad, sphere
from oitbench.modeling.particles import fill, smoke, sprites
from oitbench.modeling.placement import merge, transform, translation
from oitbench.modeling.profiles import smooth_curve
from oitbench.modeling.surroundings import gradient_sky
from oitbench.parameters import Parameter
from oitbench.scene import (
    RGB,
    Camera,
    DirectionalLight,
    Material,
    Mesh,
    Object,
    Scene,
    Sprites,
    Vector,
    opposite,
)

subject = "smoke and glass"
quick = False
near = 3.0
crops = {"edges": (0.4, 0.34, 0.4, 0.4)}
parameters = {
    "detail": PARTICLE_DETAIL,
    "alpha": Parameter(
        0.024, low=0.0, high=1.0, help="coverage at the middle of a particle at detail 1"
    ),
    "seed": Parameter(1, low=0, help="seed of the particles"),
}

PARTICLES = 2000
# Banks of smoke (x, y, z, radius), meters, and factors that flatten them.
BANKS = (
    (-2.3, 0.8, -0.6, 1.6), (-0.5, 1.5, 0.6, 1.3), (1.7, 0.7, -0.3, 1.5),
    (0.4, 0.4, 1.2, 1.3), (-1.3, 2.4, -1.6, 1.6), (2.2, 2.2, -1.4, 1.5), (0.2, 1.3, -2.8, 2.4),
)  # fmt: skip
FLATNESS: Vector = (1.0, 0.45, 0.7)
PARTICLE_RADII = (0.42, 0.72)
SINK = 0.02  # depth of wood in the ground in meters, so that no two surfaces coincide
GAP = 0.002  # meters between glass and the surface that it stands on
SUNWARD: Vector = (-0.55, 1.0, 0.35)
SUN: RGB = (6.4, 5.9, 5.0)  # irradiance
# The ground hides the lower half.
SURROUNDINGS = (
    (-4.2, (0.0, 0.0, 0.0)),
    (-1.4, (0.15, 0.20, 0.27)),
    (90.0, (0.05, 0.09, 0.17)),
)
WOOD = Material(albedo=(0.42, 0.25, 0.13), specular=0.0)
PAINT = Material(albedo=(0.10, 0.11, 0.13), specular=0.0)
EARTH = Material(albedo=(0.17, 0.16, 0.14), specular=0.0)
# Middle and half width of each pane in meters, its turn about y in degrees, and its transmission.
PANES: tuple[tuple[str, Vector, float, float, RGB], ...] = (
    ("red pane", (-1.15, 0.72, 0.95), 0.42, 24.0, (0.93, 0.11, 0.07)),
    ("yellow pane", (-0.62, 0.80, 0.35), 0.44, -14.0, (0.95, 0.66, 0.06)),
    ("blue pane", (0.30, 0.60, 1.15), 0.38, 12.0, (0.08, 0.24, 0.92)),
)
# Center and size of each crate, meters.
CRATES: tuple[tuple[Vector, Vector], ...] = (
    ((1.18, 0.30, -0.10), (0.80, 0.64, 0.80)),
    ((1.72, 0.20, 0.75), (0.46, 0.44, 0.46)),
    ((-0.20, 0.20, -0.65), (0.62, 0.44, 0.62)),
)
FENCE_DISTANCE = -1.75
POSTS = 9


def build(*, name: str, detail: float, alpha: float, seed: int) -> Scene:
    """Return opaque and transparent objects, in an order that is right from no viewpoint."""
    camera = Camera(position=(0.35, 1.55, 5.6), target=(0.12, 0.82, 0.0), fov_y=math.radians(34))
    count = copies(PARTICLES, detail)
    particles = _particles(np.random.default_rng(seed), count)
    vapor = smoke(alpha, 0.90, PARTICLES, count)
    objects = (
        Object("ground", quad((0, 0, 0), (300, 0, 0), (0, 0, -300)), EARTH, casts=False),
        Object("crates", merge([_sunk(*crate) for crate in CRATES]), WOOD),
        Object("fence", _fence(), PAINT),
        *_solids(detail),
        Object("smoke", particles, vapor, particles=True),
        *_panes(),
    )
    sun = DirectionalLight(opposite(SUNWARD), SUN)
    return Scene(name, camera, objects, lights=(sun, gradient_sky(SURROUNDINGS)), full_samples=16)


def _particles(random: np.random.Generator, count: int) -> Sprites:
    """Return the particles of banks of smoke that drift through the view."""
    banks = np.asarray(BANKS)
    centers = fill(random, count, banks[:, :3], banks[:, 3], stretch=FLATNESS)
    # Slow waves gather the particles into wreaths.
    centers[:, 0] += 0.22 * np.sin(3.1 * centers[:, 0] + 2.3 * centers[:, 2] + 0.6)
    centers[:, 1] += 0.18 * np.sin(2.7 * centers[:, 0] - 1.9 * centers[:, 2])
    return sprites(random, centers, random.uniform(*PARTICLE_RADII, count), SUNWARD)


def _panes() -> Iterator[Object]:
    """Yield standing panes of colored glass."""
    for label, center, half, turn, transmission in PANES:
        angle = math.radians(turn)
        right: Vector = (half * math.cos(angle), 0.0, -half * math.sin(angle))
        glass = Material(transmission=transmission, index=1.5, roughness=0.0)
        yield Object(label, quad(center, right, (0, center[1] - GAP, 0)), glass)


def _solids(detail: float) -> Iterator[Object]:
    """Yield two balls and a vase of solid glass, each on a crate."""
    slices = divisions(64, detail, 12)
    balls: tuple[tuple[str, Vector, float, RGB], ...] = (
        ("clear ball", (1.36, 0.62 + 0.24 + GAP, 0.12), 0.24, (0.92, 0.92, 0.92)),
        ("green ball", (-0.16, 0.42 + 0.21 + GAP, -0.62), 0.21, (0.55, 0.93, 0.66)),
    )
    for label, center, radius, transmission in balls:
        glass = Material(transmission=transmission, index=1.5, roughness=0.0, solid=True)
        yield Object(label, sphere(center, radius, slices, slices // 2), glass)
    outline = np.array([(0, 0), (13, 0), (15, 4), (9, 22), (6, 34), (9, 44), (8, 47), (0, 47)])
    profile = smooth_curve(outline / 100, divisions(60, detail, 14))
    vase = transform(lathe(profile, slices), translation((1.00, 0.62 + GAP, -0.28)))
    amber = Material(transmission=(0.96, 0.80, 0.62), index=1.5, roughness=0.0, solid=True)
    yield Object("vase", vase, amber)


def _fence() -> Mesh:
    """Return posts and two rails in front of them."""
    spots = np.linspace(-3.2, 3.2, POSTS)
    posts = [_sunk((x, 0.62, FENCE_DISTANCE), (0.13, 1.28, 0.10)) for x in spots]
    rails = [box((0.0, y, FENCE_DISTANCE + 0.08), (7.2, 0.11, 0.05)) for y in (0.48, 0.98)]
    return merge([*posts, *rails])


def _sunk(center: Vector, size: Vector) -> Mesh:
    """Return a box that is lengthened downwards, so that its foot is `SINK` below the ground."""
    top = center[1] + size[1] / 2
    height = top + SINK
    return box((center[0], top - height / 2, center[2]), (size[0], height, size[2]))

"""A fire behind dark glass at night: flames, embers and neon light among smoke.

Stands for no single figure: it asks for what particle effects of engines are made of, light that is
added, in one picture with the smoke and glass of figure 23 of McGuire & Mara 2017,
"Phenomenological Transparency".

Parameters
----------
detail : float
    Factor on the number of particles and triangles. Light and optical thickness stay the same.
alpha : float
    Coverage at the middle of a particle of smoke at detail 1, in [0, 1].
opacity : float
    Part of the light behind a flame that it hides, in [0, 1].
seed : int
    Seed of the particles.
near : float
    Distance of the near plane from the camera, m. The smoke begins at 3.7 m.

Flames, embers and the halos of the neon sign add light and hide nothing. A material says so with a
transmission of one: a layer of coverage α and radiance L then adds α·L, and its transmittance
τ = 1 − α + α·1 is exactly 1, for any α, which is a texture here. Its net opacity is 0. A coverage
of 0 would add nothing, and a small one with a large radiance would hide a little. Absorbing layers
before such a layer dim it, and those behind it do not. A sum of all light is therefore wrong, and
an average that is weighted by opacity loses it. `opacity` leads from added to painted light.

The fire burns in a pit with a wind guard of four smoked panes. Smoke drifts through the flames, and
a light in the fire shines on the paving, tinted where it passes the panes.
"""

from __future__ import annotations

import math

import numpy as np

from oitbench.modeling.detail import PARTICLE_DETAIL, copies, divisions
from oitbench.modeling.flames import added_light, flame, halo, spark
from oitbench.modeling.mesh import grid, quad
from oitbench.modeling.particles import smoke, sprites
from oitbench.modeling.patterns import checkers
from oitbench.modeling.placement import merge, rotation, transform, translation
from oitbench.modeling.profiles import smooth_curve
from oitbench.modeling.surroundings import gradient_sky
from oitbench.modeling.sweeps import cylinder, pipe, plate
from oitbench.parameters import Parameter
from oitbench.scene import (
    RGB,
    Camera,
    Material,
    Object,
    Scene,
    SpotLight,
    Sprites,
    as_vector,
)

subject = "smoke"
quick = False
near = 3.0
crops = {"flames": (0.34, 0.4, 0.38, 0.4), "sparks": (0.52, 0.05, 0.32, 0.36)}
parameters = {
    "detail": PARTICLE_DETAIL,
    "alpha": Parameter(
        0.14, low=0.0, high=1.0, help="coverage at the middle of a particle at detail 1"
    ),
    "opacity": Parameter(0.0, low=0.0, high=1.0, help="part of the light behind a flame it hides"),
    "seed": Parameter(1, low=0, help="seed of the particles"),
}

FLAMES, EMBERS, PARTICLES = 90, 260, 420
FLAME_LIGHT, EMBER_LIGHT = 0.45, (9.0, 3.1, 0.54)  # factor on HEAT, and radiance, at detail 1
# Radiance of a flame from its rim to its heart.
HEAT: tuple[RGB, ...] = (
    (0.55, 0.04, 0.00),
    (1.30, 0.22, 0.02),
    (1.70, 0.62, 0.10),
    (1.9, 1.25, 0.50),
)
PIT, RIM, GUARD = (
    0.55,
    0.42,
    0.56,
)  # half its width, its height, and the height of the panes, meters
WALL = -2.4
SMOKED = Material(transmission=(0.40, 0.33, 0.27), index=1.5, roughness=0.0)
STONE, DARK_STONE = (
    Material(albedo=albedo, specular=0.0) for albedo in ((0.30, 0.28, 0.27), (0.20, 0.19, 0.19))
)
CONCRETE = Material(albedo=(0.34, 0.33, 0.32), specular=0.0)
BRICK = Material(albedo=(0.24, 0.14, 0.11), specular=0.0)
CHARRED = Material(albedo=(0.07, 0.055, 0.05), specular=0.0)
COALS = Material(emission=(2.2, 0.42, 0.05))
Stroke = list[tuple[float, float]]
# The letters of the sign: middle on the wall, strokes around it in meters, and radiance.
_O: Stroke = [
    (-0.2, -0.2),
    (-0.2, 0.2),
    (0.0, 0.32),
    (0.2, 0.2),
    (0.2, -0.2),
    (0.0, -0.32),
    (-0.2, -0.2),
]
SIGN: tuple[tuple[str, tuple[float, float], list[Stroke], RGB], ...] = (
    ("O", (-1.27, 1.95), [_O], (3.2, 0.35, 1.1)),
    ("I", (-0.85, 1.95), [[(0.0, -0.32), (0.0, 0.32)]], (0.30, 2.0, 3.0)),
    ("T", (-0.43, 1.95), [[(-0.2, 0.32), (0.2, 0.32)], [(0, -0.32), (0, 0.29)]], (3.0, 1.7, 0.25)),
)
HALO = 0.62  # half the side of a letter's halo
# Corners of the path of the smoke; spread and radius of the particles at both ends.
PLUME = (
    (-0.05, 0.6, 0),
    (-0.1, 1, -0.1),
    (-0.3, 1.45, -0.2),
    (-0.75, 1.8, -0.3),
    (-1.3, 1.9, -0.5),
)
SPREAD, PARTICLE_RADII = (0.14, 0.32), (0.14, 0.34)
FIRE = SpotLight(
    position=(0.34, 1.15, 0.32),
    target=(0.28, 0.0, 0.02),
    intensity=(6.5, 3.2, 1.2),
    angle=math.radians(172),
)
NIGHT = ((-90.0, (0.006, 0.006, 0.008)), (0.0, (0.08, 0.09, 0.13)), (90.0, (0.022, 0.034, 0.080)))


def build(*, name: str, detail: float, alpha: float, opacity: float, seed: int) -> Scene:
    """Return the fire, its smoke and its guard, the paving, and the wall with the sign."""
    streams = [np.random.default_rng([seed, stream]) for stream in range(3)]
    return Scene(
        name=name,
        camera=Camera(
            position=(0.75, 1.75, 4.3), target=(-0.12, 1.10, 0.0), fov_y=math.radians(33)
        ),
        objects=(
            *_terrace(detail),
            *_flames(streams[0], detail, opacity),
            _smoke(streams[1], detail, alpha),
            _embers(streams[2], detail, opacity),
            *_sign(detail, opacity),
            *_guard(),
        ),
        lights=(FIRE, gradient_sky(NIGHT)),
        full_samples=16,
    )


def _flames(random: np.random.Generator, detail: float, opacity: float) -> tuple[Object, ...]:
    """Return flames that bend to the left and to the right."""
    count = copies(FLAMES, detail)
    angle, reach = random.uniform(0, 2 * math.pi, count), 0.36 * random.random(count) ** 0.6
    size = random.uniform(0.17, 0.34, count) * (1.25 - reach)
    height = RIM + 0.03 + 0.80 * size + 0.25 * random.random(count) ** 3
    centers = np.stack([reach * np.cos(angle), height, reach * np.sin(angle)], axis=1)
    turns = random.uniform(-0.12, 0.12, count)
    light = FLAME_LIGHT * FLAMES / count * np.asarray(HEAT)
    objects = []
    for number, bend in enumerate((-1.0, 1.0)):
        chosen = slice(number, None, 2)
        material = added_light(*flame(bend, [as_vector(color) for color in light]), opacity)
        mesh = Sprites(centers[chosen], size[chosen], turns[chosen])
        objects.append(Object(f"flames {number}", mesh, material))
    return tuple(objects)


def _embers(random: np.random.Generator, detail: float, opacity: float) -> Object:
    """Return sparks that whirl up from the fire and drift to the right."""
    count = copies(EMBERS, detail)
    rise = random.random(count) ** 1.5
    angle = 7.0 * rise + random.uniform(0, 2 * math.pi, count)
    reach = (0.10 + 0.36 * rise) * random.uniform(0.4, 1.2, count)
    x, z = reach * np.cos(angle) + 0.35 * rise**1.5, 0.8 * reach * np.sin(angle)
    centers = np.stack([x, RIM + 0.15 + 1.65 * rise, z], axis=1)
    light = as_vector(EMBERS / count * np.asarray(EMBER_LIGHT))
    mesh = Sprites(centers, random.uniform(0.008, 0.016, count))
    return Object("embers", mesh, added_light(spark(), light, opacity))


def _smoke(random: np.random.Generator, detail: float, alpha: float) -> Object:
    """Return smoke that rises through the flames and drifts to the left, before the sign."""
    count = copies(PARTICLES, detail)
    path = smooth_curve(PLUME, 100)
    along = random.random(count) ** 0.75
    away = random.normal(size=(count, 3)) * [0.8, 0.6, 0.8]
    centers = path[(along * 99).astype(int)] + np.interp(along, [0, 1], SPREAD)[:, None] * away
    radii = np.interp(along, [0, 1], PARTICLE_RADII) * random.uniform(0.8, 1.2, count)
    mesh = sprites(random, centers, radii, FIRE.position)
    return Object("smoke", mesh, smoke(alpha, 0.9, PARTICLES, count), particles=True)


def _sign(detail: float, opacity: float) -> tuple[Object, ...]:
    """Return the tubes of each letter, and before them the light around the letter."""
    steps, sides = divisions(30, detail, 8), divisions(10, detail, 5)
    objects = []
    for number, (label, middle, strokes, light) in enumerate(SIGN):
        tubes = []
        for stroke in strokes:
            points = [(x + middle[0], y + middle[1], WALL + 0.06) for x, y in stroke]
            tubes.append(pipe(points, 0.017, steps, sides))
        lines = [smooth_curve(stroke, 60) / HALO for stroke in strokes]
        around = added_light(halo(lines, 0.10 / HALO), as_vector(0.2 * np.asarray(light)), opacity)
        # Halos overlap, and no two lie in one plane.
        center = (*middle, WALL + 0.10 + 0.01 * number)
        tube = Material(emission=light)
        objects += [
            Object(f"neon {label}", merge(tubes), tube, casts=False),
            Object(f"halo {label}", quad(center, (HALO, 0, 0), (0, HALO, 0)), around),
        ]
    return tuple(objects)


def _guard() -> tuple[Object, ...]:
    """Return the four panes of the wind guard, each an object."""
    pane = quad((0, RIM + 0.02 + GUARD / 2, PIT), (PIT - 0.04, 0, 0), (0, GUARD / 2, 0))
    return tuple(
        Object(f"{side} pane", transform(pane, rotation((0, 1, 0), turn * math.pi / 2)), SMOKED)
        for turn, side in enumerate(("front", "right", "back", "left"))
    )


def _terrace(detail: float) -> tuple[Object, ...]:
    """Return the paving, the wall, the pit, its logs and its coals."""
    paving = checkers((0, 0, 0.4), (5.0, 0, 0), (0, 0, -2.8), 20, 11)
    wall = grid((0, 2.5, WALL), (5.0, 0, 0), (0, 2.5, 0))
    square = np.array([(1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0)])
    rim = plate((PIT + 0.10) * square, (PIT - 0.10) * square, RIM - 0.002)
    upright = translation((0, RIM / 2 + 0.001, 0)) @ rotation((1, 0, 0), -math.pi / 2)
    sides = divisions(14, detail, 6)
    logs = []
    for number in range(5):
        angle = number * 2 * math.pi / 5 + 0.3
        end = (0.40 * math.cos(angle), RIM - 0.10, 0.40 * math.sin(angle))
        tip = (-0.06 * math.cos(angle), RIM + 0.18, -0.06 * math.sin(angle))
        logs.append(cylinder(end, tip, 0.052, 0.008, sides))
    half = PIT - 0.102
    coals = grid((0, RIM - 0.14, 0), (half, 0, 0), (0, 0, -half))
    return (
        Object("paving", paving[0], STONE, casts=False),
        Object("dark paving", paving[1], DARK_STONE, casts=False),
        Object("wall", wall, BRICK, casts=False),
        Object("pit", transform(rim, upright), CONCRETE),
        Object("logs", merge(logs), CHARRED),
        Object("coals", coals, COALS, casts=False),
    )

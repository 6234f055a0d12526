"""A ball of smoke made of 1,000 camera-facing particles, before and around an opaque cube.

All particles are one object in random order of submission, so neither sorting objects nor luck
helps. Their coverage is low and soft; the number of layers is high. Light and shadow are baked
into the radiance of each particle. The arrangement is that of figure 16 of McGuire & Mara 2017,
"Phenomenological Transparency".
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from oitbench.bake import (
    Floats,
    Rig,
    box_blocks,
    cone,
    diffuse,
    normals_of,
    sphere_chord,
    with_radiance,
)
from oitbench.geometry import billboards, box, divisions, grid
from oitbench.scene import RGB, WHITE, Camera, Material, Mesh, Object, Scene, Texture
from oitbench.selector import Parameter

parameters = {
    "detail": Parameter(
        1.0, low=0.0, high=100.0, help="factor on the number of particles; thickness stays the same"
    ),
    "alpha": Parameter(0.2, low=0.0, high=1.0, help="coverage at a particle's middle at detail 1"),
    "seed": Parameter(1, low=0, help="seed of the particles"),
}

PARTICLES = 1000
BALL: RGB = (0.0, 1.08, 0.0)
RADIUS = 0.92
CUBE_LOW: RGB = (0.20, 0.0, -0.80)
CUBE_HIGH: RGB = (1.35, 1.15, 0.35)
BACKGROUND: RGB = (0.40, 0.52, 0.66)
LIGHTS = Rig(
    toward_key=(-0.75, 1.0, 0.45),
    key=(0.95, 0.82, 0.64),
    sky=(0.26, 0.33, 0.45),
    ground=(0.14, 0.14, 0.15),
)
LIGHT_SPREAD = math.radians(5)
EXTINCTION = 2.4  # of the light on its way through the ball, 1/m
TEXTURE_SIDE = 128
BORDER = 3


def build(*, name: str, detail: float, alpha: float, seed: int) -> Scene:
    """Return ground, cube and smoke."""
    camera = Camera(position=(-1.9, 2.55, 4.9), target=(0.22, 0.82, 0.0), fov_y=math.radians(31))
    ground = Object("ground", _ground(detail), Material(emission=WHITE))
    cube = Object("cube", _cube(detail), Material(emission=WHITE))
    random = np.random.default_rng(seed)
    count = max(8, round(PARTICLES * detail))
    # The same optical depth from any number of particles: ln(1 − α) is shared out.
    single = 1 - (1 - alpha) ** (PARTICLES / count)
    smoke = Object(
        "smoke",
        _particles(random, count, camera),
        Material(coverage=_puff(single), emission=WHITE),
    )
    return Scene(name=name, camera=camera, objects=(ground, cube, smoke), background=BACKGROUND)


def _particles(random: np.random.Generator, count: int, camera: Camera) -> Mesh:
    """Return the billboards, in an order that is as random as their places."""
    directions = random.normal(size=(count, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    # Slow waves over the ball make its outline billow.
    billow = 1 + 0.07 * np.sin(directions @ np.array([3.1, 5.3, 4.2]) + 1.0)
    billow += 0.05 * np.sin(directions @ np.array([-7.0, 4.4, 6.1]))
    reach = RADIUS * billow * random.random(count) ** 0.4
    centers = np.asarray(BALL) + reach[:, None] * directions
    radii = random.uniform(0.11, 0.25, count)
    puffs = billboards(centers, radii, camera, random.uniform(0, 2 * math.pi, count))
    shade = _smoke_radiance(centers) * random.uniform(0.9, 1.1, (count, 1))
    return with_radiance(puffs, np.repeat(shade, 4, axis=0))


def _smoke_radiance(centers: Floats) -> Floats:
    """Return the light that smoke scatters at each particle, dimmed by smoke and cube before it."""
    outward = (centers - np.asarray(BALL)) / (1.2 * RADIUS)
    depth = sphere_chord(centers, LIGHTS.direction, BALL, 1.1 * RADIUS)
    lit = np.exp(-EXTINCTION * depth) * _past_cube(centers)
    height = np.clip(0.5 + 0.5 * outward[:, 1:2], 0, 1)
    inside = 1 - 0.45 * (1 - np.linalg.norm(outward, axis=1, keepdims=True)).clip(0, 1)
    fill = height * np.asarray(LIGHTS.sky) + (1 - height) * np.asarray(LIGHTS.ground)
    return np.asarray(0.95 * lit[:, None] * np.asarray(LIGHTS.key) + 0.9 * fill * inside)


def _puff(alpha: float) -> Texture:
    """Return a soft, wispy disc of coverage that is `alpha` at most and 0 at its border."""
    line = (np.arange(TEXTURE_SIDE) + 0.5) / TEXTURE_SIDE * 2 - 1
    x, y = np.meshgrid(line, line)
    distance = np.hypot(x, y) / (1 - 2 * BORDER / TEXTURE_SIDE)
    disc = np.maximum(1 - distance**2, 0) ** 1.5
    wisp = 0.5 + 0.5 * np.sin(5.0 * x + 2.3 * np.sin(4.1 * y + 0.7) + 0.4)
    wisp = 0.5 * wisp + 0.25 + 0.25 * np.sin(6.3 * y - 2.9 * np.sin(5.2 * x + 2.0))
    return Texture((alpha * disc * (0.65 + 0.35 * wisp)).astype(np.float32))


def _past_cube(points: Floats) -> Floats:
    """Return how much of the lamp each point sees past the cube, shape (n,)."""
    directions = cone(LIGHTS.direction, LIGHT_SPREAD, 24)
    hidden = [box_blocks(points, direction, CUBE_LOW, CUBE_HIGH) for direction in directions]
    return np.asarray(1 - np.mean(hidden, axis=0))


def _past_smoke(points: Floats) -> Floats:
    """Return how much light reaches each point through the ball, softer than the ball's outline."""
    directions = cone(LIGHTS.direction, 3 * LIGHT_SPREAD, 24)
    passed = [
        np.exp(-EXTINCTION * sphere_chord(points, direction, BALL, 0.95 * RADIUS))
        for direction in directions
    ]
    return np.asarray(np.mean(passed, axis=0))


def _cube(detail: float) -> Mesh:
    low, high = np.asarray(CUBE_LOW), np.asarray(CUBE_HIGH)
    center, size = (low + high) / 2, high - low
    mesh = box(_triple(center), _triple(size), divisions(32, detail, 4))
    points, normals = mesh.positions.astype(np.float64), normals_of(mesh)
    openness = 0.55 + 0.45 * np.clip(points[:, 1:2] / 0.7, 0, 1)
    openness *= (0.4 + 0.6 * _past_smoke(points + 1e-3 * normals))[:, None]
    shade = diffuse(normals, LIGHTS, _past_smoke(points)[:, None], openness)
    return with_radiance(mesh, np.array([0.92, 0.42, 0.20]) * shade)


def _ground(detail: float) -> Mesh:
    """Return a plain that fades into the background; its cells are smallest under the smoke."""
    cells = divisions(160, detail, 24)
    flat = grid((0, 0, 0), (1, 0, 0), (0, 0, -1), cells, cells)
    line = flat.positions.astype(np.float64)
    points = 2.2 * line + 57.8 * np.abs(line) ** 9 * np.sign(line) + [0.6, 0, -0.4]
    distance = np.hypot(points[:, 0] - 0.4, points[:, 2])
    lit = _past_smoke(points) * _past_cube(points)
    gap = np.maximum(np.maximum(np.asarray(CUBE_LOW) - points, points - np.asarray(CUBE_HIGH)), 0)
    openness = 1 - 0.45 * np.exp(-np.hypot(gap[:, 0], gap[:, 2]) / 0.16)
    openness *= 1 - 0.35 * np.exp(-((np.hypot(points[:, 0], points[:, 2]) / 0.8) ** 2))
    shade = diffuse(normals_of(flat), LIGHTS, lit[:, None], openness[:, None])
    haze = 1 - np.exp(-((distance / 9) ** 2))[:, None]
    plain = np.array([0.44, 0.47, 0.52]) * shade
    mesh = Mesh(points.astype(np.float32), flat.triangles, flat.uvs, normals=flat.normals)
    return with_radiance(mesh, (1 - haze) * plain + haze * np.asarray(BACKGROUND))


def _triple(values: npt.NDArray[np.float64]) -> RGB:
    return (float(values[0]), float(values[1]), float(values[2]))

"""Smoke from a burning drum drifts between parked vehicles, windows, a wire fence and bushes.

Stands for scene SMOKE in figures 1 (left), 6 and 7 and table 1 of Salvi et al. 2011, "Adaptive
Transparency".

Parameters
----------
detail : float
    Factor on the number of particles, cards and triangles. The optical thickness stays the same.
alpha : float
    Coverage at the middle of a particle of the plume at detail 1, in [0, 1].
seed : int
    Seed of particles and foliage.
near : float
    Distance of the near plane from the camera, m. The fence begins at 3.1 m.

The smoke is seen through the fence, through the windows of two vehicles and through foliage, and it
lies before and behind the windows of the workshop. Near the drum, more than three hundred particles
lie behind each other, on half a meter of the ten that all layers span. Sorting the particles alone
would not help: fence, glass and leaves lie among them.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from oitbench.modeling.baking import tint
from oitbench.modeling.detail import PARTICLE_DETAIL, copies, divisions
from oitbench.modeling.mesh import box, lathe, quad, slab
from oitbench.modeling.particles import smoke, sprites
from oitbench.modeling.patterns import checkers
from oitbench.modeling.placement import (
    merge,
    random_directions,
    repeated,
    rotation,
    scatter,
    translation,
)
from oitbench.modeling.props.leaves import card_frames
from oitbench.modeling.props.sprays import twig
from oitbench.modeling.props.vehicles import SEDAN, VAN, Shape, vehicle
from oitbench.modeling.props.wire import mesh_fence
from oitbench.modeling.surroundings import gradient_sky
from oitbench.modeling.tubes import straight, tubes
from oitbench.modeling.voxels import density
from oitbench.parameters import Parameter
from oitbench.scene import (
    RGB,
    Camera,
    DirectionalLight,
    Floats,
    Material,
    Object,
    Scene,
    Texture,
    Vector,
    opposite,
)

subject = "smoke"
quick = False
near = 2.6
crops = {"fence": (0.38, 0.38, 0.28, 0.46)}
parameters = {
    "detail": PARTICLE_DETAIL,
    "alpha": Parameter(0.044, low=0.0, high=1.0, help="coverage at the middle of a particle"),
    "seed": Parameter(1, low=0, help="seed of particles and foliage"),
}

CAMERA = Camera(position=(0.4, 1.75, 0.0), target=(-0.1, 1.45, -9.0), fov_y=math.radians(36))
VIEWS = {"gate": replace(CAMERA, position=(3.6, 1.6, -0.2), target=(-1.2, 1.5, -9.0))}
SUNWARD: Vector = (-0.62, 0.70, 0.36)
SUN: RGB = (9.0, 7.9, 6.2)  # irradiance
SKY = (
    (-4.0, (0.0, 0.0, 0.0)),
    (-1.0, (0.42, 0.44, 0.45)),
    (20.0, (0.40, 0.48, 0.58)),
    (90.0, (0.20, 0.32, 0.52)),
)
FENCE, WALL, BACK = -3.6, -11.5, -16.0  # z of the fence, of the workshop's front and of its back
ALBEDO = 0.96
"""Fraction of the light that a particle of smoke scatters."""
LOW, HIGH, CELL = (-7.5, 0.0, -16.0), (6.0, 6.0, -3.0), 0.16  # the box of the smoke, meters
DRUM: Vector = (0.0, 0.0, -7.5)
PLUME, DRIFT, VEIL = 6600, 250, 60
"""Numbers of particles: of the plume over the drum, of drifting smoke, and of a thin veil."""
CONCRETE = Material(albedo=(0.18, 0.175, 0.16), specular=0.0)
JOINTS = Material(albedo=(0.15, 0.145, 0.14), specular=0.0)
BRICK = Material(albedo=(0.17, 0.068, 0.042), specular=0.0)
FRAME = Material(albedo=(0.13, 0.20, 0.20), specular=0.0)
INSIDE = Material(albedo=(0.12, 0.105, 0.085), specular=0.0)
WOOD = Material(albedo=(0.28, 0.18, 0.09), specular=0.0)
RUST = Material(albedo=(0.35, 0.13, 0.06), specular=0.0)
STEEL = Material(albedo=(0.26, 0.27, 0.28), specular=0.0)
RUBBER = Material(albedo=(0.035, 0.035, 0.04), specular=0.0)
WIRE: RGB = (0.20, 0.205, 0.21)
GLASS = Material(coverage=1.0, transmission=(0.82, 0.82, 0.82), specular=0.05, roughness=0.0)
PANE = Material(coverage=1.0, transmission=(0.74, 0.74, 0.74), specular=0.06, roughness=0.0)
VEHICLES: tuple[tuple[str, Shape, Vector, float, RGB], ...] = (  # place, turn, paint
    ("van", VAN, (-2.85, 0.0, -6.6), 12.0, (0.10, 0.20, 0.25)),
    ("sedan", SEDAN, (2.75, 0.0, -6.5), -162.0, (0.24, 0.03, 0.022)),
)
# Middle and half axes of each bush, and its number of twigs.
BUSHES: tuple[tuple[Vector, Vector, int], ...] = (
    ((2.55, 0.35, -4.1), (0.75, 0.75, 0.35), 80),
    ((-3.1, 0.25, -4.2), (0.8, 0.6, 0.3), 60),
    ((4.4, 1.2, -8.2), (0.9, 1.5, 0.9), 110),
    ((-5.2, 1.5, -9.6), (1.0, 1.9, 0.9), 130),
    ((1.9, 2.75, -3.9), (0.85, 0.35, 0.3), 55),
)
GREEN: RGB = (0.13, 0.22, 0.045)
SHADES: tuple[RGB, ...] = ((0.35, 0.5, 0.5), (1.0, 1.0, 1.0))
WINDOWS = ((-3.9, 1.5), (-1.2, 1.5), (1.5, 1.5), (4.2, 1.5))  # middle and half width, meters
SILL, HEAD, EAVES = 0.95, 3.1, 4.2


def build(*, name: str, detail: float, alpha: float, seed: int) -> Scene:
    """Return the yard, the vehicles, the plants and the smoke."""
    random = [np.random.default_rng([seed, index]) for index in range(3)]
    even, odd = checkers((0, 0, -10), (20, 0, 0), (0, 0, -14), 20, 14)
    objects = (
        Object("concrete", even, CONCRETE, casts=False),
        Object("more concrete", odd, JOINTS, casts=False),
        *_workshop(),
        *_clutter(detail),
        *_parked(detail),
        *_foliage(random[0], detail),
        *_smoke(random[1], detail, alpha),
        *_fence(detail),
    )
    sun = DirectionalLight(opposite(SUNWARD), SUN)
    return Scene(name, CAMERA, objects, lights=(sun, gradient_sky(SKY)), views=VIEWS)


@dataclass(frozen=True, eq=False)
class _Bank:
    """Particles of one coverage: middles, (n, 3), and half their sides, (n,), in meters."""

    name: str
    centers: Floats
    radii: Floats
    material: Material


def _smoke(random: np.random.Generator, detail: float, alpha: float) -> Iterator[Object]:
    """Yield the smoke, which is darker where other smoke is toward the sun."""
    banks = [*_banks(random, detail, alpha)]
    sections = []
    for bank in banks:
        assert isinstance(bank.material.coverage, Texture)
        covers = np.minimum(bank.material.coverage.texels.astype(np.float64), 0.999)
        thickness = -np.log1p(-covers).mean()
        sections.append(thickness * (2 * bank.radii) ** 2)
    centers = np.concatenate([bank.centers for bank in banks])
    cloud = density(centers, np.concatenate(sections), LOW, HIGH, CELL).smoothed(CELL)
    depth = cloud.integral_toward(SUNWARD)
    for bank in banks:
        lit = 0.3 + 0.7 * np.exp(-0.7 * depth.at(bank.centers))
        mesh = sprites(random, bank.centers, bank.radii, SUNWARD)
        shaded = replace(mesh, albedos=np.repeat(lit[:, None], 3, axis=1))
        yield Object(bank.name, shaded, bank.material, particles=True, receives_shadows=False)


def _banks(random: np.random.Generator, detail: float, alpha: float) -> Iterator[_Bank]:
    """Yield the plume over the drum, the smoke that drifts away, and a veil over the yard."""
    nominal, foot = PLUME, np.add(DRUM, (0, 0.95, 0))
    count = copies(nominal, detail)
    age = random.random(count) ** 1.35
    path = np.stack([-2.5 * age**1.7, 2.5 * age**0.8, -0.2 * age**1.5], axis=1)
    swirl = (0.06 + 0.22 * age) * [np.sin(9 * age), 0 * age, np.cos(9 * age)]
    spread = (0.05 + 0.18 * age)[:, None] * random.normal(size=(count, 3))
    radii = (0.065 + 0.17 * age) * random.uniform(0.8, 1.2, count)
    puffs = smoke(alpha, ALBEDO, nominal, count)
    yield _Bank("plume", foot + path + swirl.T + spread, radii, puffs)
    count = copies(DRIFT, detail)
    along = random.random(count)
    path = np.stack([-2.2 - 2.4 * along, 3.1 - 1.3 * along, -0.2 + 2.9 * along], axis=1)
    spread = (0.25 + 0.5 * along)[:, None] * random.normal(size=(count, 3)) * [1, 0.6, 1]
    centers = np.multiply(DRUM, (1, 0, 1)) + path + spread
    radii = np.minimum(0.60 * random.uniform(0.75, 1.25, count), 0.9 * centers[:, 1])
    yield _Bank("drift", centers, radii, smoke(min(3.2 * alpha, 1.0), ALBEDO, DRIFT, count))
    count = copies(VEIL, detail)
    height, across = 0.9 + 1.5 * random.random(count) ** 2, random.uniform(-4.6, 4.6, count)
    centers = np.stack([across, height, random.uniform(-14.5, -5.4, count)], axis=1)
    radii = np.minimum(1.1 * random.uniform(0.75, 1.25, count), 0.9 * height)
    yield _Bank("veil", centers, radii, smoke(alpha, ALBEDO, VEIL, count))


def _parked(detail: float) -> Iterator[Object]:
    """Yield the vehicles."""
    for label, shape, place, turn, paint in VEHICLES:
        parts = vehicle(shape, detail).transformed(
            translation(place) @ rotation((0, 1, 0), math.radians(turn))
        )
        yield Object(label, parts.paint, Material(albedo=paint, specular=0.02, roughness=0.25))
        yield Object(f"tires of the {label}", parts.rubber, RUBBER)
        yield Object(f"metal of the {label}", parts.metal, STEEL)
        yield Object(f"windows of the {label}", parts.glass, GLASS)


def _workshop() -> Iterator[Object]:
    """Yield the walls with openings, mullions, panes, and the room behind them."""
    edges = [-8.0, *itertools.chain(*((x - half, x + half) for x, half in WINDOWS)), 8.0]
    piers = [
        slab((a, -0.05, WALL - 0.3), (b, HEAD, WALL))
        for a, b in zip(edges[::2], edges[1::2], strict=True)
    ]
    walls = [
        *piers,
        slab((-8.0, HEAD, WALL - 0.3), (8.0, EAVES, WALL)),
        *(
            slab((x - half, -0.05, WALL - 0.28), (x + half, SILL, WALL - 0.02))
            for x, half in WINDOWS
        ),
    ]
    yield Object("walls", merge(walls), BRICK)
    room = [
        quad((0, EAVES / 2, BACK), (8, 0, 0), (0, EAVES / 2, 0)),
        slab((-3.2, -0.02, -14.6), (-1.6, 1.9, -14.0)),
        slab((0.9, -0.02, -15.0), (2.4, 1.4, -14.1)),
        slab((3.4, -0.02, -14.4), (4.3, 2.3, -13.6)),
    ]
    yield Object("room", merge(room), INSIDE)
    bars, panes = [], []
    for x, half in WINDOWS:
        for part in np.linspace(-1, 1, 6):
            bars.append(
                box(
                    (x + part * (half - 0.03), (SILL + HEAD) / 2, WALL - 0.15),
                    (0.06, HEAD - SILL, 0.06),
                )
            )
        for level in np.linspace(SILL + 0.03, HEAD - 0.03, 4):
            bars.append(box((x, level, WALL - 0.15), (2 * half, 0.058, 0.055)))
        panes.append(
            quad((x, (SILL + HEAD) / 2, WALL - 0.152), (half, 0, 0), (0, (HEAD - SILL) / 2, 0))
        )
    yield Object("mullions", merge(bars), FRAME)
    yield Object("workshop windows", merge(panes), PANE)


def _clutter(detail: float) -> Iterator[Object]:
    """Yield the burning drum, another one, and crates."""
    slices = divisions(28, detail, 8)
    outline = [
        (0.0, 0.06),
        (0.27, 0.05),
        (0.27, 0.88),
        (0.285, 0.90),
        (0.29, 0.6),
        (0.30, 0.58),
        (0.29, 0.56),
    ]
    outline += [(0.29, 0.32), (0.30, 0.30), (0.29, 0.28), (0.285, -0.02)]
    shell = lathe(outline[::-1], slices)
    spots = [DRUM, (0.85, 0.0, -9.2), (1.5, 0.0, -9.4)]
    yield Object("drums", repeated(shell, spots), RUST)
    crates = [box((-1.3, 0.33, -9.7), (0.7, 0.7, 0.7)), box((-2.1, 0.28, -9.9), (0.6, 0.6, 0.6))]
    crates += [box((4.6, 0.43, -9.8), (0.9, 0.9, 0.9)), box((4.5, 1.2, -9.9), (0.6, 0.6, 0.6))]
    yield Object("crates", merge(crates), WOOD)


def _foliage(random: np.random.Generator, detail: float) -> Iterator[Object]:
    """Yield the bushes as one object, whose twigs are in random order."""
    frames: list[Floats] = []
    for center, half, number in BUSHES:
        count = copies(number, detail)
        outward = random_directions(random, count)
        reach = 0.3 + 0.7 * random.random((count, 1)) ** 0.6
        feet = np.asarray(center) + np.asarray(half) * outward * reach
        feet[:, 1] = np.maximum(feet[:, 1], 0.30)
        tips = outward + 0.6 * random.normal(size=(count, 3)) + [0, 0.5, 0]
        size = random.uniform(0.22, 0.34, (count, 1)) * max(1.0, number / count) ** 0.5
        frames.append(card_frames(feet, tips, random.normal(size=(count, 3)), size, size))
    rows = random.permutation(np.concatenate(frames))
    cards = scatter(quad((0, 0, 0), (1, 0, 0), (0, 1, 0)), rows)
    shades = tint(random.random(len(rows)).repeat(len(cards.positions) // len(rows)), SHADES)
    spray = twig(random, 130, (0.10, 0.15))
    green = Texture(np.clip(spray.color.texels * np.asarray(GREEN, np.float32), 0, 1))
    leaves = Material(coverage=spray.coverage, albedo=green, specular=0.0)
    yield Object("bushes", replace(cards, albedo=shades.astype(np.float32)), leaves)


def _fence(detail: float) -> Iterator[Object]:
    """Yield posts with a rail, and panels of wire."""
    spots = np.array([-4.4, -2.2, 0.0, 2.2, 4.4])
    feet = np.stack([spots, 0 * spots - 0.05, 0 * spots + FENCE - 0.04], axis=1)
    sides = divisions(10, detail, 5)
    posts = tubes(straight(feet, np.add(feet, (0, 2.2, 0))), 0.03, sides)
    rail = tubes(straight([[-4.6, 2.12, FENCE - 0.04]], [[4.6, 2.12, FENCE - 0.04]]), 0.022, sides)
    yield Object("posts", merge([posts, rail]), STEEL)
    panel = quad((0.55, 0.525, FENCE), (0.55, 0, 0), (0, 0.525, 0))
    places = [(x, y, 0.0) for x in np.arange(-4.4, 4.4 - 0.1, 1.1) for y in (0.02, 1.07)]
    panels = repeated(panel, places)
    wire = Material(coverage=mesh_fence(), albedo=WIRE, specular=0.0)
    yield Object("fence", panels, wire)

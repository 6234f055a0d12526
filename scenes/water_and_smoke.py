"""Smoke and panes of colored glass behind an aquarium and a glass of water.

Stands for no single figure: it joins the multi-layer refraction of figure 1 (center) with the smoke
and glass of figure 23 of McGuire & Mara 2017, "Phenomenological Transparency", and asks what
engines are asked for: transparent surfaces seen through refracting water.

Parameters
----------
detail : float
    Factor on the number of particles and triangles. The optical thickness stays the same.
alpha : float
    Coverage at the middle of a particle of smoke at detail 1, in [0, 1].
seed : int
    Seed of the particles, the weeds and the pebbles.
near : float
    Distance of the near plane from the camera, m. The table begins at 0.42 m in the picture.

Smoke from a burner drifts behind the tank, between the panes. One sees it above the water, beside
the tank, and through the water, displaced; the tumbler shows all of it upside down. A method that
refracts only the opaque picture loses smoke, panes and weeds in the water, and one that sorts by
object must draw water, walls, weeds and smoke one inside the other.

Water touches its container: it reaches into the walls of the glass, which has the higher
`Object.priority`, so that light crosses one interface of both, without a film of air. Lengths are
decimeters and as in life: the tank is 38 cm wide.
"""

from __future__ import annotations

import math

import numpy as np

from oitbench.modeling.detail import PARTICLE_DETAIL, copies, divisions, enlargement
from oitbench.modeling.mesh import lathe, quad, slab
from oitbench.modeling.particles import smoke, sprites
from oitbench.modeling.patterns import checkers
from oitbench.modeling.placement import (
    frames,
    merge,
    random_directions,
    scatter,
    transform,
    translation,
)
from oitbench.modeling.profiles import smooth_curve
from oitbench.modeling.props.glassware import tank, tumbler
from oitbench.modeling.props.leaves import card_frames, lance, leaf_card, leaf_mask
from oitbench.modeling.solids import loft
from oitbench.modeling.surroundings import Window, room
from oitbench.modeling.sweeps import cylinder
from oitbench.parameters import Parameter
from oitbench.scene import (
    RGB,
    Camera,
    EnvironmentLight,
    Floats,
    Material,
    Mesh,
    Object,
    Scene,
    SpotLight,
    Vector,
)

subject = "smoke and glass"
quick = False
near = 0.38
parameters = {
    "detail": PARTICLE_DETAIL,
    "alpha": Parameter(
        0.15, low=0.0, high=1.0, help="coverage at the middle of a particle at detail 1"
    ),
    "seed": Parameter(1, low=0, help="seed of particles, weeds and pebbles"),
}

PARTICLES, WEEDS, PEBBLES = 320, 80, 140
FOOT = 0.01  # decimeters between glass and table
# The tank: its middle on the table (x, z), outer size, wall, and height of the water.
TANK: tuple[float, float] = (-0.45, -0.2)
TANK_SIZE: Vector = (3.8, 2.6, 2.0)
WALL, WATER_LEVEL, SAND = 0.08, 2.05, 0.24
REACH = 0.03  # depth by which water reaches into glass
TUMBLER: tuple[float, float] = (1.95, 1.25)
GLASS = Material(transmission=(0.97, 0.97, 0.97), index=1.5, roughness=0.0, solid=True)
WATER = Material(transmission=(0.985, 0.985, 0.985), index=1.33, roughness=0.0, solid=True)
# Middle of the lower edge and half width and height of each pane, its turn and its transmission.
PANES: tuple[tuple[str, Vector, float, float, float, RGB], ...] = (
    ("amber pane", (-1.55, 0.05, -2.5), 0.75, 3.5, 16.0, (0.95, 0.55, 0.08)),
    ("teal pane", (1.0, 0.05, -3.1), 0.85, 3.0, -12.0, (0.08, 0.62, 0.66)),
)
# Corners of the path of the smoke from the burner, and its radius at both ends.
PLUME = (
    (1.9, 0.75, -1.7), (1.7, 1.6, -1.9), (0.5, 1.2, -2.3), (-0.8, 1.3, -3.0), (-1.9, 2.1, -3.1),
    (-2.2, 2.9, -3.1),
)  # fmt: skip
SPREAD = (0.10, 0.65)
PARTICLE_RADII = (0.30, 0.62)
# Middle, length and turn of each fish.
FISH: tuple[tuple[Vector, float, float], ...] = (
    ((-1.05, 1.30, 0.10), 0.78, 0.4),
    ((0.25, 0.92, -0.25), 0.66, 2.9),
    ((-0.35, 1.62, -0.45), 0.52, -0.2),
)
# Back (x, y), front (x, y) and half the width of rings of a fish from the nose to the tail.
_BODY = np.array(
    [
        (0.50, 0.00, 0.50, 0.00, 0.00), (0.46, -0.05, 0.46, 0.05, 0.05),
        (0.32, -0.15, 0.32, 0.16, 0.10), (0.12, -0.20, 0.12, 0.22, 0.12),
        (-0.10, -0.15, -0.10, 0.17, 0.09), (-0.26, -0.06, -0.26, 0.07, 0.04),
        (-0.32, -0.05, -0.32, 0.06, 0.025), (-0.48, -0.18, -0.48, 0.18, 0.012),
        (-0.50, -0.19, -0.50, 0.19, 0.008), (-0.44, 0.0, -0.44, 0.0, 0.0),
    ]
)  # fmt: skip
GOLD = Material(albedo=(0.85, 0.26, 0.03), specular=0.0)
WEED: RGB = (0.10, 0.34, 0.06)
OAK, DARK_OAK = (
    Material(albedo=albedo, specular=0.0) for albedo in ((0.46, 0.29, 0.15), (0.30, 0.17, 0.08))
)
BRASS = Material(albedo=(0.36, 0.24, 0.08), specular=0.0)
SANDY = Material(albedo=(0.62, 0.52, 0.36), specular=0.0)
STONES = Material(albedo=(0.30, 0.29, 0.28), specular=0.0)
PLASTER = Material(albedo=(0.52, 0.54, 0.50), specular=0.0)
STRIPES = Material(albedo=(0.30, 0.36, 0.37), specular=0.0)
STRAW = Material(albedo=(0.80, 0.10, 0.09), specular=0.0)
LAMP = SpotLight(
    position=(-5.0, 8.5, -2.6),
    target=(0.1, 0.2, 0.0),
    intensity=(3.4, 3.25, 2.95),
    angle=math.radians(60),
)
# From below the water's surface, which mirrors what is in the water.
LOW_VIEW = Camera(
    position=(0.9, 0.95, 7.4), target=(0.1, 1.35, -0.4), fov_y=math.radians(33), near=3.8
)


def build(*, name: str, detail: float, alpha: float, seed: int) -> Scene:
    """Return the table, the tank with all that is in the water, the smoke and the panes."""
    streams = [np.random.default_rng([seed, stream]) for stream in range(3)]
    return Scene(
        name=name,
        camera=Camera(position=(0.75, 2.6, 7.4), target=(0.02, 1.25, -0.4), fov_y=math.radians(33)),
        views={"low": LOW_VIEW},
        objects=(
            *_room(),
            *_panes(),
            *_smoke(streams[0], alpha, detail),
            *_tank(streams[1], streams[2], detail),
            *_tumbler(detail),
        ),
        lights=(LAMP, _daylight()),
        meters_per_unit=0.1,
        full_samples=104,
    )


def _room() -> tuple[Object, ...]:
    """Return the planks of the table and a papered wall behind it."""
    planks = checkers((0, 0, -1.5), (9.0, 0, 0), (0, 0, -5.5), 18, 1)
    paper = checkers((0, 4.0, -7.0), (13.0, 0, 0), (0, 7.0, 0), 40, 1)
    return (
        Object("table", planks[0], OAK, casts=False),
        Object("dark planks", planks[1], DARK_OAK, casts=False),
        Object("wall", paper[0], PLASTER, casts=False),
        Object("stripes", paper[1], STRIPES, casts=False),
    )


def _panes() -> tuple[Object, ...]:
    """Return panes that stand on the table, each a thin sheet."""
    objects = []
    for label, (x, y, z), half, height, turn, transmission in PANES:
        angle = math.radians(turn)
        right: Vector = (half * math.cos(angle), 0.0, -half * math.sin(angle))
        sheet = quad((x, y + height / 2, z), right, (0, height / 2, 0))
        glass = Material(transmission=transmission, index=1.5, roughness=0.0)
        objects.append(Object(label, sheet, glass))
    return tuple(objects)


def _smoke(random: np.random.Generator, alpha: float, detail: float) -> tuple[Object, ...]:
    """Return the burner, and the smoke that drifts from it behind the tank."""
    count = copies(PARTICLES, detail)
    path: Floats = smooth_curve(PLUME, 200)
    along = random.random(count) ** 0.8
    middle = path[(along * (len(path) - 1)).astype(int)]
    reach = np.interp(along, [0, 1], SPREAD)[:, None]
    away = reach * random_directions(random, count) * random.random((count, 1)) ** 0.5
    radii = np.interp(along, [0, 1], PARTICLE_RADII) * random.uniform(0.8, 1.2, count)
    wreaths = sprites(random, middle + away, radii, LAMP.position)
    bowl = [(0, 0), (0.30, 0), (0.30, 0.05), (0.10, 0.12), (0.10, 0.22), (0.36, 0.42), (0.40, 0.62)]
    bowl += [(0.36, 0.62), (0.20, 0.40), (0, 0.36)]
    profile = smooth_curve(bowl, divisions(40, detail, 12))
    burner = transform(
        lathe(profile, divisions(40, detail, 10)), translation((PLUME[0][0], 0, PLUME[0][2]))
    )
    vapor = smoke(alpha, 0.92, PARTICLES, count)
    return Object("burner", burner, BRASS), Object("smoke", wreaths, vapor, particles=True)


def _tank(
    weeds: np.random.Generator, stones: np.random.Generator, detail: float
) -> tuple[Object, ...]:
    """Return the tank, the water in it, and sand, pebbles, weeds and fish in the water."""
    place = translation((TANK[0], FOOT, TANK[1]))
    half = np.array([TANK_SIZE[0] / 2 - WALL, TANK_SIZE[2] / 2 - WALL])
    wide, deep = half + REACH
    water = slab((-wide, WALL - REACH, -deep), (wide, WATER_LEVEL, deep))
    sand = slab(
        (-half[0] + 0.01, WALL + 0.004, -half[1] + 0.01), (half[0] - 0.01, SAND, half[1] - 0.01)
    )
    fish = []
    for middle, length, turn in FISH:
        body = loft(_BODY, divisions(20, detail, 8))
        aim = np.array([[math.cos(turn), 0.0, -math.sin(turn)]])
        placed = frames([middle], length * aim, np.array([[0.0, length, 0.0]]))
        fish.append(scatter(body, placed))
    objects = (
        ("tank", tank(TANK_SIZE, WALL), GLASS, 1),
        (
            "weeds",
            _weeds(weeds, half, detail),
            Material(coverage=leaf_mask(lance), albedo=WEED, binary_coverage=True),
            0,
        ),
        ("water", water, WATER, 0),
        ("sand", sand, SANDY, 0),
        ("pebbles", _pebbles(stones, half, detail), STONES, 0),
        ("fish", merge(fish), GOLD, 0),
    )
    return tuple(
        Object(label, transform(mesh, place), material, priority=priority)
        for label, mesh, material, priority in objects
    )


def _weeds(random: np.random.Generator, half: Floats, detail: float) -> Mesh:
    """Return blades of weed that rise from the sand in three clumps, below the water's surface."""
    count = copies(WEEDS, detail)
    clump = random.choice(3, count, p=[0.45, 0.35, 0.2])
    foot = np.array([(-0.72, -0.3), (0.62, -0.35), (0.85, 0.45)])[clump] * half
    foot = np.clip(foot + 0.18 * random.normal(size=(count, 2)), 0.45 - half, half - 0.45)
    length = random.uniform(0.30, 0.78, (count, 1))
    lean = np.concatenate(
        [
            0.24 * random.uniform(-1, 1, (count, 1)),
            np.ones((count, 1)),
            0.24 * random.uniform(-1, 1, (count, 1)),
        ],
        axis=1,
    )
    lean /= np.linalg.norm(lean, axis=1, keepdims=True)
    base = np.stack([foot[:, 0], np.full(count, SAND - 0.02), foot[:, 1]], axis=1)
    width = 0.07 * enlargement(WEEDS, count) * np.ones((count, 1))
    return scatter(
        leaf_card(),
        card_frames(base + lean * length, lean, random.normal(size=(count, 3)), width, length),
    )


def _pebbles(random: np.random.Generator, half: Floats, detail: float) -> Mesh:
    """Return flat pebbles on the sand."""
    count = PEBBLES
    size = random.uniform(0.04, 0.11, (count, 1))
    at = random.uniform(-1, 1, (count, 2)) * (half - 0.13)
    centers = np.stack([at[:, 0], np.full(count, SAND + 0.01), at[:, 1]], axis=1)
    turn = random.uniform(0, 2 * math.pi, count)
    rights = size * np.stack([np.cos(turn), np.zeros(count), np.sin(turn)], axis=1)
    slices = divisions(8, detail, 5)
    line = np.linspace(0, math.pi, max(4, slices // 2 + 1))
    stone = lathe(np.stack([np.sin(line).round(12), -np.cos(line)], axis=1), slices)
    return scatter(stone, frames(centers, rights, size * [0.0, 0.55, 0.0]))


def _tumbler(detail: float) -> tuple[Object, ...]:
    """Return a glass of water with a straw."""
    vessel = tumbler(0.34, 0.42, 1.15, 0.04, 0.10)
    place = translation((TUMBLER[0], FOOT, TUMBLER[1]))
    straw = cylinder(
        (-0.24, 0.13, 0.05), (0.42, 1.62, -0.1), 0.035, 0.008, divisions(14, detail, 6)
    )
    return (
        Object("straw", transform(straw, place), STRAW),
        Object(
            "water of the tumbler", transform(vessel.filling(0.82, -0.015, detail), place), WATER
        ),
        Object("tumbler", transform(vessel.glass(detail), place), GLASS, priority=1),
    )


def _daylight() -> EnvironmentLight:
    """Return a room with a window on the left, one on the right, and one behind the viewer."""
    windows = (
        Window(azimuth=-1.0, elevation=0.4, width=0.8, height=0.7, radiance=(3.0, 3.2, 3.5)),
        Window(azimuth=0.9, elevation=0.5, width=0.5, height=0.6, radiance=(2.0, 2.2, 2.5)),
        Window(azimuth=2.6, elevation=0.45, width=0.8, height=0.6, radiance=(2.2, 2.2, 2.2)),
    )
    return room((0.30, 0.31, 0.32), (0.26, 0.26, 0.25), (0.06, 0.05, 0.04), windows)

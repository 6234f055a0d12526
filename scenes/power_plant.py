"""A plant of thousands of pipes, vessels, beams and walkways, all of them partly transparent.

Stands for scene PWRPLANT in figures 7 and 9 and table 1 of Salvi et al. 2011, "Adaptive
Transparency", which is drawn with four samples per pixel.

Parameters
----------
detail : float
    Factor on the number of triangles. Below 1, there are fewer pipes, too.
alpha : float
    Coverage of pipes, in [0, 1]; vessels cover 0.6 times as much.
seed : int
    Seed of the routes of the pipes.
near : float
    Distance of the near plane from the camera, m. The frame begins at 31 m.

Long, thin parts cross in all directions, so that no order of objects, or even of triangles, is
right, and thin bright lines alias without several samples per pixel. Depth complexity is up to some
40. Light is baked in: a sun with highlights for the main camera, the sky, and less light between
the pipes and on the ground below.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import replace

import numpy as np

from oitbench.modeling.baking import Rig, diffuse, normals_of, with_radiance
from oitbench.modeling.detail import DETAIL, copies, divisions
from oitbench.modeling.mesh import grid, sphere, triangle_areas
from oitbench.modeling.placement import merge
from oitbench.modeling.props.piping import (
    beams,
    drum,
    flanges,
    grating,
    railing,
    rounded,
    vessel,
)
from oitbench.modeling.tubes import straight, tubes
from oitbench.modeling.voxels import Voxels, density
from oitbench.parameters import Parameter
from oitbench.scene import RGB, WHITE, Camera, Floats, Material, Mesh, Object, Scene, Texture, unit

subject = "CAD models"
quick = False
near = 26.0
crops = {"pipes@walkway": (0.4, 0.25, 0.35, 0.35)}
parameters = {
    "detail": DETAIL,
    "alpha": Parameter(0.38, low=0.0, high=1.0, help="coverage of pipes"),
    "seed": Parameter(1, low=0, help="seed of the routes of the pipes"),
}

CAMERA = Camera(position=(-23.0, 13.0, 38.0), target=(0.4, 7.0, 0.0), fov_y=math.radians(29))
VIEWS = {
    "elevation": Camera(position=(0.0, 8.5, 60.0), target=(0.0, 8.5, 0.0), height=21.0),
    "walkway": Camera(position=(-11.0, 9.7, 46.0), target=(1.0, 6.0, 0.0), fov_y=math.radians(16)),
}
SUN = Rig((-0.55, 0.75, 0.45), (1.05, 0.96, 0.80), (0.34, 0.38, 0.44), (0.16, 0.15, 0.14))
HAZE: RGB = (0.50, 0.60, 0.70)
CONCRETE: RGB = (0.46, 0.45, 0.43)
# The frame of steel: places of its columns and heights of its floors, meters.
COLUMNS = (np.arange(-12.0, 13.0, 4.0), np.arange(-8.0, 9.0, 4.0))
FLOORS = (4.0, 8.0, 12.0)
LOW, HIGH, CELL = (-19.0, 0.0, -13.0), (19.0, 20.0, 13.0), 0.5
BUNDLES, MOST_IN_BUNDLE, CORNERS = 105, 8, 5
RADII, SHARES = (0.02, 0.03, 0.045, 0.07, 0.13, 0.22), (0.26, 0.28, 0.22, 0.14, 0.07, 0.03)
# Colors of the pipes by what flows in them: steam, water, air, gas, oil, fire water.
PAINTS: tuple[tuple[str, RGB, float], ...] = (
    ("steam", (0.62, 0.64, 0.66), 0.30),
    ("water", (0.10, 0.42, 0.22), 0.20),
    ("air", (0.16, 0.40, 0.68), 0.14),
    ("gas", (0.85, 0.58, 0.08), 0.16),
    ("oil", (0.42, 0.22, 0.10), 0.12),
    ("fire", (0.75, 0.10, 0.06), 0.08),
)
STEEL: RGB = (0.36, 0.42, 0.46)
RAIL: RGB = (0.88, 0.68, 0.08)
SILVER: RGB = (0.62, 0.60, 0.56)


def build(*, name: str, detail: float, alpha: float, seed: int) -> Scene:
    """Return the ground, and the parts of the plant by their kind."""
    random = np.random.default_rng(seed)
    parts = [*_pipes(random, detail), *_vessels(detail), *_steel(detail)]
    light = _Light([mesh for _, mesh, _, _ in parts])
    objects = [Object("ground", light.ground(_ground(detail)), Material(emission=WHITE))]
    for label, mesh, color, share in parts:
        shaded = light.shaded(mesh, color)
        if label == "walkways":
            cover: float | Texture = grating()
        else:
            cover, shaded = _shell(shaded, min(0.95, alpha * share))
        objects.append(Object(label, shaded, Material(coverage=cover, emission=WHITE)))
    return Scene(name, CAMERA, tuple(objects), background=HAZE, views=VIEWS)


def _shell(mesh: Mesh, alpha: float) -> tuple[float, Mesh]:
    """Return the largest coverage, and the mesh with its factors, of a shell of coverage `alpha`.

    A shell is crossed at a slant where it curves away, and covers 1 − (1 − alpha)^(1/cos) there.
    """
    to_eye = unit(np.asarray(CAMERA.position) - mesh.positions)
    cosine = np.maximum(np.abs((normals_of(mesh) * to_eye).sum(axis=1)), 0.2)
    covers = 1 - (1 - alpha) ** (1 / cosine)
    most = float(covers.max())
    factors = covers / max(most, 1e-9)
    return most, replace(mesh, coverage=factors.astype(np.float32))


Part = tuple[str, Mesh, RGB, float]
"""Name, mesh, albedo, and coverage in units of `alpha`."""


def _pipes(random: np.random.Generator, detail: float) -> list[Part]:
    """Return pipes in bundles, which turn only at right angles, one part for each paint."""
    sides = divisions(9, detail**0.5, 4)
    chances = np.array([share for _, _, share in PAINTS])
    found: dict[int, list[tuple[Floats, float]]] = {index: [] for index in range(len(PAINTS))}
    for _ in range(copies(BUNDLES, min(detail, 1.0))):
        paint = int(random.choice(len(PAINTS), p=chances / chances.sum()))
        radius = float(random.choice(RADII, p=SHARES))
        route = _route(random)
        gap = 2.0 * radius + 0.07
        for index in range(random.integers(2, MOST_IN_BUNDLE + 1)):
            found[paint].append((route + index * gap, radius))
    parts: list[Part] = []
    for index, (label, color, _) in enumerate(PAINTS):
        if not found[index]:
            continue
        corners = np.array([route for route, _ in found[index]])
        radii = np.array([radius for _, radius in found[index]])
        curves = rounded(corners, 0.35)
        joints = random.random((len(corners), CORNERS - 1, 1))
        places = corners[:, :-1] + (0.25 + 0.5 * joints) * np.diff(corners, axis=1)
        ways = unit(np.diff(corners, axis=1)).reshape(-1, 3)
        rings = flanges(places.reshape(-1, 3), ways, radii.repeat(CORNERS - 1), sides)
        parts.append(
            (f"{label} pipes", merge([tubes(curves, radii[:, None], sides), rings]), color, 1.0)
        )
    return parts


def _route(random: np.random.Generator) -> Floats:
    """Return the corners of a pipe that runs along the floors and climbs at the columns."""
    heights = np.array(
        [0.5, *(floor + 0.35 for floor in FLOORS), *(floor - 0.9 for floor in FLOORS)]
    )
    place = np.array([random.uniform(-13, 12), random.choice(heights), random.uniform(-8.5, 7.5)])
    place[1] += random.uniform(-0.2, 0.5)
    corners = [place]
    axis = int(random.choice([0, 0, 2]))
    for _ in range(CORNERS - 1):
        following = corners[-1].copy()
        if axis == 1:
            following[1] = random.choice(heights) + random.uniform(-0.2, 0.5)
            if abs(following[1] - corners[-1][1]) < 1.0:
                following[1] = corners[-1][1] + (1.7 if corners[-1][1] < 6 else -1.7)
        else:
            span = 14.0 if axis == 0 else 8.5
            step = random.uniform(1.5, 9.0 if axis == 0 else 5.0) * random.choice([-1, 1])
            if abs(following[axis] + step) > span:
                step = -step
            following[axis] += step
        corners.append(following)
        axis = int(random.choice([other for other in range(3) if other != axis]))
    return np.array(corners)


def _vessels(detail: float) -> list[Part]:
    """Return columns, tanks, drums and a sphere on legs."""
    upright = (
        ((-9.5, 0.3, 5.6), 1.2, 16.0), ((-6.0, 0.3, 5.9), 0.85, 13.5),
        ((9.8, 0.3, -5.5), 1.4, 16.8),
        ((1.8, 0.3, 6.0), 1.5, 6.2), ((5.6, 0.3, 6.2), 1.2, 4.8), ((-2.2, 4.3, -2.0), 1.2, 6.8),
        ((6.0, 4.3, -2.0), 1.25, 5.5), ((14.8, 0.2, -2.5), 2.3, 7.0), ((15.2, 0.2, 4.2), 2.3, 5.6),
    )  # fmt: skip
    lying = (
        ((-2.0, 1.5, 2.0), 0.9, 6.5), ((5.5, 9.4, 2.0), 1.0, 7.0), ((-7.0, 9.3, -2.0), 0.9, 6.0),
        ((2.0, 13.3, -5.5), 0.8, 8.0),
    )  # fmt: skip
    vessels = [vessel(*item, detail) for item in upright]
    vessels += [drum(*item, detail, (1, 0, 0)) for item in lying]
    vessels.append(
        sphere((-15.0, 4.4, -3.0), 3.2, divisions(40, detail, 12), divisions(24, detail, 8))
    )
    around = np.linspace(0, 2 * math.pi, 9)[:-1]
    feet = np.stack([-15 + 2.9 * np.cos(around), 0 * around, -3 + 2.9 * np.sin(around)], axis=1)
    legs = tubes(straight(feet, np.add(feet, (0, 4.6, 0))), 0.16, divisions(8, detail, 5))
    return [("vessels", merge(vessels), SILVER, 0.60), ("legs", legs, SILVER, 1.0)]


def _steel(detail: float) -> list[Part]:
    """Return the frame, its bracing, walkways and railings."""
    xs, zs = COLUMNS
    feet = np.array([(x, -0.1, z) for x in xs for z in zs])
    lengthwise = np.array([(xs[0] - 0.3, y - 0.15, z) for y in FLOORS for z in zs])
    across = np.array([(x, y - 0.22, zs[0] - 0.4) for y in FLOORS for x in xs])
    # Widths and heights differ, so that no two faces lie in one plane.
    frame = [
        beams(feet, np.add(feet, (0, FLOORS[-1] + 0.5, 0)), 0.24),
        beams(lengthwise, np.add(lengthwise, (xs[-1] - xs[0] + 0.6, 0, 0)), 0.20),
        beams(across, np.add(across, (0, 0, zs[-1] - zs[0] + 0.8)), 0.17),
    ]
    low = [(x, floor - 4, z) for x, floor, z in itertools.product(xs[::2], FLOORS, zs[::4])]
    bracing = [straight(np.array(low), np.add(low, (side * 4.0, 4.0, 0))) for side in (-1, 1)]
    bracing = [curves[np.abs(curves[:, 1, 0]) <= 12.0] for curves in bracing]
    decks, rails = [], []
    sides = divisions(5, detail**0.5, 3)
    for number, floor in enumerate(FLOORS):
        for x, z in itertools.product(xs[:-1] + 2, zs[:-1] + 2):
            if abs(z) > 3 or (int(x) // 4 + number) % 2:
                decks.append(grid((x, floor, z), (2, 0, 0), (0, 0, -2), 1, 1))
        loop = [(-12, floor, 8), (12, floor, 8), (12, floor, -8), (-12, floor, -8), (-12, floor, 8)]
        rails.append(railing(loop, sides))
    steps = np.linspace(0, 1, 17)[:-1]
    stairs = [
        grid((12.6, floor - 4 + 4 * s + 0.125, 7 - 5.0 * s), (0.5, 0, 0), (0, 0, -0.16))
        for floor in FLOORS
        for s in steps
    ]
    braces = tubes(np.concatenate(bracing), 0.08, divisions(7, detail**0.5, 4))
    return [
        ("frame", merge(frame), STEEL, 1.1),
        ("bracing", braces, STEEL, 1.1),
        ("walkways", merge([*decks, *stairs]), STEEL, 1.0),
        ("railings", merge(rails), RAIL, 1.6),
    ]


class _Light:
    """Sun and sky, less of it between the parts."""

    def __init__(self, meshes: list[Mesh]) -> None:
        spots, areas = [], []
        for mesh in meshes:
            spots.append(mesh.positions[mesh.triangles].mean(axis=1))
            areas.append(triangle_areas(mesh))
        parts = density(np.concatenate(spots), np.concatenate(areas), LOW, HIGH, CELL).smoothed(0.5)
        self._sun = parts.integral_toward(SUN.direction)
        self._up: Voxels = parts.integral_toward((0.0, 1.0, 0.1))

    def shaded(self, mesh: Mesh, color: RGB) -> Mesh:
        """Return a part with its light."""
        points, normals = mesh.positions, normals_of(mesh)
        to_eye = unit(np.asarray(CAMERA.position) - points)
        normals = np.where((normals * to_eye).sum(axis=1, keepdims=True) < 0, -normals, normals)
        lit = 0.25 + 0.75 * np.exp(-0.10 * self._sun.at(points))[:, None]
        open_sky = np.exp(-0.06 * self._up.at(points))[:, None]
        half = unit(SUN.direction + to_eye)
        gloss = np.maximum((normals * half).sum(axis=1, keepdims=True), 0) ** 40
        light = np.asarray(color) * diffuse(normals, SUN, lit, open_sky)
        return with_radiance(mesh, light + 0.35 * gloss * lit * np.asarray(SUN.key))

    def ground(self, mesh: Mesh) -> Mesh:
        """Return the ground, which fades into haze."""
        points = mesh.positions
        lit, up = (
            np.exp(-0.14 * part.at(np.add(points, (0, 0.3, 0))))[:, None]
            for part in (self._sun, self._up)
        )
        light = CONCRETE * diffuse(normals_of(mesh), SUN, lit, up)
        far = np.exp(-((np.hypot(points[:, 0], points[:, 2]) / 55) ** 2))[:, None]
        return with_radiance(mesh, np.asarray(HAZE) * (1 - far) + light * far)


def _ground(detail: float) -> Mesh:
    cells = divisions(90, detail, 16)
    plane = grid((0, 0, 0), (1, 0, 0), (0, 0, -1), cells, cells)
    reach = 30 + 370 * np.abs(plane.positions).max(axis=1, keepdims=True) ** 4
    return replace(plane, positions=plane.positions * reach)

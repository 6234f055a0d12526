"""What a scene needs and a file may lack: a camera that shows everything, lights and a ground."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from oitbench.importing.content import PointLight
from oitbench.importing.notes import Notes
from oitbench.modeling.mesh import quad
from oitbench.modeling.surroundings import gradient_sky
from oitbench.scene import (
    PENUMBRA,
    Camera,
    DirectionalLight,
    EnvironmentLight,
    Floats,
    Light,
    Material,
    Object,
    SpotLight,
    as_vector,
    unit,
)
from oitbench.scene.vectors import RGB

_FROM = unit(np.array([0.45, 0.4, 1.0]))
"""Direction from the middle of a scene to its camera: the front of glTF faces +z."""
_FOV = math.radians(40)
_MARGIN = 1.05
_NEAR = 0.4
"""Near plane over the distance of the nearest corner of the bounding box."""
_LOW, _FILLED = 0.05, 0.5
"""A scene has a ground if its lowest twentieth has faces upwards over half of its area."""
_GROUND_SIZE = 4.0
_GROUND = Material(albedo=(0.35, 0.34, 0.33), specular=0.0)
_SUN = DirectionalLight((-0.45, -1.0, -0.35), (1.8, 1.75, 1.7))
_ALL_ROUND = math.pi - 1e-3


def frame(low: Floats, high: Floats) -> Camera:
    """Return a camera that shows a whole bounding box, from the front, the right and above."""
    middle = (low + high) / 2
    camera = Camera(as_vector(middle + _FROM), as_vector(middle), fov_y=_FOV)
    across, up, back = camera.axes
    corners = _corners(low, high) - middle
    reach = np.maximum(np.abs(corners @ across), np.abs(corners @ up))
    distance = float((reach / math.tan(_FOV / 2) + corners @ back).max()) * _MARGIN
    nearest = distance - float((corners @ back).max())
    position = as_vector(middle + distance * _FROM)
    return replace(camera, position=position, near=max(_NEAR * nearest, 1e-3 * distance))


def aimed(camera: Camera, low: Floats, high: Floats) -> Camera:
    """Return a camera whose target is at the depth of the middle of a bounding box.

    A far plane behind everything becomes infinite.
    """
    middle = (low + high) / 2
    depth = float(camera.view_distance(middle))
    size = float(np.linalg.norm(high - low))
    distance = max(depth, camera.near, 1e-3 * size)
    ahead = -camera.axes[2]
    farthest = float(camera.view_distance(_corners(low, high)).max())
    hides = camera.far < farthest or camera.height is not None
    return replace(
        camera,
        target=as_vector(np.asarray(camera.position) + distance * ahead),
        far=camera.far if hides else math.inf,
    )


def ground(objects: Sequence[Object], low: Floats, high: Floats, always: bool) -> Object | None:
    """Return a ground below a bounding box; None if the objects have one, unless `always`."""
    if not always and _has_ground(objects, low, high):
        return None
    size = np.maximum(high - low, 1e-6 * float((high - low).max()))
    middle = (low + high) / 2
    half = _GROUND_SIZE / 2 * float(max(size[0], size[2], size[1] / 2))
    # A little lower, so that it coincides with no face of the objects.
    center = float(middle[0]), float(low[1] - 1e-3 * size.max()), float(middle[2])
    return Object("ground", quad(center, (half, 0, 0), (0, 0, -half)), _GROUND, casts=False)


def _has_ground(objects: Sequence[Object], low: Floats, high: Floats) -> bool:
    area, top = 0.0, low[1] + _LOW * (high[1] - low[1])
    for item in objects:
        mesh = item.mesh
        if not item.opaque or mesh.used_positions[:, 1].min() > top:
            continue
        a, b, c = (mesh.positions[column] for column in mesh.triangles.T)
        upward = np.cross(b - a, c - a)[:, 1] / 2
        area += float(upward[(np.maximum(np.maximum(a, b), c)[:, 1] <= top) & (upward > 0)].sum())
    width, _, depth = high - low
    return area >= _FILLED * float(width * depth) and area > 0


def sun() -> DirectionalLight:
    """Return the light of scenes that have none."""
    return _SUN


def sky() -> EnvironmentLight:
    """Return the surroundings of scenes that have none: a soft, nearly gray sky."""
    stops: list[tuple[float, RGB]] = [
        (-90, (0.12, 0.115, 0.11)), (-2, (0.25, 0.245, 0.24)), (2, (0.62, 0.65, 0.68)),
        (90, (0.34, 0.42, 0.52)),
    ]  # fmt: skip
    return gradient_sky(stops)


def spots(points: Sequence[PointLight], low: Floats, high: Floats, notes: Notes) -> list[SpotLight]:
    """Return spot lights that stand for lights that shine to all sides.

    One that is outside the bounding sphere becomes a spot that shines on all of it. One that is
    inside becomes two that shine up and down, and fade where they meet.
    """
    middle, radius = (low + high) / 2, float(np.linalg.norm(high - low)) / 2
    found = []
    for point in points:
        position = np.asarray(point.position)
        distance = float(np.linalg.norm(middle - position))
        half = math.asin(min(radius / distance, 1)) / (1 - PENUMBRA) if distance else math.pi
        if 2 * half < _ALL_ROUND:
            target = as_vector(middle)
            found.append(SpotLight(point.position, target, point.intensity, max(2 * half, 0.02)))
            continue
        notes.add("lights to all sides inside the scene shine up and down, and fade sideways")
        for side in (-1.0, 1.0):
            target = as_vector(position + np.array([0, side * max(radius, 1e-3), 0]))
            found.append(SpotLight(point.position, target, point.intensity, _ALL_ROUND))
    return found


def stops_for(lights: Sequence[Light], low: Floats, high: Floats, unit: float) -> float:
    """Return an exposure that suits the brightest light of a file, in whole stops.

    Files state lux and candela, of which a display can show neither. A white surface in the middle
    that faces the light then has a radiance from 0.5 to 1; nothing changes within a factor of 8.
    `unit` is the length of the scene's unit in meters.
    """
    middle, size = (low + high) / 2, float(np.linalg.norm(high - low)) * unit
    brightest = 0.0
    for light in lights:
        if isinstance(light, DirectionalLight):
            brightest = max(brightest, *light.irradiance)
        elif isinstance(light, SpotLight):
            apart = unit * float(np.linalg.norm(middle - np.asarray(light.position)))
            away = max(apart, 0.25 * size)
            brightest = max(brightest, *(part / away**2 for part in light.intensity))
    white = brightest / math.pi
    if white <= 0 or 1 / 8 <= white <= 8:
        return 0.0
    return float(np.clip(math.floor(-math.log2(white)), -100, 100))


def _corners(low: Floats, high: Floats) -> Floats:
    grid = np.stack(np.meshgrid(*zip(low, high, strict=True), indexing="ij"), axis=-1)
    return np.asarray(grid.reshape(-1, 3))

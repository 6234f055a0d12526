"""Scenes by name, their parts, and the directions in which the tests look at them."""

from __future__ import annotations

import math
from functools import cache

import numpy as np
import numpy.typing as npt

from oitbench.plugins import Collection
from oitbench.scene import Camera, DirectionalLight, Floats, Mesh, Object, Scene
from tests.meshes import count_hits, hits

COLLECTION = Collection.load()
ASPECT = 4 / 3
"""Width of the pictures over their height."""
SQUARE = (1 / ASPECT, 1.0)
"""Largest (x, y) of `seen` in a square picture."""
LARGE = 2000
"""Number of triangles from which a mesh's corners stand for its surface."""


@cache
def build(text: str) -> Scene:
    """Return the scene in meters; the tests share it, so do not change its arrays."""
    return COLLECTION.build_scene(text).in_meters()


def with_detail(text: str, detail: float) -> str:
    """Return the label of a scene at another detail."""
    name, _, rest = text.partition("[")
    return f"{name}[detail={detail}{',' + rest if rest else ']'}"


def named(scene: Scene, name: str) -> Object:
    return next(item for item in scene.objects if item.name == name)


def starting(scene: Scene, prefix: str) -> list[Object]:
    """Return the objects whose names start with `prefix`."""
    return [item for item in scene.objects if item.name.startswith(prefix)]


def particles(scene: Scene) -> list[Object]:
    return [item for item in scene.objects if item.particles]


def center(item: Object) -> Floats:
    """Return the mean of the vertices, shape (3,)."""
    return np.asarray(item.mesh.positions.astype(np.float64).mean(axis=0))


def sprite_centers(item: Object) -> Floats:
    """Return the centers of an object's particles, shape (n, 3)."""
    return np.asarray(item.mesh.positions.astype(np.float64).reshape(-1, 4, 3).mean(axis=1))


def view_distances(scene: Scene, mesh: Mesh) -> Floats:
    return scene.camera.view_distance(mesh.positions)


def seen(camera: Camera, points: npt.ArrayLike) -> Floats:
    """Return (x, y) of points in the picture, shape (n, 2); the picture is [−1, 1]².

    NaN for points behind the camera.
    """
    x, y, back = camera.axes @ (np.asarray(points, np.float64) - np.asarray(camera.position)).T
    half = np.where(back < 0, -back, np.nan) * math.tan(camera.fov_y / 2)
    return np.stack([x / half / ASPECT, y / half], axis=1)


def view_rays(camera: Camera, side: int) -> Floats:
    """Return the directions through side × side points of the picture, shape (side², 3)."""
    line = (np.arange(side) + 0.5) / side * 2 - 1
    x, y = np.meshgrid(line, line)
    half = math.tan(camera.fov_y / 2)
    local = np.stack([x.ravel() * half * ASPECT, y.ravel() * half, -np.ones(side**2)], axis=1)
    return np.asarray(local @ camera.axes)


def nearest_visible(camera: Camera, mesh: Mesh) -> float:
    """Return the least view distance of a mesh within a picture of 16:9; infinity outside it."""
    half = math.tan(camera.fov_y / 2) * np.array([16 / 9, 1])
    local = (mesh.positions.astype(np.float64) - np.asarray(camera.position)) @ camera.axes.T
    inside = (np.abs(local[:, :2]) <= -local[:, 2:] * half).all(axis=1)
    distances = [np.inf, *-local[inside, 2]]
    if len(mesh.triangles) < LARGE:
        # Corners of large triangles are outside the picture.
        line = np.linspace(-1, 1, 13)
        x, y = np.meshgrid(*(line[:, None] * half).T)
        rays = np.stack([x.ravel(), y.ravel(), -np.ones(x.size)], axis=1) @ camera.axes
        for ray in rays:
            distances += list(hits(mesh, camera.position, ray)[:1])
    return float(min(distances))


def toward_light(scene: Scene, point: npt.ArrayLike = (0.0, 0.0, 0.0)) -> Floats:
    """Return the unit vector from `point` to the scene's only directional or spot light."""
    (light,) = scene.beams
    if isinstance(light, DirectionalLight):
        toward = -np.asarray(light.direction, dtype=np.float64)
    else:
        toward = np.asarray(light.position) - np.asarray(point)
    return np.asarray(toward / np.linalg.norm(toward))


def shadow_on_ground(scene: Scene, item: Object) -> Floats:
    """Return where the shadow of the object's center falls on the plane y = 0, shape (3,)."""
    middle = center(item)
    toward = toward_light(scene, middle)
    return np.asarray(middle - toward * middle[1] / toward[1])


def layers_toward_light(scene: Scene, mesh: Mesh, points: Floats) -> npt.NDArray[np.int64]:
    """Return the number of triangles of `mesh` between each point and the directional light."""
    return count_hits(mesh, points, toward_light(scene))

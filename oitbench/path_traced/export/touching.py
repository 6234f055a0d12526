"""Refracting solids that touch: faces of two solids in one plane become a single interface.

A ray cannot tell equal faces apart, and would miss one of them. The faces of the solid of lower
priority are therefore moved a little into the other solid, where they are hidden (see
`optics.solids`). The faces of the solid of higher priority remain, and are the interface.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import numpy.typing as npt

from oitbench.scene import Floats, Mesh, Object, Scene
from oitbench.scene.coincidence import coplanar_pairs

SHIFT = 1e-5
"""Distance by which faces are moved, relative to their distance from the origin and the camera. It
is 16 times the step by which rays advance beyond a face."""
ROUNDS = 4
"""Faces beside those that are moved may then overlap with others, which are moved in turn."""

Numbers = npt.NDArray[np.int64]


def separated(scene: Scene) -> Scene:
    """Return `scene`, in meters, with refracting solids that touch no more, but overlap."""
    for _ in range(ROUNDS):
        found = _separated(scene)
        if found is scene:
            break
        scene = found
    return scene


def _separated(scene: Scene) -> Scene:
    solids = [item for item in scene.transparent if item.refracts]
    corners = [item.mesh.positions[item.mesh.triangles] for item in solids]
    if len(solids) < 2:
        return scene
    starts = np.cumsum([0, *map(len, corners)])
    triangles = np.concatenate(corners)
    owners = np.repeat(np.arange(len(solids)), np.diff(starts))
    one, other = coplanar_pairs(triangles, owners)
    if not len(one):
        return scene
    # Of equal priorities, the first solid fills the space.
    order = sorted(range(len(solids)), key=lambda number: (solids[number].priority, -number))
    rank = np.argsort(order)
    lower = rank[owners[one]] < rank[owners[other]]
    moved, fixed = np.where(lower, one, other), np.where(lower, other, one)
    a, b, c = triangles[fixed].swapaxes(0, 1)
    inward = np.cross(c - a, b - a)
    inward /= np.linalg.norm(inward, axis=1, keepdims=True)
    eye = np.asarray(scene.camera.position)
    settled = {}
    for number in np.unique(owners[moved]):
        mine = owners[moved] == number
        item = solids[number]
        mesh = _moved(item.mesh, moved[mine] - starts[number], inward[mine], eye)
        settled[item.name] = replace(item, mesh=mesh)
    objects: tuple[Object, ...] = tuple(settled.get(item.name, item) for item in scene.objects)
    return replace(scene, objects=objects)


def _moved(mesh: Mesh, triangles: Numbers, directions: Floats, eye: Floats) -> Mesh:
    """Return `mesh` with `triangles` moved, each along its unit vector in `directions`."""
    # Vertices at one place stay together.
    _, places = np.unique(mesh.positions, axis=0, return_inverse=True)
    places = places.reshape(-1)
    positions = mesh.positions.copy()
    touched = places[mesh.triangles[triangles]]
    for place in np.unique(touched):
        planes = np.unique(np.round(directions[(touched == place).any(axis=1)], 6), axis=0)
        here = places == place
        point = positions[here][0]
        step = SHIFT * max(np.abs(point).max(), float(np.linalg.norm(point - eye)))
        # The shortest way that leads by `step` into the other solid behind each of its planes.
        positions[here] += np.linalg.lstsq(planes, np.full(len(planes), step), rcond=None)[0]
    return replace(mesh, positions=positions)

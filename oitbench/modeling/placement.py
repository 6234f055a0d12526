"""Placing meshes: transforms, copies at many places, and merging several meshes into one."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from oitbench.scene import Array, Floats, Mesh, Vector, unit


def translation(offset: Vector) -> Floats:
    """Return the (4, 4) matrix of a translation in meters."""
    matrix = np.eye(4)
    matrix[:3, 3] = offset
    return matrix


def scaling(factors: Vector) -> Floats:
    """Return the (4, 4) matrix of a scaling along the coordinate axes."""
    return np.diag([*factors, 1.0])


def rotation(axis: Vector, angle: float) -> Floats:
    """Return the (4, 4) matrix of a right-handed rotation by `angle` radians about `axis`."""
    x, y, z = unit(np.asarray(axis, dtype=np.float64))
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    matrix = np.eye(4)
    matrix[:3, :3] += math.sin(angle) * cross + (1 - math.cos(angle)) * cross @ cross
    return matrix


def transform(mesh: Mesh, matrix: Floats) -> Mesh:
    """Return `mesh` under an affine (4, 4) matrix; raise `ValueError` if the matrix mirrors."""
    return scatter(mesh, matrix[None, :3])


def frames(centers: npt.ArrayLike, rights: npt.ArrayLike, ups: npt.ArrayLike) -> Floats:
    """Return affine frames for `scatter`.

    Parameters
    ----------
    centers : array, shape (k, 3) or (3,)
        Origins of the frames, meters.
    rights, ups : array, shape (k, 3)
        The frames' x and y axes. Their lengths scale the mesh; z is scaled as x is.

    Returns
    -------
    array, shape (k, 3, 4), float64
        The columns are the x axis, the y axis, the z axis along x × y, and the origin.
    """
    x, y = np.asarray(rights, dtype=np.float64), np.asarray(ups, dtype=np.float64)
    z = unit(np.cross(x, y)) * np.linalg.norm(x, axis=-1, keepdims=True)
    return np.stack([x, y, z, np.broadcast_to(np.asarray(centers), x.shape)], axis=-1)


def random_directions(random: np.random.Generator, count: int) -> Floats:
    """Return unit vectors, shape (count, 3), distributed uniformly over the sphere."""
    return unit(random.normal(size=(count, 3)))


def scatter(template: Mesh, placements: Floats) -> Mesh:
    """Return one mesh with a copy of `template` in each affine frame.

    Parameters
    ----------
    template : Mesh
    placements : array, shape (k, 3, 4)
        Affine frames, as from `frames`.

    Returns
    -------
    Mesh
        The copies in the order of the frames.

    Raises
    ------
    ValueError
        If a frame mirrors the template or flattens it.
    """
    count = len(placements)
    linear, offset = placements[:, :, :3], placements[:, :, 3]
    if (np.linalg.det(linear) <= 0).any():
        raise ValueError("a frame flattens the template or turns it inside out")
    positions = np.einsum("kij,nj->kni", linear, template.positions) + offset[:, None]
    normals = None
    if template.normals is not None:
        # The cofactor matrix keeps normals perpendicular under any linear map.
        cofactor = np.linalg.det(linear)[:, None, None] * np.linalg.inv(linear).swapaxes(1, 2)
        normals = unit(np.einsum("kij,nj->kni", cofactor, template.normals)).reshape(-1, 3)
    triangles = template.triangles.astype(np.int64)
    starts = np.arange(count)[:, None, None] * len(template.positions)
    return Mesh.from_arrays(
        positions.reshape(-1, 3),
        (triangles[None] + starts).reshape(-1, 3),
        **{name: np.concatenate([values] * count) for name, values in template.vertices.items()}
        | {"normals": normals},
    )


def repeated(mesh: Mesh, offsets: Sequence[Vector]) -> Mesh:
    """Return one mesh with a copy of `mesh` translated by each of `offsets`, in meters."""
    placements = np.tile(np.eye(4)[:3], (len(offsets), 1, 1))
    placements[:, :, 3] = offsets
    return scatter(mesh, placements)


def merge(meshes: Sequence[Mesh]) -> Mesh:
    """Return one mesh of the triangles of all meshes, in order.

    Raises
    ------
    ValueError
        If only some of the meshes have uvs, normals, radiance or another array of vertices.
    """
    starts = np.cumsum([0] + [len(mesh.positions) for mesh in meshes[:-1]])
    return Mesh.from_arrays(
        np.concatenate([mesh.positions for mesh in meshes]),
        np.concatenate(
            [
                mesh.triangles.astype(np.int64) + start
                for mesh, start in zip(meshes, starts, strict=True)
            ]
        ),
        **{
            name: _joined(name, [mesh.vertices.get(name) for mesh in meshes])
            for name in dict.fromkeys(name for mesh in meshes for name in mesh.vertices)
        },
    )


def _joined(name: str, values: Sequence[Array | None]) -> Array | None:
    present = [value for value in values if value is not None]
    if present and len(present) != len(values):
        raise ValueError(f"only some of the meshes to merge have {name}; give it to all or none")
    return np.concatenate(present) if present else None

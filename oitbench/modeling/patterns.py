"""Patterns that show distortion and blur: checkered surfaces in two parts, one for each paint.

A new pattern is a function that returns one mesh for each of its paints.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import numpy.typing as npt

from oitbench.modeling.mesh import box_faces, grid
from oitbench.modeling.placement import merge
from oitbench.scene import Mesh, Vector

Mask = npt.NDArray[np.bool_]


def checkers(
    center: Vector, right: Vector, up: Vector, columns: int, rows: int
) -> tuple[Mesh, Mesh]:
    """Return the parallelogram center ± right ± up as a checkerboard: its even and odd squares.

    Both meshes take their vertices from one grid, so that no crack runs between them. The square at
    center − right − up is even.
    """
    board = grid(center, right, up, columns, rows)
    cell = np.arange(len(board.triangles)) // 2
    odd = (cell % columns + cell // columns) % 2 == 1
    return _part(board, ~odd), _part(board, odd)


def checkered_box(center: Vector, size: Vector, squares: int) -> tuple[Mesh, Mesh]:
    """Return the even and odd squares of an axis-aligned box with squares × squares on each face.

    `size` holds the edge lengths in meters.
    """
    faces = [checkers(*face, squares, squares) for face in box_faces(center, size)]
    even, odd = (merge(part) for part in zip(*faces, strict=True))
    return even, odd


def _part(board: Mesh, keep: Mask) -> Mesh:
    """Return the chosen triangles of a mesh with only the vertices that they use."""
    used, triangles = np.unique(board.triangles[keep], return_inverse=True)
    assert board.uvs is not None
    assert board.normals is not None
    return replace(
        board,
        positions=board.positions[used],
        triangles=triangles.reshape(-1, 3).astype(np.uint32),
        uvs=board.uvs[used],
        normals=board.normals[used],
    )

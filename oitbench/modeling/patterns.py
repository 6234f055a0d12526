"""Patterns that show what glass does to them: checkered surfaces, and rooms seen all around."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from oitbench.modeling.baking import Floats
from oitbench.modeling.mesh import grid, merge
from oitbench.scene import RGB, Mesh, Texture

Mask = npt.NDArray[np.bool_]


def checkers(center: RGB, right: RGB, up: RGB, columns: int, rows: int) -> tuple[Mesh, Mesh]:
    """Return the parallelogram center ± right ± up as a checkerboard: its even and odd squares.

    Both meshes take their vertices from one grid, so no crack runs between them. The square at
    center − right − up is even.
    """
    board = grid(center, right, up, columns, rows)
    cell = np.arange(len(board.triangles)) // 2
    odd = (cell % columns + cell // columns) % 2 == 1
    return _part(board, ~odd), _part(board, odd)


def checkered_box(center: RGB, size: RGB, squares: int) -> tuple[Mesh, Mesh]:
    """Return an axis-aligned box whose faces are squares × squares checkers, even and odd ones."""
    half = np.asarray(size, dtype=np.float64) / 2
    parts: tuple[list[Mesh], list[Mesh]] = ([], [])
    for axis in range(3):
        for sign in (1, -1):
            offset, right, up = np.zeros((3, 3))
            offset[axis] = sign * half[axis]
            right[(axis + 1) % 3] = sign * half[(axis + 1) % 3]
            up[(axis + 2) % 3] = half[(axis + 2) % 3]
            middle = np.asarray(center, dtype=np.float64) + offset
            face = checkers(_triple(middle), _triple(right), _triple(up), squares, squares)
            for part, mesh in zip(parts, face, strict=True):
                part.append(mesh)
    even, odd = (merge(part) for part in parts)
    return even, odd


@dataclass(frozen=True)
class Window:
    """A bright rectangle in the surroundings, with soft edges.

    Parameters
    ----------
    azimuth, elevation : float
        Direction of its middle, radians: to the right of straight ahead (−z), and above level.
    width, height : float
        Full angles, radians.
    radiance : RGB
    """

    azimuth: float
    elevation: float
    width: float
    height: float
    radiance: RGB


def room(
    ceiling: RGB, walls: RGB, floor: RGB, windows: Sequence[Window], rows: int = 64
) -> Texture:
    """Return surroundings for an `EnvironmentLight`: a ceiling, walls, a floor and windows.

    Parameters
    ----------
    ceiling, walls, floor : RGB
        Radiance straight up, at level and straight down; smooth between.
    windows : sequence of Window
    rows : int
        Height of the map in texels, a power of two; it is twice as wide.
    """
    elevation = (0.5 - (np.arange(rows) + 0.5) / rows) * math.pi
    azimuth = ((np.arange(2 * rows) + 0.5) / rows - 1) * math.pi
    height = np.sin(elevation)[:, None, None]
    level, up, down = (np.asarray(color) for color in (walls, ceiling, floor))
    far = np.where(height > 0, up, down)
    picture = np.repeat(level + (far - level) * height**2, 2 * rows, axis=1)
    edge = 2 * math.pi / rows
    for window in windows:
        turn = (azimuth - window.azimuth + math.pi) % (2 * math.pi) - math.pi
        across = _plateau(turn, window.width, edge)
        along = _plateau(elevation - window.elevation, window.height, edge)
        there = (along[:, None] * across[None])[..., None]
        picture = picture + there * (np.asarray(window.radiance) - picture)
    return Texture(picture.astype(np.float32))


def _plateau(angle: Floats, width: float, edge: float) -> Floats:
    """Return 1 within `width` and 0 beyond it, with a ramp `edge` wide in between."""
    return np.asarray(np.clip((width / 2 - np.abs(angle)) / edge + 0.5, 0, 1))


def _part(board: Mesh, keep: Mask) -> Mesh:
    """Return some triangles of a mesh, with only the vertices that they use."""
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


def _triple(values: Floats) -> RGB:
    return (float(values[0]), float(values[1]), float(values[2]))

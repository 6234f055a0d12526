"""Parts of buildings and streets: columns, arched walls, street lamps and lettering.

Metres, y up. What stands, stands at the origin; walls lie in the xy plane, centered on it.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from oitbench.modeling.mesh import (
    box,
    divisions,
    grid,
    lathe,
    merge,
    scatter,
    smooth_curve,
    sphere,
    transform,
    translation,
)
from oitbench.scene import RGB, Mesh

Floats = npt.NDArray[np.float64]

# Strokes of letters in a cell one wide and two high, without the width of the pen.
GLYPHS: dict[str, tuple[tuple[tuple[float, float], ...], ...]] = {
    "A": (((0, 0), (0.5, 2), (1, 0)), ((0.2, 0.75), (0.8, 0.75))),
    "E": (((1, 0), (0, 0), (0, 2), (1, 2)), ((0, 1), (0.8, 1))),
    "I": (((0.5, 0), (0.5, 2)),),
    "P": (((0, 0), (0, 2), (0.7, 2), (1, 1.7), (1, 1.3), (0.7, 1), (0, 1)),),
    "R": (((0, 0), (0, 2), (0.7, 2), (1, 1.7), (1, 1.3), (0.7, 1), (0, 1)), ((0.5, 1), (1, 0))),
    "T": (((0.5, 0), (0.5, 2)), ((0, 2), (1, 2))),
    "V": (((0, 2), (0.5, 0), (1, 2)),),
    "Y": (((0, 2), (0.5, 1), (1, 2)), ((0.5, 1), (0.5, 0))),
}
HALVES = ((0, 1, 2), (0, 2, 3))
"""The two triangles of a quadrilateral."""
LETTER_PITCH = 1.6
"""From the left edge of one letter to that of the next, in widths of a letter."""


def column(height: float, radius: float, detail: float) -> Mesh:
    """Return a round column on a square base under a square capital.

    Parameters
    ----------
    height : float
        From the floor to the top of the capital, metres.
    radius : float
        Of the shaft at its foot, metres; the base is three of them wide.
    detail : float
        Factor on the number of triangles.
    """
    plinth, edge = 0.5 * radius, 3 * radius
    foot, head = plinth, height - plinth
    corners = [
        (1.40, foot), (1.45, foot + 0.25 * radius), (1.30, foot + 0.50 * radius),
        (1.00, foot + 0.60 * radius), (1.00, foot + 1.0 * radius),
        (0.98, 0.5 * height), (0.84, head - 1.5 * radius), (0.84, head - 0.9 * radius),
        (1.00, head - 0.8 * radius), (0.90, head - 0.7 * radius), (1.40, head),
    ]  # fmt: skip
    profile = np.asarray(corners) * [radius, 1]
    shaft = lathe(smooth_curve(profile, divisions(24, detail, 6)), divisions(20, detail, 6))
    ends = [
        box((0, middle, 0), (edge, plinth, edge)) for middle in (plinth / 2, height - plinth / 2)
    ]
    return merge([shaft, *ends])


def arch(width: float, opening: float, height: float, depth: float, segments: int) -> Mesh:
    """Return a bay of wall on a round arch that springs from y = 0, open below.

    Parameters
    ----------
    width, height, depth : float
        Of the bay, metres.
    opening : float
        Diameter of the arch, metres, below `width` and twice `height`.
    segments : int
        Divisions of the arch.
    """
    inner, outer = _arc(width / 2, opening / 2, height, segments)
    ends = np.array([[width / 2, 0.0]]), np.array([[-width / 2, 0.0]])
    # The arch runs on along the springing line to the neighboring bays.
    return _pierced(
        np.concatenate([ends[0], inner, ends[1]]), np.concatenate([ends[0], outer, ends[1]]), depth
    )


def window_wall(
    width: float,
    height: float,
    depth: float,
    opening: float,
    sill: float,
    spring: float,
    segments: int,
) -> Mesh:
    """Return a bay of wall on y = 0 with one round-headed window.

    Parameters
    ----------
    width, height, depth : float
        Of the bay, metres.
    opening : float
        Width of the window, metres.
    sill, spring : float
        Heights at which the window begins and at which its round head does, metres.
    segments : int
        Divisions of the head.
    """
    half, side = opening / 2, width / 2
    inner, outer = _arc(side, half, height - spring, segments)
    rise = np.array([0.0, spring])
    right, left = np.array([[half, sill]]), np.array([[-half, sill]])
    corner, other = np.array([[side, 0.0]]), np.array([[-side, 0.0]])
    return _pierced(
        np.concatenate([right, inner + rise, left, right]),
        np.concatenate([corner, outer + rise, other, corner]),
        depth,
    )


def _arc(side: float, radius: float, height: float, segments: int) -> tuple[Floats, Floats]:
    """Return a half circle, from right to left, and where its rays meet the edge of the bay."""
    corner = math.atan2(height, side)
    angles = np.linspace(0, math.pi, segments + 1)
    # The edge has its corners only if two of the rays go there.
    angles = np.unique(np.concatenate([angles, [corner, math.pi - corner]]))
    rays = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    rays[[0, -1], 1] = 0.0
    reach = 1 / np.maximum(np.abs(rays[:, 0]) / side, rays[:, 1] / height)
    return radius * rays, reach[:, None] * rays


def _pierced(inner: Floats, outer: Floats, depth: float) -> Mesh:
    """Return the two faces between polygons of as many points, and the reveal along `inner`."""
    across = np.stack([inner, outer], axis=1)
    faces = [_facets(_at(across, depth / 2)), _facets(_at(across[:, ::-1], -depth / 2))]
    reveal = np.stack([_at(inner, -depth / 2), _at(inner, depth / 2)], axis=1)
    return merge([*faces, _facets(reveal)])


def _at(points: Floats, z: float) -> Floats:
    return np.concatenate([points, np.full((*points.shape[:-1], 1), z)], axis=-1)


def _facets(rungs: Floats) -> Mesh:
    """Return flat quadrilaterals between successive rungs, shape (n, 2, 3), without empty ones."""
    corners = np.concatenate([rungs[:-1], rungs[1:, ::-1]], axis=1)
    diagonals = corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1]
    normals = np.cross(*diagonals)
    area = np.linalg.norm(normals, axis=1)
    corners, normals = corners[area > 0], (normals / np.maximum(area, 1e-12)[:, None])[area > 0]
    starts = 4 * np.arange(len(corners))[:, None]
    triangles = np.concatenate([starts + np.array(half) for half in HALVES]).astype(np.uint32)
    positions = corners.reshape(-1, 3).astype(np.float32)
    first, second, third = positions[triangles].swapaxes(0, 1)
    whole = np.cross(second - first, third - first).any(axis=1)
    return Mesh(
        positions,
        triangles[whole],
        uvs=np.tile(np.array([[0, 0], [1, 0], [1, 1], [0, 1]], np.float32), (len(corners), 1)),
        normals=np.repeat(normals, 4, axis=0).astype(np.float32),
    )


def lamp_post(height: float, arm: float, detail: float) -> Mesh:
    """Return a street lamp without its bulb: a post with an arm along +x and a shade at its end.

    The shade opens downwards; its rim is at y = `height`, above the point (`arm`, 0).
    """
    slices = divisions(16, detail, 6)
    corners = [(0.0, 0.0), (0.16, 0.0), (0.16, 0.25), (0.07, 0.40), (0.05, 1.2)]
    corners += [(0.04, height + 0.30), (0.0, height + 0.32)]
    post = lathe(smooth_curve(corners, divisions(24, detail, 10)), slices)
    beam = box((arm / 2, height + 0.24, 0), (arm, 0.04, 0.04))
    shade = smooth_curve(
        [(0.24, 0.0), (0.20, 0.08), (0.10, 0.16), (0.06, 0.2), (0.0, 0.215)],
        divisions(12, detail, 5),
    )
    hood = transform(lathe(shade, slices), translation((arm, height, 0)))
    return merge([post, beam, hood])


def globe(center: RGB, radius: float, detail: float) -> Mesh:
    """Return a round bulb."""
    return sphere(center, radius, divisions(20, detail, 8), divisions(12, detail, 6))


def lettering(text: str, center: RGB, height: float, pen: float) -> Mesh:
    """Return letters of flat strokes that face +z and read along +x.

    Parameters
    ----------
    text : str
        Of the letters in `GLYPHS`, and blanks.
    center : RGB
        Middle of the line of text, metres.
    height : float
        Of the letters, metres.
    pen : float
        Width of the strokes, metres.

    Raises
    ------
    ValueError
        For a letter that has no glyph.
    """
    missing = sorted(set(text) - set(GLYPHS) - {" "})
    if missing:
        raise ValueError(f"lettering: there is no glyph for {' '.join(missing)}")
    scale = (height - pen) / 2
    left = -scale * (LETTER_PITCH * (len(text) - 1) + 1) / 2
    strokes: list[Mesh] = []
    for place, letter in enumerate(text):
        origin = np.array([left + scale * LETTER_PITCH * place, -scale])
        for line in GLYPHS.get(letter, ()):
            strokes += _strokes(origin + scale * np.asarray(line), pen)
    return transform(merge(strokes), translation(center))


def _strokes(line: Floats, pen: float) -> list[Mesh]:
    """Return a rectangle for each edge of `line`, half a pen's width longer at both ends."""
    meshes = []
    for start, end in itertools.pairwise(line):
        along = (end - start) / np.linalg.norm(end - start)
        reach = np.linalg.norm(end - start) / 2 + pen / 2
        x, y = (start + end) / 2
        right = (float(reach * along[0]), float(reach * along[1]), 0.0)
        up = (float(-pen / 2 * along[1]), float(pen / 2 * along[0]), 0.0)
        meshes.append(grid((float(x), float(y), 0.0), right, up))
    return meshes


def slab(low: RGB, high: RGB, cells: int = 1) -> Mesh:
    """Return the axis-aligned box between two corners."""
    first, last = np.asarray(low), np.asarray(high)
    x, y, z = (first + last) / 2
    width, height, depth = last - first
    return box((float(x), float(y), float(z)), (float(width), float(height), float(depth)), cells)


def repeated(mesh: Mesh, offsets: Sequence[RGB]) -> Mesh:
    """Return one mesh with a copy of `mesh` shifted by each of `offsets`, in metres."""
    placements = np.tile(np.eye(4)[:3], (len(offsets), 1, 1))
    placements[:, :, 3] = offsets
    return scatter(mesh, placements)

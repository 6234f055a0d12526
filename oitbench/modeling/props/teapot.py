"""The Utah teapot: 32 bicubic Bézier patches.

Body, rim, lid and bottom are surfaces of revolution, so that their 24 patches follow from six
profile curves. Handle and spout are two patches each and the mirror images of these.

References
----------
Newell 1975, "The Utilization of Procedure Models in Digital Image Synthesis". The heights are those
of Blinn's flatter version, with the bottom that was added later.
"""

from __future__ import annotations

import math

import numpy as np

from oitbench.modeling.detail import divisions
from oitbench.modeling.mesh import collapsed
from oitbench.scene import Floats, Mesh, unit

HEIGHT = 3.15
"""From the bottom to the top of the knob, in the units of the control points."""
_ARC = 0.56
"""Coordinate of the inner control points of a quarter circle, in units of its radius."""
_INSIDE = 1e-4
"""Distance from a patch's edge at which its normals are taken: at a pole one tangent vanishes."""

# Control points (radius, height) of the profiles.
_PROFILES = np.array(
    [
        [(1.4, 2.4), (1.3375, 2.53125), (1.4375, 2.53125), (1.5, 2.4)],  # rim
        [(1.5, 2.4), (1.75, 1.875), (2.0, 1.35), (2.0, 0.9)],  # body
        [(2.0, 0.9), (2.0, 0.45), (1.5, 0.225), (1.5, 0.15)],
        [(1.5, 0.15), (1.5, 0.075), (1.425, 0.0), (0.0, 0.0)],  # bottom
        [(0.0, 3.15), (0.8, 3.15), (0.0, 2.85), (0.2, 2.7)],  # knob
        [(0.2, 2.7), (0.4, 2.55), (1.3, 2.55), (1.3, 2.4)],  # lid
    ]
)
# Control points of one half of each tube, from one end to the other: (x, height) on the inner edge,
# (x, height) on the outer edge, and half the width.
_TUBES = np.array(
    [
        [  # handle
            (-1.6, 2.025, -1.5, 2.25, 0.3),
            (-2.3, 2.025, -2.5, 2.25, 0.3),
            (-2.7, 2.025, -3.0, 2.25, 0.3),
            (-2.7, 1.8, -3.0, 1.8, 0.3),
        ],
        [
            (-2.7, 1.8, -3.0, 1.8, 0.3),
            (-2.7, 1.575, -3.0, 1.35, 0.3),
            (-2.5, 1.125, -2.65, 0.9375, 0.3),
            (-2.0, 0.9, -1.9, 0.6, 0.3),
        ],
        [  # spout
            (1.7, 1.425, 1.7, 0.6, 0.66),
            (2.6, 1.425, 3.1, 0.825, 0.66),
            (2.3, 2.1, 2.4, 2.025, 0.25),
            (2.7, 2.4, 3.3, 2.4, 0.25),
        ],
        [
            (2.7, 2.4, 3.3, 2.4, 0.25),
            (2.8, 2.475, 3.525, 2.49375, 0.25),
            (2.9, 2.475, 3.45, 2.5125, 0.15),
            (2.8, 2.4, 3.2, 2.4, 0.15),
        ],
    ]
)


def patches() -> Floats:
    """Return the control points, shape (32, 4, 4, 3), y up, with the spout along +x.

    The second axis of the array runs around the pot and the third along its profile. The cross
    product of the derivatives along them points outwards.
    """
    quarter = np.array([(1, 0), (1, _ARC), (_ARC, 1), (0, 1)])
    found = []
    for profile in _PROFILES:
        around = quarter
        for _ in range(4):
            found.append(_ring(profile, around))
            # This quarter turn does not round, so that neighbors share their edges exactly.
            around = np.stack([-around[:, 1], around[:, 0]], axis=1)
    for tube in _TUBES:
        half = np.empty((4, 4, 3))
        half[:, :, :2] = tube[:, [[0, 1], [0, 1], [2, 3], [2, 3]]].swapaxes(0, 1)
        half[:, :, 2] = np.array([0, 1, 1, 0])[:, None] * tube[:, 4]
        mirrored = half[::-1] * [1, 1, -1]
        found += [half, mirrored]
    return np.stack(found)


def teapot(height: float, detail: float) -> Mesh:
    """Return the teapot, which stands on y = 0 about the y axis with its spout along +x.

    Parameters
    ----------
    height : float
        From the bottom to the top of the knob, meters.
    detail : float
        Factor on the number of triangles, which is 4032 at detail 1.

    Returns
    -------
    Mesh
        Normals are smooth within each part. The pot is closed below. As in Newell's data, the lid
        leaves a gap inside the rim, and handle and spout reach through the wall.
    """
    cells = divisions(8, detail, 2)
    at = np.linspace(0, 1, cells + 1)
    control = patches()
    positions = _evaluate(control, _bernstein(at), _bernstein(at))
    inside = np.clip(at, _INSIDE, 1 - _INSIDE)
    across = _evaluate(control, _slopes(inside), _bernstein(inside))
    along = _evaluate(control, _bernstein(inside), _slopes(inside))
    normals = unit(np.cross(across, along))
    row = np.arange(cells)
    corner = (row[:, None] * (cells + 1) + row).ravel()
    right, below = corner + cells + 1, corner + 1
    cell = np.stack([corner, right, right + 1, corner, right + 1, below], axis=1).reshape(-1, 3)
    starts = np.arange(len(control))[:, None, None] * (cells + 1) ** 2
    vertices = (positions * (height / HEIGHT)).reshape(-1, 3)
    triangles = (cell + starts).reshape(-1, 3)
    return Mesh.from_arrays(
        vertices, triangles[~collapsed(vertices, triangles)], normals=normals.reshape(-1, 3)
    )


def _ring(profile: Floats, around: Floats) -> Floats:
    """Return the control points, shape (4, 4, 3), of a profile swept along four points (x, z)."""
    radial = around[:, None] * profile[None, :, :1]
    height = np.broadcast_to(profile[None, :, 1], radial.shape[:2])
    return np.stack([radial[..., 0], height, radial[..., 1]], axis=-1)


def _bernstein(at: Floats) -> Floats:
    """Return the cubic Bernstein polynomials at each parameter, shape (n, 4)."""
    powers = [math.comb(3, k) * at**k * (1 - at) ** (3 - k) for k in range(4)]
    return np.stack(powers, axis=1)


def _slopes(at: Floats) -> Floats:
    """Return the derivatives of the cubic Bernstein polynomials, shape (n, 4)."""
    lower = np.stack([math.comb(2, k) * at**k * (1 - at) ** (2 - k) for k in range(3)], axis=1)
    padded = np.pad(lower, ((0, 0), (1, 1)))
    return np.asarray(3 * (padded[:, :-1] - padded[:, 1:]))


def _evaluate(control: Floats, across: Floats, along: Floats) -> Floats:
    """Return points or tangents of all patches, shape (patches, n, n, 3)."""
    return np.asarray(np.einsum("iu,jv,puvk->pijk", across, along, control))

"""The six chess pieces, each one closed solid: turned, and lofted where it is not round.

A piece stands on y = 0 about the y axis and faces +x. The unit of length is the height of the king.
The proportions follow the pattern of the Staunton set of 1849.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from oitbench.modeling.detail import divisions
from oitbench.modeling.placement import scaling, transform
from oitbench.modeling.profiles import Corner, outline, smooth_curve
from oitbench.modeling.solids import closed, loft, round_rings, turned
from oitbench.scene import Mesh

SLICES = 24
"""Divisions of a piece about its axis at detail 1."""
NOTCHES = 5
"""Notches in the battlement of a rook."""

# Corners (radius, height, fillet). All pieces have the same foot, in units of its own radius.
_FOOT: tuple[Corner, ...] = (
    (0.0, 0.0, 0.0),
    (1.0, 0.0, 0.03),
    (1.0, 0.30, 0.07),
    (0.80, 0.34, 0.03),
    (0.72, 0.60, 0.12),
)
_PAWN: tuple[Corner, ...] = (
    (0.062, 0.200, 0.10),
    (0.055, 0.335, 0.008),
    (0.098, 0.350, 0.010),
    (0.098, 0.372, 0.010),
    (0.045, 0.385, 0.004),
    (0.085, 0.405, 0.040),
    (0.085, 0.560, 0.085),
    (0.000, 0.560, 0.0),
)
_ROOK: tuple[Corner, ...] = (
    (0.098, 0.200, 0.10),
    (0.088, 0.400, 0.02),
    (0.125, 0.425, 0.012),
    (0.125, 0.450, 0.012),
    (0.118, 0.460, 0.004),
    (0.130, 0.580, 0.008),
    (0.082, 0.580, 0.008),
    (0.078, 0.525, 0.010),
    (0.000, 0.525, 0.0),
)
_BISHOP: tuple[Corner, ...] = (
    (0.068, 0.220, 0.12),
    (0.055, 0.450, 0.008),
    (0.112, 0.465, 0.010),
    (0.112, 0.488, 0.010),
    (0.055, 0.505, 0.010),
    (0.120, 0.560, 0.050),
    (0.080, 0.690, 0.120),
    (0.018, 0.740, 0.006),
    (0.036, 0.752, 0.012),
    (0.036, 0.805, 0.036),
    (0.000, 0.805, 0.0),
)
_QUEEN: tuple[Corner, ...] = (
    (0.078, 0.240, 0.14),
    (0.062, 0.580, 0.008),
    (0.122, 0.598, 0.011),
    (0.122, 0.624, 0.011),
    (0.065, 0.640, 0.010),
    (0.080, 0.720, 0.150),
    (0.150, 0.815, 0.008),
    (0.120, 0.822, 0.008),
    (0.105, 0.800, 0.020),
    (0.028, 0.850, 0.004),
    (0.045, 0.862, 0.018),
    (0.045, 0.935, 0.045),
    (0.000, 0.935, 0.0),
)
_KING: tuple[Corner, ...] = (
    (0.082, 0.240, 0.14),
    (0.066, 0.600, 0.008),
    (0.128, 0.618, 0.011),
    (0.128, 0.646, 0.011),
    (0.070, 0.662, 0.010),
    (0.085, 0.720, 0.120),
    (0.132, 0.820, 0.015),
    (0.110, 0.850, 0.030),
    (0.030, 0.868, 0.010),
)
# The cross of the king: half its width along x and along z at each height.
_CROSS = np.array(
    [
        (0.022, 0.020, 0.880),
        (0.014, 0.014, 0.905),
        (0.016, 0.014, 0.915),
        (0.056, 0.016, 0.918),
        (0.060, 0.016, 0.938),
        (0.056, 0.016, 0.958),
        (0.016, 0.014, 0.961),
        (0.016, 0.014, 0.970),
        (0.026, 0.015, 0.997),
        (0.016, 0.010, 1.000),
        (0.000, 0.000, 1.000),
    ]
)
# Rings of the knight from the neck to the muzzle: back (x, y), front (x, y), half the width.
_HORSE = np.array(
    [
        (-0.105, 0.235, 0.110, 0.235, 0.100),
        (-0.130, 0.330, 0.095, 0.310, 0.082),
        (-0.145, 0.430, 0.055, 0.390, 0.070),
        (-0.135, 0.530, 0.020, 0.445, 0.064),
        (-0.095, 0.620, 0.020, 0.475, 0.064),
        (-0.050, 0.680, 0.030, 0.480, 0.062),
        (-0.015, 0.735, 0.040, 0.475, 0.046),  # the ears
        (0.002, 0.760, 0.043, 0.472, 0.036),
        (0.012, 0.715, 0.047, 0.468, 0.046),
        (0.035, 0.665, 0.053, 0.462, 0.062),
        (0.080, 0.645, 0.066, 0.440, 0.070),
        (0.130, 0.595, 0.095, 0.415, 0.058),
        (0.180, 0.545, 0.130, 0.405, 0.046),
        (0.225, 0.495, 0.160, 0.395, 0.045),
        (0.245, 0.450, 0.190, 0.375, 0.040),
        (0.238, 0.405, 0.218, 0.383, 0.012),
        (0.228, 0.393, 0.228, 0.393, 0.000),
    ]
)


def pawn(detail: float) -> Mesh:
    """Return a pawn."""
    return _turned_piece(0.150, _PAWN, detail)


def bishop(detail: float) -> Mesh:
    """Return a bishop with a miter."""
    return _turned_piece(0.168, _BISHOP, detail)


def queen(detail: float) -> Mesh:
    """Return a queen with a crown."""
    return _turned_piece(0.188, _QUEEN, detail)


def rook(detail: float) -> Mesh:
    """Return a rook with a battlement that has `NOTCHES` notches."""
    profile = outline(_corners(0.172, _ROOK), detail)
    # A whole number of slices for each notch and merlon makes all notches alike.
    slices = NOTCHES * 2 * divisions(3, detail)
    angle = np.arange(slices) / slices * 2 * np.pi
    radius, height = np.broadcast_to(profile.T[:, :, None], (2, len(profile), slices))
    notch = np.arange(slices) % (slices // NOTCHES) < slices // NOTCHES // 2
    floor = _ROOK[-1][1]
    sunk = np.where(
        notch & (height > floor + 0.004), floor + 0.004 + 0.1 * (height - floor), height
    )
    return closed(np.stack([radius * np.cos(angle), sunk, -radius * np.sin(angle)], axis=-1))


def king(detail: float) -> Mesh:
    """Return a king with a cross on the crown."""
    body = round_rings(outline(_corners(0.195, (*_KING, (0.022, 0.880, 0.0))), detail))
    wide, thick, height = _CROSS[1:].T
    cross = np.stack([-wide, height, wide, height, thick], axis=1)
    return loft(np.concatenate([body, cross]), divisions(SLICES, detail, 8))


def knight(detail: float) -> Mesh:
    """Return a knight: a horse's neck and head, lofted from the foot to the muzzle."""
    foot = round_rings(outline((*_corners(0.172, ()), (0.105, 0.225, 0.0)), detail))
    head = smooth_curve(_HORSE, divisions(30, detail, 12))
    return loft(np.concatenate([foot, head]), divisions(SLICES, detail, 8))


PIECES: dict[str, Callable[[float], Mesh]] = {
    "pawn": pawn,
    "rook": rook,
    "knight": knight,
    "bishop": bishop,
    "queen": queen,
    "king": king,
}


def piece(name: str, king_height: float, detail: float) -> Mesh:
    """Return a piece of a set whose king is `king_height` meters tall.

    Parameters
    ----------
    name : str
        One of `PIECES`.
    king_height : float
        Meters.
    detail : float
        Factor on the number of triangles; about 1500 per piece at detail 1.
    """
    return transform(PIECES[name](detail), scaling((king_height, king_height, king_height)))


def _turned_piece(width: float, body: Sequence[Corner], detail: float) -> Mesh:
    """Return a round piece with a foot of radius `width`."""
    return turned(outline(_corners(width, body), detail), divisions(SLICES, detail, 8))


def _corners(width: float, body: Sequence[Corner]) -> tuple[Corner, ...]:
    """Return the outline of a foot of radius `width` with a body on top."""
    foot: list[Corner] = [(width * r, width * h, width * f) for r, h, f in _FOOT]
    return (*foot, *body)

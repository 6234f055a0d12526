"""Types of vectors, colors and arrays, and vector algebra."""

from __future__ import annotations

from functools import reduce

import numpy as np
import numpy.typing as npt

Vector = tuple[float, float, float]
"""Position or size in meters, or direction: (x, y, z)."""
RGB = tuple[float, float, float]
"""Linear Rec.709 color: (red, green, blue)."""
Array = npt.NDArray[np.float32]
"""Array in the precision in which scenes store values."""
Floats = npt.NDArray[np.float64]
"""Array in the precision in which values are computed."""
BLACK: RGB = (0.0, 0.0, 0.0)
WHITE: RGB = (1.0, 1.0, 1.0)


def as_vector(values: npt.ArrayLike) -> Vector:
    """Return the three numbers of an array as a tuple of floats."""
    x, y, z = np.asarray(values, dtype=np.float64)
    return (float(x), float(y), float(z))


def opposite(direction: Vector) -> Vector:
    """Return the direction reversed."""
    x, y, z = direction
    return (-x, -y, -z)


def unit(vectors: Floats) -> Floats:
    """Return vectors of length one in the same directions; the last axis holds the components."""
    # Sums over whole components are several times faster than over an axis of three numbers.
    scaled = _near_one(vectors)
    squares = [component**2 for component in np.moveaxis(scaled, -1, 0)]
    return np.asarray(scaled / np.sqrt(sum(squares))[..., None])


def _near_one(vectors: Floats) -> Floats:
    """Scale vectors by powers of two, without rounding, so that no square of them overflows."""
    _, exponent = np.frexp(reduce(np.maximum, np.moveaxis(np.abs(vectors), -1, 0)))
    return np.asarray(np.ldexp(vectors, -exponent[..., None]))


def axes_along(back: npt.ArrayLike, up: npt.ArrayLike | None = None) -> Floats:
    """Return an orthonormal, right-handed frame whose third axis is a given direction.

    Parameters
    ----------
    back : array, shape (3,)
        The third axis; need not have unit length.
    up : array, shape (3,), optional
        Direction in the plane of the second and third axis, on the side of the second; not parallel
        to `back`. Default: the coordinate axis that is the farthest from parallel to `back`.

    Returns
    -------
    array, shape (3, 3), float64
        Unit vectors right, up and back as rows.
    """
    direction = unit(np.asarray(back, dtype=np.float64))
    upward = np.eye(3)[np.argmin(np.abs(direction))] if up is None else np.asarray(up, np.float64)
    right = unit(np.cross(_near_one(upward), direction))
    return np.stack([right, np.cross(direction, right), direction])


def relocated(point: Vector, origin: Vector, scale: float) -> Vector:
    """Return a point relative to `origin`, in units that are `scale` times smaller."""
    x, y, z = ((a - b) * scale for a, b in zip(point, origin, strict=True))
    return x, y, z

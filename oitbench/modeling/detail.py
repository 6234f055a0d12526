"""How the size of a mesh follows `detail`, the parameter that every scene has."""

from __future__ import annotations

import math

from oitbench.parameters import Parameter

DETAIL = Parameter(1.0, low=0.0, high=100.0, help="factor on the number of triangles")
"""The parameter `detail` of most scenes."""
PARTICLE_DETAIL = Parameter(
    1.0, low=0.0, high=100.0, help="factor on the number of particles; thickness stays the same"
)
"""The parameter `detail` of scenes with particles."""
LEAST_COPIES = 8


def divisions(base: float, detail: float, least: int = 1) -> int:
    """Return the number of divisions of an edge that makes triangles proportional to `detail`.

    Parameters
    ----------
    base : float
        Divisions at detail 1.
    detail : float
        Factor on the number of triangles of a surface; not negative.
    least : int
        Smallest number of divisions.
    """
    return max(least, round(base * math.sqrt(detail)))


def copies(base: int, detail: float) -> int:
    """Return the number of particles or leaves at `detail`, of which there are `base` at detail 1.

    It is never below `LEAST_COPIES`.
    """
    return max(LEAST_COPIES, round(base * detail))


def enlargement(base: int, count: int) -> float:
    """Return the factor on the size of `count` copies that gives them the area of `base` copies.

    It is never below 1.
    """
    return max(1.0, math.sqrt(base / count))

"""Glass of a given attenuation."""

from __future__ import annotations

import numpy as np

from oitbench.scene import RGB, Mesh


def transmission(color: RGB, distance: float, mesh: Mesh) -> RGB:
    """Return T of one interface of a solid: color^(l / 2d) with the mean chord l = 4 V / S."""
    a, b, c = (mesh.positions[column] for column in mesh.triangles.T)
    volume = abs(float(np.einsum("ij,ij->", a, np.cross(b, c)))) / 6
    surface = float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum()) / 2
    red, green, blue = (part ** (2 * volume / surface / distance) for part in color)
    return red, green, blue

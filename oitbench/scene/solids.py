"""Lengths inside of closed meshes."""

from __future__ import annotations

import numpy as np

from oitbench.scene.objects import Mesh


def mean_chord(mesh: Mesh) -> float:
    """Return the mean length of the chords through a closed mesh, 4V/S (Cauchy), in its unit.

    It is 0 for a mesh without area.
    """
    corners = mesh.positions[mesh.triangles]
    corners = corners - corners.mean(axis=(0, 1))
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    surface = float(np.linalg.norm(cross, axis=1).sum()) / 2
    volume = abs(float((corners[:, 0] * cross).sum())) / 6
    return 4 * volume / surface if surface > 0 else 0.0

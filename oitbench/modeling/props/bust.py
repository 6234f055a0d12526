"""A woman's head, neck and shoulders as one smooth body, with closed eyes.

Meters, y up. The middle of the head is the origin, and it looks along +z. Its crown is at y = 0.115
and its chin at −0.115.
"""

from __future__ import annotations

import numpy as np

from oitbench.modeling.implicit import capsule, carved, ellipsoid, joined, surface
from oitbench.scene import Floats, Mesh

CRANIUM = ((0.0, 0.028, -0.022), (0.073, 0.087, 0.093))
"""Center and half axes of the ellipsoid that carries the hair."""


def distance(points: Floats) -> Floats:
    """Return the signed distance to head, neck and shoulders; left and right are equal."""
    # Rounded where the halves meet, so that no crease runs down the middle.
    mirrored = np.column_stack([np.sqrt(points[:, 0] ** 2 + 4e-6), points[:, 1:]])
    return joined(_head(mirrored), _torso(mirrored), 0.035)


def bust(cell: float) -> Mesh:
    """Return the mesh of the bust, whose triangles have edges of about `cell` meters.

    It is open below, at y = −0.36.
    """
    return surface(distance, (-0.245, -0.36, -0.14), (0.245, 0.125, 0.125), cell)


def _torso(points: Floats) -> Floats:
    neck = capsule(points, (0, -0.06, -0.030), (0, -0.20, -0.045), 0.040, 0.046)
    slope = capsule(points, (0.02, -0.195, -0.055), (0.12, -0.240, -0.048), 0.022, 0.030)
    shoulder = capsule(points, (0.05, -0.250, -0.045), (0.150, -0.268, -0.04), 0.042, 0.045)
    arm = capsule(points, (0.152, -0.27, -0.04), (0.175, -0.42, -0.04), 0.043, 0.038)
    chest = ellipsoid(points, (0, -0.37, -0.03), (0.14, 0.145, 0.080))
    collar = capsule(points, (0.022, -0.226, 0.002), (0.13, -0.229, -0.022), 0.006, 0.005)
    body = joined(joined(shoulder, slope, 0.05), joined(chest, arm, 0.05), 0.05)
    body = joined(body, collar, 0.018)
    return joined(body, neck, 0.045)


def _head(points: Floats) -> Floats:
    head = ellipsoid(points, *CRANIUM)
    head = joined(head, ellipsoid(points, (0, -0.028, 0.016), (0.054, 0.076, 0.064)), 0.03)
    head = joined(head, ellipsoid(points, (0, -0.078, 0.028), (0.034, 0.034, 0.044)), 0.03)
    head = joined(head, ellipsoid(points, (0, -0.099, 0.058), (0.013, 0.012, 0.013)), 0.025)
    head = joined(head, ellipsoid(points, (0.040, -0.026, 0.044), (0.020, 0.016, 0.020)), 0.03)
    head = joined(head, ellipsoid(points, (0.020, 0.022, 0.060), (0.022, 0.008, 0.012)), 0.025)
    # Eyes under closed lids, in their sockets.
    head = carved(head, ellipsoid(points, (0.030, 0.002, 0.088), (0.018, 0.012, 0.016)), 0.016)
    head = joined(head, ellipsoid(points, (0.031, 0.001, 0.0635), (0.0155, 0.0115, 0.0125)), 0.005)
    # A nose with its wings, and lips.
    nose = capsule(points, (0, 0.014, 0.072), (0, -0.028, 0.091), 0.005, 0.0068)
    head = joined(head, nose, 0.016)
    head = joined(head, ellipsoid(points, (0, -0.031, 0.092), (0.0072, 0.0062, 0.0075)), 0.008)
    head = joined(head, ellipsoid(points, (0.009, -0.034, 0.083), (0.005, 0.005, 0.008)), 0.008)
    head = joined(head, ellipsoid(points, (0, -0.066, 0.070), (0.024, 0.020, 0.0125)), 0.015)
    upper = ellipsoid(points, (0.006, -0.0580, 0.0790), (0.0135, 0.0050, 0.0075))
    lower = ellipsoid(points, (0, -0.0685, 0.0780), (0.0150, 0.0065, 0.0080))
    head = joined(head, upper, 0.003)
    head = joined(head, lower, 0.003)
    ear = ellipsoid(points, (0.071, -0.006, -0.008), (0.008, 0.028, 0.017))
    return joined(head, ear, 0.01)

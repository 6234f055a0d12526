"""A scene in which the order of two objects flips although neither passes the other."""

from __future__ import annotations

import math

from oitbench.modeling.mesh import quad
from oitbench.scene import Camera, Material, Object, Scene
from oitbench.stability.layers import BLUE, RED


def cameras(frames: int = 6, angle: float = 0.03) -> list[Camera]:
    """Return cameras that turn from right to left; half-way, two centers are equally far."""
    angles = [angle * (1 - 2 * k / (frames - 1)) for k in range(frames)]
    return [Camera((0, 0, 0), (math.sin(a), 0.0, -math.cos(a))) for a in angles]


def crossing(coverage: float = 0.5) -> Scene:
    """Return a pane before a larger one, whose center is at its side and as far away."""
    one, other = (Material(coverage, emission=color) for color in (RED, BLUE))
    near = Object("near", quad((0, 0, -2), (0.6, 0, 0), (0, 0.6, 0)), one)
    wide = Object("wide", quad((4, 0, -2), (5, 0, 0.25), (0, 0.7, 0)), other)
    return Scene("crossing", cameras()[0], (near, wide), background=(0.2, 0.2, 0.2))

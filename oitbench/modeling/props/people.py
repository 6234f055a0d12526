"""Standing people as simple silhouettes: turned bodies, heads, hats and limbs.

Meters, y up. They stand at the origin and face +z.
"""

from __future__ import annotations

import math

import numpy as np

from oitbench.modeling.detail import divisions
from oitbench.modeling.mesh import lathe
from oitbench.modeling.placement import merge, rotation, scaling, transform, translation
from oitbench.modeling.profiles import smooth_curve
from oitbench.scene import Floats, Mesh, Vector, as_vector

Outline = list[tuple[float, float]]
"""Points (half width, height) from the lowest to the highest, meters."""

DRESS: Outline = [
    (0.0, 0.46), (0.27, 0.46), (0.27, 0.48), (0.20, 0.75), (0.185, 0.92), (0.12, 1.10),
    (0.145, 1.27), (0.18, 1.37), (0.17, 1.43), (0.05, 1.45), (0.047, 1.54),
]  # fmt: skip
COAT: Outline = [
    (0.0, 0.34), (0.27, 0.34), (0.27, 0.37), (0.23, 0.75), (0.195, 1.02), (0.22, 1.20),
    (0.245, 1.40), (0.235, 1.50), (0.07, 1.55), (0.065, 1.62),
]  # fmt: skip
WOMANS_HEAD: Outline = [
    (0.0, 1.45), (0.10, 1.45), (0.125, 1.50), (0.12, 1.62), (0.11, 1.66), (0.225, 1.655),
    (0.225, 1.67), (0.115, 1.69), (0.10, 1.76), (0.0, 1.78),
]  # fmt: skip
MANS_HEAD: Outline = [
    (0.0, 1.54), (0.05, 1.55), (0.088, 1.62), (0.088, 1.72), (0.09, 1.735), (0.19, 1.73),
    (0.19, 1.75), (0.115, 1.76), (0.11, 1.84), (0.07, 1.88), (0.0, 1.86),
]  # fmt: skip
BODY_DEPTH, HEAD_DEPTH = 0.62, 1.05
"""Depth of bodies and heads from front to back, in units of their width."""
# Direction of each finger in the plane of the palm, radians from straight up, and length in meters.
FINGERS = ((-0.95, 0.055), (-0.28, 0.075), (-0.08, 0.085), (0.10, 0.08), (0.30, 0.062))


def woman(detail: float) -> Mesh:
    """Return a woman in a dress and a hat with a wide brim, 1.78 m tall, arms at her sides."""
    parts = [woman_without_arms(detail)]
    for side in (-1, 1):
        elbow = (0.26 * side, 1.12, -0.01)
        parts.append(limb((0.17 * side, 1.38, 0), elbow, 0.05, 0.036, detail))
        parts.append(limb(elbow, (0.24 * side, 0.88, 0.06), 0.036, 0.028, detail))
    return merge(parts)


def woman_without_arms(detail: float) -> Mesh:
    """Return the same woman, to whom other arms can be added; shoulders are at (±0.17, 1.38, 0)."""
    parts = [_turned(DRESS, BODY_DEPTH, detail), _turned(WOMANS_HEAD, HEAD_DEPTH, detail)]
    parts += [limb((x, 0.6, 0), (x, 0.06, 0), 0.06, 0.035, detail) for x in (-0.085, 0.085)]
    return merge(parts)


def man(detail: float) -> Mesh:
    """Return a man in a long coat and a hat, 1.88 m tall, his hands in his pockets."""
    parts = [_turned(COAT, BODY_DEPTH, detail), _turned(MANS_HEAD, HEAD_DEPTH, detail)]
    for side in (-1, 1):
        elbow = (0.33 * side, 1.16, -0.05)
        parts.append(limb((0.225 * side, 1.45, 0), elbow, 0.07, 0.055, detail))
        parts.append(limb(elbow, (0.22 * side, 0.95, 0.09), 0.055, 0.045, detail))
        parts.append(limb((0.1 * side, 0.5, 0), (0.1 * side, 0.06, 0), 0.085, 0.055, detail))
    return merge(parts)


def hand(wrist: Vector, detail: float) -> Mesh:
    """Return a spread hand above `wrist`: its palm faces +z and its fingers point up."""
    x, y, z = wrist
    palm = (x, y + 0.05, z)
    parts = [limb(wrist, palm, 0.026, 0.034, detail)]
    for angle, length in FINGERS:
        root = (palm[0] + 0.035 * math.sin(2.4 * angle), palm[1] + 0.02 * math.cos(angle), z)
        tip = (root[0] + length * math.sin(angle), root[1] + length * math.cos(angle), z)
        parts.append(limb(root, tip, 0.0105, 0.0085, detail))
    return merge(parts)


def limb(start: Vector, end: Vector, first: float, last: float, detail: float) -> Mesh:
    """Return a round limb with round ends, of radius `first` at `start` and `last` at `end`."""
    axis = np.subtract(end, start).astype(np.float64)
    length = float(np.linalg.norm(axis))
    bow = np.linspace(0, math.pi / 2, divisions(4, detail, 2) + 1)
    below = np.stack([first * np.sin(bow), -first * np.cos(bow)], axis=1)
    above = np.stack([last * np.cos(bow), length + last * np.sin(bow)], axis=1)
    below[0, 0] = above[-1, 0] = 0.0
    mesh = lathe(np.concatenate([below, above]), divisions(14, detail, 6))
    return transform(mesh, translation(start) @ _turn_to(axis / length))


def _turned(outline: Outline, depth: float, detail: float) -> Mesh:
    """Return an outline turned about the y axis and flattened along z by `depth`."""
    profile = smooth_curve(outline, divisions(44, detail, 12))
    return transform(lathe(profile, divisions(28, detail, 8)), scaling((1, 1, depth)))


def _turn_to(direction: Floats) -> Floats:
    """Return the rotation, shape (4, 4), that maps +y to the unit vector `direction`."""
    sideways = np.cross([0.0, 1.0, 0.0], direction)
    if np.linalg.norm(sideways) < 1e-9:
        return np.eye(4) if direction[1] > 0 else rotation((1, 0, 0), math.pi)
    return rotation(as_vector(sideways), math.acos(float(direction[1])))

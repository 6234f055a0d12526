"""Standing people as simple figures: turned bodies and heads, hair, hats and limbs.

Meters, y up. They stand at the origin and face +z.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from oitbench.modeling.detail import divisions
from oitbench.modeling.mesh import lathe, sphere
from oitbench.modeling.placement import merge, rotation, scaling, transform, translation
from oitbench.modeling.profiles import smooth_curve
from oitbench.scene import Floats, Material, Mesh, Object, Vector, as_vector

Outline = list[tuple[float, float]]
"""Points (half width, height) from the lowest to the highest, meters."""

DRESS: Outline = [
    (0.0, 0.46), (0.27, 0.46), (0.27, 0.48), (0.20, 0.75), (0.185, 0.92), (0.12, 1.10),
    (0.145, 1.27), (0.18, 1.37), (0.17, 1.42), (0.06, 1.45), (0.0, 1.46),
]  # fmt: skip
COAT: Outline = [
    (0.0, 0.34), (0.27, 0.34), (0.27, 0.37), (0.23, 0.75), (0.195, 1.02), (0.22, 1.20),
    (0.245, 1.40), (0.235, 1.50), (0.10, 1.54), (0.08, 1.58), (0.0, 1.58),
]  # fmt: skip
WOMANS_FACE: Outline = [
    (0.0, 1.485), (0.04, 1.485), (0.065, 1.53), (0.082, 1.60), (0.078, 1.68), (0.05, 1.72),
    (0.0, 1.72),
]  # fmt: skip
MANS_FACE: Outline = [
    (0.0, 1.565), (0.05, 1.565), (0.074, 1.61), (0.087, 1.68), (0.082, 1.76), (0.05, 1.80),
    (0.0, 1.80),
]  # fmt: skip
WOMANS_HAT: Outline = [
    (0.0, 1.680), (0.10, 1.672), (0.225, 1.655), (0.23, 1.665), (0.12, 1.688), (0.112, 1.755),
    (0.07, 1.785), (0.0, 1.780),
]  # fmt: skip
MANS_HAT: Outline = [
    (0.0, 1.765), (0.10, 1.757), (0.19, 1.740), (0.195, 1.750), (0.118, 1.770), (0.110, 1.855),
    (0.075, 1.885), (0.0, 1.870),
]  # fmt: skip
BODY_DEPTH, HEAD_DEPTH, HAT_DEPTH = 0.62, 1.18, 1.12
"""Depth of bodies, heads and hats from front to back, in units of their width."""
# Direction of each finger in the plane of the palm, radians from straight up, and length in meters.
FINGERS = ((-0.95, 0.055), (-0.28, 0.075), (-0.08, 0.085), (0.10, 0.08), (0.30, 0.062))
SKIN = Material(albedo=(0.62, 0.40, 0.29))
HAIR = Material(albedo=(0.10, 0.055, 0.03))


@dataclass(frozen=True)
class Figure:
    """A person in three meshes, one for each paint.

    Parameters
    ----------
    clothes, skin, hair : Mesh
        The hat belongs to the clothes.
    """

    clothes: Mesh
    skin: Mesh
    hair: Mesh

    def whole(self) -> Mesh:
        """Return all parts as one mesh, as for a statue."""
        return merge([self.clothes, self.skin, self.hair])

    def transformed(self, matrix: Floats) -> Figure:
        """Return the figure under an affine (4, 4) matrix."""
        return Figure(*(transform(part, matrix) for part in (self.clothes, self.skin, self.hair)))

    def objects(self, name: str, clothes: Material) -> tuple[Object, ...]:
        """Return the figure's objects, with clothes of one material: `name`, skin and hair."""
        return (
            Object(name, self.clothes, clothes),
            Object(f"{name}'s skin", self.skin, SKIN),
            Object(f"{name}'s hair", self.hair, HAIR),
        )


def woman(detail: float) -> Figure:
    """Return a woman in a dress and a hat with a wide brim, 1.78 m tall, arms at her sides."""
    arms = []
    for side in (-1, 1):
        elbow = (0.26 * side, 1.12, -0.01)
        arms.append(limb((0.17 * side, 1.38, 0), elbow, 0.05, 0.036, detail))
        arms.append(limb(elbow, (0.24 * side, 0.88, 0.06), 0.036, 0.028, detail))
    figure = woman_without_arms(detail)
    return Figure(figure.clothes, merge([figure.skin, *arms]), figure.hair)


def woman_without_arms(detail: float) -> Figure:
    """Return the same woman, to whom other arms can be added; shoulders are at (±0.17, 1.38, 0)."""
    clothes = [_turned(DRESS, BODY_DEPTH, detail), _turned(WOMANS_HAT, HAT_DEPTH, detail)]
    skin = [
        _turned(WOMANS_FACE, HEAD_DEPTH, detail),
        limb((0, 1.42, -0.01), (0, 1.54, -0.005), 0.046, 0.044, detail),
        limb((0, 1.615, 0.088), (0, 1.588, 0.102), 0.009, 0.011, detail),
        *(limb((x, 0.6, 0), (x, 0.06, 0), 0.06, 0.035, detail) for x in (-0.085, 0.085)),
    ]
    hair = [
        _ball((0, 1.62, -0.033), (0.104, 0.105, 0.098), detail),
        limb((0, 1.58, -0.045), (0, 1.48, -0.05), 0.104, 0.088, detail),
    ]
    return Figure(merge(clothes), merge(skin), merge(hair))


def man(detail: float) -> Figure:
    """Return a man in a long coat and a hat, 1.88 m tall, his hands in his pockets."""
    clothes = [_turned(COAT, BODY_DEPTH, detail), _turned(MANS_HAT, HAT_DEPTH, detail)]
    for side in (-1, 1):
        elbow = (0.33 * side, 1.16, -0.05)
        clothes.append(limb((0.225 * side, 1.45, 0), elbow, 0.07, 0.055, detail))
        clothes.append(limb(elbow, (0.22 * side, 0.95, 0.09), 0.055, 0.045, detail))
        clothes.append(limb((0.1 * side, 0.5, 0), (0.1 * side, 0.06, 0), 0.085, 0.055, detail))
    skin = [
        _turned(MANS_FACE, HEAD_DEPTH, detail),
        limb((0, 1.50, -0.01), (0, 1.62, -0.005), 0.058, 0.056, detail),
        limb((0, 1.695, 0.093), (0, 1.665, 0.108), 0.011, 0.014, detail),
    ]
    hair = _ball((0, 1.70, -0.026), (0.094, 0.085, 0.096), detail)
    return Figure(merge(clothes), merge(skin), hair)


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


def _ball(center: Vector, radii: Vector, detail: float) -> Mesh:
    """Return an ellipsoid; lengths in meters."""
    ball = sphere((0, 0, 0), 1.0, divisions(20, detail, 8), divisions(12, detail, 5))
    return transform(ball, translation(center) @ scaling(radii))


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

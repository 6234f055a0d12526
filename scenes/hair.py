"""A head of 50,000 wavy strands, each of them thinner than a pixel, around the bust of a woman.

Stands for scene HAIR in figures 1 (middle), 6 and 7 and table 1 of Salvi et al. 2011, "Adaptive
Transparency", and for figure 22 of McGuire & Mara 2017, "Phenomenological Transparency".

Parameters
----------
detail : float
    Factor on the number of strands, which are 50,000 at detail 1; fewer strands have fewer
    segments and are wider.
alpha : float
    Coverage of a strand where it fills a pixel, in [0, 1].
seed : int
    Seed of the strands.
near : float
    Distance of the near plane from the camera, m. The hair begins at 1.32 m.

Hundreds of strands lie behind each other at the silhouette, and all of them within 0.25 m of depth:
weights that fall with distance hardly differ. Hair soon hides what is behind it, so that the first
twenty layers matter and the order of the strands in the mesh, which is random, does not help. Light
is baked in: diffuse light, two shifted highlights for the main camera, and the shadow
that hair casts on itself and on the bust.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from oitbench.modeling.baking import Rig, diffuse, normals_of, with_radiance
from oitbench.modeling.detail import DETAIL, copies, divisions
from oitbench.modeling.mesh import sphere
from oitbench.modeling.props.bust import bust
from oitbench.modeling.props.hairstyle import grow
from oitbench.modeling.voxels import Voxels, density
from oitbench.parameters import Parameter
from oitbench.scene import (
    RGB,
    WHITE,
    Camera,
    Floats,
    Material,
    Mesh,
    Object,
    Scene,
    Strands,
    Vector,
    unit,
)

subject = "hair"
quick = False
near = 1.2
crops = {"ends": (0.1, 0.55, 0.32, 0.36), "fringe": (0.36, 0.05, 0.32, 0.32)}
parameters = {
    "detail": DETAIL,
    "alpha": Parameter(0.5, low=0.0, high=1.0, help="coverage of a strand that fills a pixel"),
    "seed": Parameter(1, low=0, help="seed of the strands"),
}

STRANDS, POINTS = 50_000, 30
WIDTH = 0.00024
"""Width of a strand, meters. In a picture that is 720 pixels high, a pixel is 0.0006 wide: strands
are drawn that wide, and cover 0.4 alpha of it."""
CAMERA = Camera(position=(-0.62, 0.02, 1.30), target=(0.004, -0.061, 0.0), fov_y=math.radians(17.0))
VIEWS = {
    "front": replace(CAMERA, position=(0.05, 0.0, 1.44)),
    "side": replace(CAMERA, position=(-1.42, 0.02, 0.10)),
}
KEY = Rig((-0.25, 0.75, 0.70), (0.98, 0.86, 0.72), (0.22, 0.25, 0.31), (0.10, 0.08, 0.07))
RIM: Vector = (0.75, 0.55, -0.55)
RIM_LIGHT: RGB = (1.0, 1.05, 1.15)
LIPS: RGB = (0.70, 0.34, 0.29)
ROOM = 3.0
"""Radius of the backdrop, meters."""
SKIN: RGB = (0.78, 0.52, 0.41)
# Reflectance of the hair from the darkest to the lightest strand.
DARK, LIGHT = np.array([0.16, 0.062, 0.022]), np.array([0.62, 0.30, 0.12])
# The box of the hair, meters.
LOW, HIGH = (-0.2, -0.36, -0.2), (0.2, 0.17, 0.17)
CELL = 0.006
THICKNESS = 2.2e-4  # effective width in meters by which a strand dims light


def build(*, name: str, detail: float, alpha: float, seed: int) -> Scene:
    """Return the backdrop, the bust and the hair."""
    count = copies(STRANDS, detail)
    random = np.random.default_rng(seed)
    curves = grow(random, count, divisions(POINTS, detail, 6))
    share = STRANDS / count
    shadows = _Shadows(curves, share)
    shades = _shades(random, curves, shadows)
    strands = Strands(curves, WIDTH * share, shades)
    objects = (
        Object("backdrop", _backdrop(), Material(emission=WHITE)),
        Object("bust", _bust(detail, shadows), Material(emission=WHITE)),
        Object("hair", strands, Material(coverage=alpha, emission=WHITE)),
    )
    return Scene(name, CAMERA, objects, views=VIEWS)


class _Shadows:
    """The light that the hair lets pass, from its length per volume."""

    def __init__(self, curves: Floats, share: float) -> None:
        middles = (curves[:, 1:] + curves[:, :-1]).reshape(-1, 3) / 2
        lengths = np.linalg.norm(np.diff(curves, axis=1), axis=2).ravel() * share
        hair = density(middles, lengths * THICKNESS, LOW, HIGH, CELL)
        self._key = hair.integral_toward(KEY.direction)
        self._rim = hair.integral_toward(RIM)
        up = [
            hair.integral_toward(way).values
            for way in ((0, 1, 0.3), (-0.8, 0.3, 0.5), (0.8, 0.3, 0.5))
        ]
        self._sky = Voxels(LOW, HIGH, np.mean([np.exp(-0.7 * depth) for depth in up], axis=0))

    def key(self, points: Floats) -> Floats:
        return np.exp(-self._key.at(points))[..., None]

    def rim(self, points: Floats) -> Floats:
        return np.exp(-self._rim.at(points))[..., None]

    def sky(self, points: Floats) -> Floats:
        return self._sky.at(points)[..., None]


def _shades(random: np.random.Generator, curves: Floats, shadows: _Shadows) -> Floats:
    """Return the radiance of each point of the strands, shape (n, k, 3).

    References
    ----------
    Kajiya & Kay 1989, "Rendering fur with three dimensional textures"; Scheuermann 2004, "Practical
    real-time hair rendering and shading": two shifted highlights.
    """
    count, length = curves.shape[:2]
    along = unit(np.gradient(curves, axis=1))
    to_eye = unit(np.asarray(CAMERA.position) - curves)
    tone = np.clip(random.normal(0.36, 0.16, (count, 1, 1)), 0, 1)
    tone = np.clip(tone + 0.28 * np.linspace(-0.6, 1, length)[None, :, None], 0, 1)
    color = DARK + (LIGHT - DARK) * tone
    shift = 0.09 * random.normal(size=(count, 1))
    key_sky = np.asarray(KEY.sky)
    sky = shadows.sky(curves)
    total = color * (0.30 + 0.70 * sky) * key_sky * sky * 1.6
    for direction, light, lit in (
        (KEY.direction, np.asarray(KEY.key), shadows.key(curves)),
        (unit(np.asarray(RIM)), np.asarray(RIM_LIGHT), shadows.rim(curves)),
    ):
        sine = np.sqrt(np.maximum(1 - (along @ direction) ** 2, 0))[..., None]
        half = unit(direction + to_eye)
        across = (along * half).sum(axis=2)
        first = _lobe(across - 0.06 + shift, 60)[..., None] * 0.26
        second = _lobe(across + 0.10 + shift, 14)[..., None] * 1.25 * color
        total = total + light * lit * (0.75 * color * sine + first + second)
    return np.asarray(total)


def _lobe(cosine: Floats, exponent: float) -> Floats:
    return np.asarray(np.maximum(1 - cosine**2, 0) ** (exponent / 2))


def _bust(detail: float, shadows: _Shadows) -> Mesh:
    """Return the bust in the shadow of the hair."""
    body = bust(0.0042 / max(min(detail, 1.0), 0.02) ** 0.5)
    normals = normals_of(body)
    outside = body.positions + 0.006 * normals
    light = diffuse(normals, KEY, shadows.key(outside), shadows.sky(outside))
    rim = np.maximum(normals @ unit(np.asarray(RIM)), 0)[:, None] * shadows.rim(outside)
    lips = np.exp(
        -((np.abs(body.positions - [0, -0.0635, 0.08]) / [0.021, 0.010, 0.02]) ** 4).sum(axis=1)
    )
    paint = SKIN + (np.asarray(LIPS) - SKIN) * lips[:, None]
    return with_radiance(body, paint * (light + 0.5 * rim * np.asarray(RIM_LIGHT)))


def _backdrop() -> Mesh:
    """Return walls all around, which are lighter behind the head."""
    walls = sphere((0.0, 0.0, 0.0), ROOM, 64, 48)
    height = walls.positions[:, 1:2] / ROOM
    glow = np.exp(-(((height + 0.03) / 0.16) ** 2))
    return with_radiance(walls, [0.07, 0.08, 0.095] + glow * [0.17, 0.18, 0.19])

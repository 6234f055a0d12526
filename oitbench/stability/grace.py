"""Scenes at the limits of what surfaces and lights may be: no formula may divide by them."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

import numpy as np

from oitbench.modeling.mesh import quad, sphere
from oitbench.scene import (
    WHITE,
    Camera,
    EnvironmentLight,
    Light,
    Material,
    Mesh,
    Object,
    Scene,
    SpotLight,
)
from oitbench.stability.check import Bound, Check, Compare, Comparison, Photo, Picture
from oitbench.stability.layers import BACKGROUND, GREEN, RED

_SIZE = (32, 32)
_CAMERA = Camera((0, 0, 0), (0, 0, -1), fov_y=math.radians(40))
_WALL = 4.0
"""Distance of the wall from the camera, metres."""


def graceful() -> Iterable[Check]:
    """Yield the cases; where nothing else is right, pixels must at least be finite."""
    nothing = Material(transmission=WHITE, specular=0.0, collimation=0.0)
    yield _case(
        "perfect diffuser",
        "glass of α = 1, t = 1, N = 1 and c = 0 before an even wall shows the wall",
        _shown(nothing),
        _as_opaque,
    )
    veil = Material(coverage=0.5, emission=RED, specular=0.0)
    yield _case(
        "on the near plane",
        "a sheet on the near plane hides half of the wall",
        _shown(veil, _CAMERA.near * (1 + 1e-6)),
        _as_exact,
    )
    away = SpotLight((0, 0, -3), (0, 0, 10), WHITE, math.radians(10))
    yield _case(
        "light on nothing",
        "a light with nothing in its cone changes nothing",
        _shown(Material(coverage=0.5, albedo=GREEN, emission=RED, specular=0.0), lights=(away,)),
        _as_exact,
    )
    glass = Material(
        transmission=(0.9, 0.5, 0.1), roughness=0.0, index=1.5, collimation=0.5, solid=True
    )
    yield _case(
        "camera in glass",
        "glass round the camera leaves every pixel finite",
        _before_wall(sphere((0, 0, 0), 1.0, 24, 12), glass, (EnvironmentLight(),)),
        _finite,
    )
    inside = SpotLight((0, 0, -2), (0, 0, -_WALL), (9.0, 9.0, 9.0), math.radians(60))
    ball = sphere((0, 0, -2), 0.5, 24, 12)
    yield _case(
        "light in glass",
        "a light within glass leaves every pixel finite",
        _before_wall(ball, glass, (inside,)),
        _finite,
    )
    on_surface = SpotLight((0, 0, -1), (0, 0, -2), WHITE, math.radians(60))
    yield _case(
        "light on a surface",
        "a light in the very plane of a sheet leaves every pixel finite",
        _shown(Material(coverage=0.5, albedo=WHITE, index=1.5), 1.0, (on_surface,)),
        _finite,
    )


def _case(id_: str, sentence: str, scene: Scene, compare: Compare) -> Check:
    return Check(id_, sentence, (Picture(scene, _SIZE),), compare, exact=compare is _as_exact)


def _shown(material: Material, z: float = 2.0, lights: tuple[Light, ...] = ()) -> Scene:
    """Return a sheet at distance `z` that fills the view."""
    return _before_wall(quad((0, 0, -z), (z, 0, 0), (0, z, 0)), material, lights)


def _before_wall(mesh: Mesh, material: Material, lights: tuple[Light, ...]) -> Scene:
    wall = quad((0, 0, -_WALL), (_WALL, 0, 0), (0, _WALL, 0))
    paint = Material(emission=BACKGROUND, albedo=(0.5, 0.5, 0.5), specular=0.0)
    objects = (Object("wall", wall, paint), Object("glass", mesh, material))
    return Scene("limits", _CAMERA, objects, lights=lights)


def _as_opaque(photos: Sequence[Photo]) -> Iterable[Comparison]:
    yield Comparison(photos[0].image, photos[0].opaque, bound=Bound.DISPLAY)


def _as_exact(photos: Sequence[Photo]) -> Iterable[Comparison]:
    exact = photos[0].exact
    assert exact is not None
    yield Comparison(photos[0].image, exact, bound=Bound.DISPLAY)


def _finite(photos: Sequence[Photo]) -> Iterable[Comparison]:
    finite = np.isfinite(photos[0].image)
    yield Comparison(finite, np.ones_like(finite), bound=Bound.EQUAL)

"""Hard cases at the limits of materials and lights, by which no formula may divide."""

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
from oitbench.stability.check import Bound, Check, Expect, Expectation, Rendering, Shot
from oitbench.stability.layers import BACKGROUND, GREEN, RED

_SIZE = (32, 32)
_CAMERA = Camera((0, 0, 0), (0, 0, -1), fov_y=math.radians(40))
_WALL = 4.0
"""Distance of the wall from the camera, in meters."""


def cases() -> Iterable[Check]:
    """Yield the cases. Where no image is known to be right, all pixels must be finite."""
    nothing = Material(transmission=WHITE, specular=0.0, collimation=0.0)
    yield _case(
        "perfect diffuser",
        "glass with α = 1, t = 1, N = 1 and c = 0 shows the uniform wall behind it",
        _sheet(nothing),
        _as_opaque,
    )
    veil = Material(coverage=0.5, emission=RED, specular=0.0)
    yield _case(
        "on the near plane",
        "a sheet with α = 1/2 on the near plane is composited as elsewhere",
        _sheet(veil, _CAMERA.near * (1 + 1e-6)),
        _as_exact,
    )
    away = SpotLight((0, 0, -3), (0, 0, 10), WHITE, math.radians(10))
    yield _case(
        "light on nothing",
        "a light with nothing in its cone changes nothing",
        _sheet(Material(coverage=0.5, albedo=GREEN, emission=RED, specular=0.0), lights=(away,)),
        _as_exact,
    )
    glass = Material(
        transmission=(0.9, 0.5, 0.1), roughness=0.0, index=1.5, collimation=0.5, solid=True
    )
    yield _case(
        "camera in glass",
        "all pixels are finite when the camera is inside glass",
        _before_wall(sphere((0, 0, 0), 1.0, 24, 12), glass, (EnvironmentLight(),)),
        _finite,
    )
    inside = SpotLight((0, 0, -2), (0, 0, -_WALL), (9.0, 9.0, 9.0), math.radians(60))
    ball = sphere((0, 0, -2), 0.5, 24, 12)
    yield _case(
        "light in glass",
        "all pixels are finite when a light is inside glass",
        _before_wall(ball, glass, (inside,)),
        _finite,
    )
    on_surface = SpotLight((0, 0, -1), (0, 0, -2), WHITE, math.radians(60))
    yield _case(
        "light on a surface",
        "all pixels are finite when a light lies exactly on a sheet",
        _sheet(Material(coverage=0.5, albedo=WHITE, index=1.5), 1.0, (on_surface,)),
        _finite,
    )


def _case(name: str, sentence: str, scene: Scene, expect: Expect) -> Check:
    return Check(name, sentence, (Shot(scene, _SIZE),), expect, exact=expect is _as_exact)


def _sheet(material: Material, z: float = 2.0, lights: tuple[Light, ...] = ()) -> Scene:
    """Return a sheet at distance `z` that fills the view."""
    return _before_wall(quad((0, 0, -z), (z, 0, 0), (0, z, 0)), material, lights)


def _before_wall(mesh: Mesh, material: Material, lights: tuple[Light, ...]) -> Scene:
    wall = quad((0, 0, -_WALL), (_WALL, 0, 0), (0, _WALL, 0))
    paint = Material(emission=BACKGROUND, albedo=(0.5, 0.5, 0.5), specular=0.0)
    objects = (Object("wall", wall, paint), Object("glass", mesh, material))
    return Scene("limits", _CAMERA, objects, lights=lights)


def _as_opaque(renderings: Sequence[Rendering]) -> Iterable[Expectation]:
    yield Expectation(renderings[0].image, renderings[0].opaque, bound=Bound.DISPLAY)


def _as_exact(renderings: Sequence[Rendering]) -> Iterable[Expectation]:
    exact = renderings[0].exact
    assert exact is not None
    yield Expectation(renderings[0].image, exact, bound=Bound.DISPLAY)


def _finite(renderings: Sequence[Rendering]) -> Iterable[Expectation]:
    finite = np.isfinite(renderings[0].image)
    yield Expectation(finite, np.ones_like(finite), bound=Bound.EQUAL)

"""The identity that refraction and diffusion do not depend on the resolution."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from oitbench.effects import Effect
from oitbench.image.files import box_downsample
from oitbench.method.declaration import Method
from oitbench.modeling.mesh import grid, quad
from oitbench.scene import WHITE, Camera, Material, Object, Scene
from oitbench.stability.check import Bound, Check, Expectation, Rendering, Shot, identity

_WIDTH, _HEIGHT = 64, 48
"""Pixels of the smaller image; the larger one has twice as many in each direction."""
_ANGLE = math.radians(40)
_NEAR, _FAR = 1.6, 4.0
"""Distances of the sheet and of the wall from the camera, in meters."""
_MARGIN = 1.2
"""Size of the wall relative to the view, so that refracted rays end on the wall."""
_CELLS = 8
"""Columns of the wall; the valley is two cells wide, wider than the largest blur."""
_MISPLACED = 1.0
"""Pixels of the smaller image by which rounding may move light: half a pixel in it, half a pixel in
the larger image where a kernel begins, and a quarter of a pixel where the steps of offsets are half
a pixel. An offset or a blur of a fixed number of pixels moves light by more: by half of the
refraction, or by half of the blur's mean reach."""
_MATERIALS: tuple[dict[str, Any], ...] = (
    {"index": 1.5, "solid": True},
    {"collimation": 0.1},
    {"index": 1.5, "solid": True, "collimation": 0.1},
)
"""Materials that refract, diffuse, and do both."""


def resolution_independent() -> Check:
    """Return the check: a tilted sheet in front of two walls, at two resolutions.

    The first wall has a dark valley with constant slopes: an error of one pixel in position or in
    width changes the image by one slope at most. The second wall has one edge: the light that is
    moved over it, summed along a row, is the number of pixels by which it is moved.
    """
    slope = _CELLS / (_MARGIN * _WIDTH)
    scenes = [_valley(kind) for kind in _MATERIALS] + [_edge(kind) for kind in _MATERIALS[:2]]

    def expect(renderings: Sequence[Rendering]) -> Iterable[Expectation]:
        pairs = list(zip(renderings[::2], renderings[1::2], strict=True))
        for small, large in pairs[: len(_MATERIALS)]:
            halved = box_downsample(large.image, 2)
            yield Expectation(halved, small.image, slack=_MISPLACED * slope)
        for small, large in pairs[len(_MATERIALS) :]:
            found, expected = (np.full((1, 1, 1), reach(item)) for item in (large, small))
            yield Expectation(found / 2, expected, bound=Bound.EQUAL, slack=_MISPLACED)

    shots = (Shot(scene, (k * _WIDTH, k * _HEIGHT)) for scene in scenes for k in (1, 2))
    return identity("resolution_independent", shots, expect, exemption=_without_refraction)


def reach(rendering: Rendering) -> float:
    """Return by how many pixels the method moves light horizontally, averaged over rows."""
    moved = np.abs(rendering.image - rendering.opaque)
    return float(moved.sum(axis=1).mean())


def _valley(kind: dict[str, Any]) -> Scene:
    """Return a sheet in front of a white wall with a valley that is black in its middle."""
    half = _MARGIN * _FAR * math.tan(_ANGLE / 2)
    aspect = _WIDTH / _HEIGHT
    wall = grid((0, 0, -_FAR), (half * aspect, 0, 0), (0, half, 0), columns=_CELLS)
    slope = _CELLS / (2 * half * aspect)
    rising = np.minimum(slope * np.abs(wall.positions[:, :1]), np.float32(1))
    wall = replace(wall, radiance=np.repeat(rising, 3, axis=1))
    tilt = 0.3
    right = (_FAR * math.cos(tilt), 0.0, _FAR * math.sin(tilt))
    return _behind_sheet("valley", right, kind, Object("wall", wall, Material(emission=WHITE)))


def _edge(kind: dict[str, Any]) -> Scene:
    """Return a sheet in front of a wall whose left half is black and whose right half is white.

    Parameters
    ----------
    kind : dict
        Parameters of the sheet's `Material`.
    """
    right, up = (_FAR, 0.0, 0.0), (0.0, _FAR, 0.0)
    white = Object("white", quad((_FAR, 0, -_FAR), right, up), Material(emission=WHITE))
    black = Object("black", quad((-_FAR, 0, -_FAR), right, up), Material())
    return _behind_sheet("edge", (4.0, 0.0, 1.2), kind, black, white)


def _behind_sheet(
    name: str, right: tuple[float, float, float], kind: dict[str, Any], *walls: Object
) -> Scene:
    sheet = quad((0, 0, -_NEAR), right, (0, _FAR, 0))
    glass = Object("sheet", sheet, Material(transmission=WHITE, specular=0.0, **kind))
    return Scene(name, Camera((0, 0, 0), (0, 0, -1), fov_y=_ANGLE), (*walls, glass))


def _without_refraction(method: Method) -> str:
    shown = method.expresses & (Effect.REFRACTION | Effect.DIFFUSION)
    return "" if shown else "the method shows neither refraction nor diffusion"

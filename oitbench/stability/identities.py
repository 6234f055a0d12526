"""The identities U1 to U12 that methods may promise in `holds`, as pictures and comparisons."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np

from oitbench.effects import Effect
from oitbench.image.files import box_downsample
from oitbench.measure.oracle import composite, transmittances
from oitbench.measure.visibility import curve_of, instrument
from oitbench.method.declaration import Method
from oitbench.modeling.mesh import grid, quad
from oitbench.scene import BLACK, RGB, WHITE, Camera, FragmentLists, Material, Object, Scene
from oitbench.stability.check import Bound, Check, Compare, Comparison, Photo, Picture
from oitbench.stability.layers import (
    BACKGROUND,
    BLUE,
    GREEN,
    RED,
    SIDE,
    Layer,
    random_lists,
    scene_of,
    stack,
)

PERMUTATIONS = 16
_MARGIN = 1.2
"""How much larger than the view the wall of U12 is: bent rays shall end on it."""
_CELLS = 8
"""Columns of that wall; the valley is two cells wide, so that blurs of the suite's size fit in."""
_MISPLACED = 1.0
"""Pixels of the smaller picture by which rounding may move light: at most half a pixel in it and
half one in the larger where a kernel begins, and a quarter of one where steps of offsets are half a
pixel. What does not scale at all moves light by more: half of the blur's mean reach, or of the
bend."""


@cache
def identities() -> tuple[Check, ...]:
    """Return the identities in their order."""
    return (
        _without_transparency(),
        _truthful("single_layer_exact", "one layer gives αL + (1 − α)C0", random_lists(1)),
        _truthful(
            "colored_layer_exact",
            "one layer of colored glass gives αL + τC0",
            random_lists(1, tinted=True),
            Effect.COLORED_TRANSMISSION,
        ),
        _identical_layers(),
        _permuted_draws(),
        _opaque_front(),
        _black_layers(),
        _layers_without_coverage(),
        _white_furnace(),
        _swapped_depths(),
        _scaled_radiance(),
        _falling_visibility(),
        _halved_resolution(),
    )


def _identity(id_: str, sentence: str, scenes: Sequence[Scene], compare: Compare) -> Check:
    pictures = tuple(Picture(scene) for scene in scenes)
    return Check(id_, sentence, pictures, compare, identity=True)


def _truthful(id_: str, sentence: str, lists: FragmentLists, needs: Effect = Effect.NONE) -> Check:
    expected = composite(lists, BACKGROUND)

    def compare(photos: Sequence[Photo]) -> Iterable[Comparison]:
        yield Comparison(photos[0].image, expected, len(lists.z))

    return replace(_identity(id_, sentence, [scene_of(lists)], compare), needs=needs)


def _without_transparency() -> Check:
    wall = Object("wall", quad((0, 0, -2), (0.5, 0, 0), (0, 0.5, 0)), Material(emission=BACKGROUND))
    scene = Scene("wall", Camera((0, 0, 0), (0, 0, -1)), (wall,), background=GREEN)

    def compare(photos: Sequence[Photo]) -> Iterable[Comparison]:
        yield Comparison(photos[0].image, photos[0].opaque, bound=Bound.EQUAL)

    sentence = "nothing transparent leaves the opaque picture as it is, bit for bit"
    return Check(
        "opaque_unchanged", sentence, (Picture(scene, (SIDE, SIDE)),), compare, identity=True
    )


def _identical_layers() -> Check:
    count, coverage, radiance = 8, 0.3, (0.9, 0.5, 0.1)
    layers = [Layer(z, coverage, radiance) for z in np.linspace(2, 5, count)]
    passed = (1 - coverage) ** count
    expected = np.multiply(radiance, 1 - passed) + np.multiply(BACKGROUND, passed)

    def compare(photos: Sequence[Photo]) -> Iterable[Comparison]:
        yield Comparison(photos[0].image, expected[None, None], count)

    sentence = "N equal layers at N depths give L(1 − (1 − α)^N) + C0(1 − α)^N"
    return _identity("equal_layers_exact", sentence, [scene_of(stack(layers))], compare)


def _permuted_draws() -> Check:
    scene, count = scene_of(random_lists(10, tinted=True)), 10
    pictures = [Picture(scene, permutation=seed) for seed in (None, *range(1, PERMUTATIONS + 1))]

    def compare(photos: Sequence[Photo]) -> Iterable[Comparison]:
        for photo in photos[1:]:
            yield Comparison(photo.image, photos[0].image, count)

    sentence = f"{PERMUTATIONS} random orders of the draws give one picture"
    return Check("order_independent", sentence, tuple(pictures), compare, identity=True)


def _opaque_front() -> Check:
    front = Layer(1.0, 1.0, (0.75, 0.5, 0.25))
    behind = [Layer(3.0, 0.5), Layer(2.0, 0.9, GREEN), Layer(4.0, 1.0, BLUE)]
    lists = [stack([*behind[:place], front, *behind[place:]]) for place in range(4)]

    def compare(photos: Sequence[Photo]) -> Iterable[Comparison]:
        for photo in photos:
            yield Comparison(photo.image, np.array(front.radiance)[None, None], 4)

    sentence = "an opaque front layer hides all behind it, whenever it is drawn"
    return _identity("opaque_front_hides", sentence, [scene_of(item) for item in lists], compare)


def _black_layers() -> Check:
    lists = random_lists(6)
    lists = replace(lists, radiance=np.zeros_like(lists.radiance))
    expected = np.asarray(BACKGROUND) * transmittances(lists).prod(axis=0)

    def compare(photos: Sequence[Photo]) -> Iterable[Comparison]:
        yield Comparison(photos[0].image, expected, 6)

    sentence = "black layers attenuate the background by Π(1 − α)"
    return _identity("total_transmittance_exact", sentence, [scene_of(lists)], compare)


def _layers_without_coverage() -> Check:
    some = [Layer(2.0, 0.4, RED), Layer(4.0, 0.6, GREEN)]
    clear = [Layer(z, 0.0) for z in np.linspace(1.5, 5.0, 20)]
    mixed = [clear[0], some[0], *clear[1:10], some[1], *clear[10:]]
    scenes = [scene_of(stack(layers)) for layers in (mixed, some, clear)]

    def compare(photos: Sequence[Photo]) -> Iterable[Comparison]:
        yield Comparison(photos[0].image, photos[1].image, bound=Bound.EQUAL)
        yield Comparison(photos[2].image, photos[2].opaque, bound=Bound.EQUAL)

    sentence = "layers with α = 0 change nothing, bit for bit"
    return _identity("zero_coverage_ignored", sentence, scenes, compare)


def _white_furnace() -> Check:
    lists = random_lists(6)
    lists = replace(lists, radiance=np.ones_like(lists.radiance))

    def compare(photos: Sequence[Photo]) -> Iterable[Comparison]:
        yield Comparison(photos[0].image, np.ones((1, 1, 3)), 6)

    sentence = "white layers before a white background vanish (white furnace)"
    return _identity("white_furnace", sentence, [scene_of(lists, WHITE)], compare)


def _swapped_depths() -> Check:
    near, far = Layer(2.0, 0.5, RED), Layer(4.0, 0.5, BLUE)
    pair = stack([near, far]), stack([replace(near, z=far.z), replace(far, z=near.z)])

    def compare(photos: Sequence[Photo]) -> Iterable[Comparison]:
        for photo, lists in zip(photos, pair, strict=True):
            yield Comparison(photo.image, composite(lists, BACKGROUND), 2)

    sentence = "two layers that swap depths swap their shares, the draws as before"
    return _identity("two_layers_ordered", sentence, [scene_of(lists) for lists in pair], compare)


def _scaled_radiance() -> Check:
    lists, factor = random_lists(4), 3.0
    brighter = replace(lists, radiance=lists.radiance * np.float32(factor))
    red, green, blue = BACKGROUND
    background: RGB = (red * factor, green * factor, blue * factor)

    def compare(photos: Sequence[Photo]) -> Iterable[Comparison]:
        yield Comparison(photos[1].image / factor, photos[0].image, 8)

    sentence = f"radiance times {factor:g} everywhere gives the picture times {factor:g}"
    return _identity(
        "scales_with_radiance", sentence, [scene_of(lists), scene_of(brighter, background)], compare
    )


def _falling_visibility() -> Check:
    # Rows repeat the measurement, for methods whose pixels are random.
    depths = (2.0, 2.5, 3.0, 3.5, 4.5, 5.5)
    black = stack([Layer(z, 0.35, BLACK) for z in depths], 1, 1)
    scene = scene_of(instrument(black, rows=SIDE), BLACK)

    def compare(photos: Sequence[Photo]) -> Iterable[Comparison]:
        values, noise = curve_of(photos[0].image, len(depths))
        falling = np.minimum.accumulate(np.clip(values, 0, 1), axis=0)
        yield Comparison(values[None], falling[None], len(depths), noise=2 * float(noise.max()))

    sentence = "visibility lies in [0, 1] and never rises with depth"
    return _identity("visibility_monotonic", sentence, [scene], compare)


def _halved_resolution() -> Check:
    """Bend, blur, and do both, before a wall with a dark valley of constant slopes.

    An error of a pixel in position or width then changes the picture by one slope at most.
    """
    width, height = 64, 48
    frosted, bending = {"collimation": 0.1}, {"index": 1.5, "solid": True}
    scenes = [
        _before_valley(width / height, **kind) for kind in (bending, frosted, frosted | bending)
    ]
    slope = _CELLS / (_MARGIN * width)

    def compare(photos: Sequence[Photo]) -> Iterable[Comparison]:
        for large, small in zip(photos[1::2], photos[::2], strict=True):
            halved = box_downsample(large.image, 2)
            yield Comparison(halved, small.image, slack=_MISPLACED * slope)

    pictures = [Picture(scene, (k * width, k * height)) for scene in scenes for k in (1, 2)]
    sentence = "halving the resolution halves refraction and diffusion in pixels"
    return Check(
        "resolution_independent",
        sentence,
        tuple(pictures),
        compare,
        excuse=_without_refraction,
        identity=True,
    )


def _before_valley(aspect: float, **kind: Any) -> Scene:
    """Return a turned sheet before a wall that is white but for a valley, black in the middle."""
    angle, tilt, near, far = math.radians(40), 0.3, 1.6, 4.0
    half = _MARGIN * far * math.tan(angle / 2)
    wall = grid((0, 0, -far), (half * aspect, 0, 0), (0, half, 0), columns=_CELLS)
    slope = _CELLS / (2 * half * aspect)
    rising = np.minimum(slope * np.abs(wall.positions[:, :1]), np.float32(1))
    wall = replace(wall, radiance=np.repeat(rising, 3, axis=1))
    right = (far * math.cos(tilt), 0.0, far * math.sin(tilt))
    sheet = quad((0, 0, -near), right, (0, far, 0))
    glass = Material(transmission=WHITE, specular=0.0, **kind)
    objects = (Object("wall", wall, Material(emission=WHITE)), Object("sheet", sheet, glass))
    return Scene("valley", Camera((0, 0, 0), (0, 0, -1), fov_y=angle), objects)


def _without_refraction(method: Method) -> str:
    shown = method.expresses & (Effect.REFRACTION | Effect.DIFFUSION)
    return "" if shown else "the method shows neither refraction nor diffusion"

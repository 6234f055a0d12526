"""The identities that methods may promise, each with its scenes and its expected images.

`oitbench.method.promises.PROMISES` states them in words.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from functools import cache

import numpy as np

from oitbench.effects import Effect
from oitbench.measure.oracle import composite, transmittances
from oitbench.measure.visibility import curve_of, instrument
from oitbench.modeling.mesh import quad
from oitbench.scene import BLACK, RGB, WHITE, Camera, FragmentLists, Material, Object, Scene
from oitbench.stability.check import Bound, Check, Expectation, Rendering, Shot, Values, identity
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
from oitbench.stability.resolution import resolution_independent

PERMUTATIONS = 16
"""Random orders of the draws that are compared with the order of submission."""


@cache
def identities() -> tuple[Check, ...]:
    """Return the identities in the order of `PROMISES`."""
    return (
        _opaque_unchanged(),
        _exact("single_layer_exact", random_lists(1)),
        _exact(
            "colored_layer_exact", random_lists(1, tinted=True), needs=Effect.COLORED_TRANSMISSION
        ),
        _equal_layers_exact(),
        _order_independent(),
        _opaque_front_hides(),
        _total_transmittance_exact(),
        _zero_coverage_ignored(),
        _white_furnace(),
        _two_layers_ordered(),
        _scales_with_radiance(),
        _visibility_monotonic(),
        resolution_independent(),
    )


def _exact(name: str, *lists: FragmentLists, needs: Effect = Effect.NONE) -> Check:
    """Return the identity that a method composites all `lists` exactly."""
    exact = [composite(item, BACKGROUND) for item in lists]

    def expect(renderings: Sequence[Rendering]) -> Iterable[Expectation]:
        for rendering, right, item in zip(renderings, exact, lists, strict=True):
            yield Expectation(rendering.image, right, len(item.z))

    return identity(name, (Shot(scene_of(item)) for item in lists), expect, needs=needs)


def wall() -> Scene:
    """Return an opaque wall that covers a part of the image, and nothing transparent."""
    paint = Material(emission=BACKGROUND)
    surface = Object("wall", quad((0, 0, -2), (0.5, 0, 0), (0, 0.5, 0)), paint)
    return Scene("wall", Camera((0, 0, 0), (0, 0, -1)), (surface,), background=GREEN)


def _opaque_unchanged() -> Check:
    def expect(renderings: Sequence[Rendering]) -> Iterable[Expectation]:
        (one,) = renderings
        yield Expectation(one.color, one.opaque_color, bound=Bound.EQUAL)

    return identity("opaque_unchanged", (Shot(wall(), (SIDE, SIDE)),), expect)


def _equal_layers_exact() -> Check:
    count, coverage, radiance = 8, 0.3, (0.9, 0.5, 0.1)
    apart = [Layer(z, coverage, radiance) for z in np.linspace(2, 5, count)]
    coincident = [Layer(3.0, coverage, radiance)] * count
    passed = (1 - coverage) ** count
    expected = np.multiply(radiance, 1 - passed) + np.multiply(BACKGROUND, passed)

    def expect(renderings: Sequence[Rendering]) -> Iterable[Expectation]:
        for rendering in renderings:
            yield Expectation(rendering.image, expected[None, None], count)

    shots = (Shot(scene_of(stack(layers))) for layers in (apart, coincident))
    return identity("equal_layers_exact", shots, expect)


def _order_independent() -> Check:
    scene, count = scene_of(random_lists(10, tinted=True)), 10

    def expect(renderings: Sequence[Rendering]) -> Iterable[Expectation]:
        first, *others = renderings
        for other in others:
            yield Expectation(other.image, first.image, count, Bound.TARGETS)

    seeds = (None, *range(1, PERMUTATIONS + 1))
    shots = (Shot(scene, permutation=seed) for seed in seeds)
    return identity("order_independent", shots, expect)


def _opaque_front_hides() -> Check:
    front = Layer(1.0, 1.0, (0.75, 0.5, 0.25))
    behind = [Layer(3.0, 0.5), Layer(2.0, 0.9, GREEN), Layer(4.0, 1.0, BLUE)]
    stacks = [[front], *([*behind[:place], front, *behind[place:]] for place in range(4))]

    def expect(renderings: Sequence[Rendering]) -> Iterable[Expectation]:
        alone, *others = renderings
        yield Expectation(alone.image, np.array(front.radiance)[None, None])
        for other in others:
            yield Expectation(other.image, alone.image, bound=Bound.EQUAL)

    shots = (Shot(scene_of(stack(layers))) for layers in stacks)
    return identity("opaque_front_hides", shots, expect)


def _total_transmittance_exact() -> Check:
    lists = random_lists(6)
    lists = replace(lists, radiance=np.zeros_like(lists.radiance))
    expected = np.asarray(BACKGROUND) * transmittances(lists).prod(axis=0)

    def expect(renderings: Sequence[Rendering]) -> Iterable[Expectation]:
        yield Expectation(renderings[0].image, expected, len(lists.z))

    return identity("total_transmittance_exact", (Shot(scene_of(lists)),), expect)


def _zero_coverage_ignored() -> Check:
    some = [Layer(2.0, 0.4, RED), Layer(4.0, 0.6, GREEN)]
    clear = [Layer(z, 0.0) for z in np.linspace(1.5, 5.0, 40)]
    mixed = [clear[0], some[0], *clear[1:20], some[1], *clear[20:]]

    def expect(renderings: Sequence[Rendering]) -> Iterable[Expectation]:
        with_clear, without_clear, only_clear = renderings
        yield Expectation(with_clear.image, without_clear.image, bound=Bound.EQUAL)
        yield Expectation(only_clear.image, only_clear.opaque, bound=Bound.EQUAL)

    shots = (Shot(scene_of(stack(layers))) for layers in (mixed, some, clear))
    return identity("zero_coverage_ignored", shots, expect)


def _white_furnace() -> Check:
    lists = random_lists(6)
    lists = replace(lists, radiance=np.ones_like(lists.radiance))

    def expect(renderings: Sequence[Rendering]) -> Iterable[Expectation]:
        yield Expectation(renderings[0].image, np.ones((1, 1, 3)), len(lists.z))

    return identity("white_furnace", (Shot(scene_of(lists, WHITE)),), expect)


def _two_layers_ordered() -> Check:
    near, far = Layer(2.0, 0.5, RED), Layer(4.0, 0.5, BLUE)
    swapped = [replace(near, z=far.z), replace(far, z=near.z)]
    return _exact("two_layers_ordered", stack([near, far]), stack(swapped))


def _scales_with_radiance() -> Check:
    lists, factor = random_lists(4), 3.0
    brighter = replace(lists, radiance=lists.radiance * np.float32(factor))
    red, green, blue = BACKGROUND
    background: RGB = (red * factor, green * factor, blue * factor)

    def expect(renderings: Sequence[Rendering]) -> Iterable[Expectation]:
        dim, bright = renderings
        # Both images are rounded: twice the layers.
        yield Expectation(bright.image / factor, dim.image, 2 * len(lists.z))

    shots = (Shot(scene_of(lists)), Shot(scene_of(brighter, background)))
    return identity("scales_with_radiance", shots, expect)


def _visibility_monotonic() -> Check:
    """Measure the visibility of six layers, and that of a probe which attenuates nothing."""
    depths = (2.0, 2.5, 3.0, 3.5, 4.5, 5.5)
    layers = stack([Layer(z, 0.35, BLACK) for z in depths], 1)

    def expect(renderings: Sequence[Rendering]) -> Iterable[Expectation]:
        # Rows repeat the measurement for methods with random pixels.
        values, noise = curve_of(renderings[0].image, len(depths))
        yield Expectation(
            values[None], _falling(values)[None], len(depths), noise=2 * float(noise.max())
        )
        values, noise = curve_of(renderings[1].image.swapaxes(0, 1), SIDE)
        yield Expectation(
            values[None], _falling(values)[None], bound=Bound.EQUAL, noise=2 * float(noise.max())
        )

    scenes = (scene_of(lists, BLACK) for lists in (instrument(layers, rows=SIDE), probed_layers()))
    return identity("visibility_monotonic", map(Shot, scenes), expect)


def probed_layers() -> FragmentLists:
    """Return black layers, two of them coincident, and a clear probe of radiance 1.

    The probe lies 1 m away in the top row and 6 m away in the bottom row; its radiance in the image
    is its visibility.
    """
    probe = Layer(1.0, 1.0, WHITE, WHITE)
    lists = stack([probe, *(Layer(z, 0.35, BLACK) for z in (2.0, 3.0, 3.0, 4.5, 5.5))])
    lists.z[0] = np.linspace(1.0, 6.0, SIDE, dtype=np.float32)[:, None]
    return lists


def _falling(values: Values) -> Values:
    """Return the values clipped to [0, 1] and limited to the smallest one at smaller depths."""
    falling: Values = np.minimum.accumulate(np.clip(values, 0, 1), axis=0)
    return falling

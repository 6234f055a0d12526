"""Hard cases for methods that keep a fixed number of nodes or coefficients per pixel."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from oitbench.measure.oracle import transmittances
from oitbench.scene import FragmentLists
from oitbench.stability.cases.over import over
from oitbench.stability.check import Bound, Check, Expectation, Rendering, Shot
from oitbench.stability.layers import (
    BACKGROUND,
    BLUE,
    GREEN,
    RED,
    Layer,
    columns,
    random_lists,
    scene_of,
)


def cases() -> Iterable[Check]:
    """Yield the cases: for nodes that are merged or dropped, then for curves of transmittance."""
    behind = [Layer(z, 0.4, BLUE) for z in np.random.default_rng(1).permutation(range(2, 41))]
    lists = [[*behind[:k], Layer(1, 1, RED), *behind[k:]] for k in (0, 20, 39)]
    yield over(
        "opaque front of 40",
        "an opaque layer in front of 39 others hides them, drawn first, in the middle or last",
        *(columns([item]) for item in lists),
        background=BACKGROUND,
    )
    layers = [Layer(1, 0.1, RED), Layer(3, 0.1, RED), Layer(5, 0.9, BLUE), Layer(4, 0.9, GREEN)]
    yield over(
        "late arrival",
        "behind two faint layers, a strong one hides a strong one behind it, drawn first or last",
        columns([layers]),
        columns([layers[:2] + layers[:1:-1]]),
    )
    many = random_lists(64)
    yield _total_transmittance(many)
    parts = (many.z, many.coverage, many.radiance, many.transmission)
    yield over(
        "64 layers",
        "64 layers in random order are composited completely, drawn in this order or in reverse",
        many,
        FragmentLists(*(part[::-1].copy() for part in parts)),
        background=BACKGROUND,
    )
    strong = [Layer(4 + 0.2 * i, 0.6, RED) for i in range(10)]
    yield over(
        "strong before many",
        "a layer with α = 0.95 in front of ten with α = 0.6 gives 0.95 of the color",
        columns([[*strong[::-1], Layer(2, 0.95, GREEN)]]),
    )
    groups = [Layer(z, 0.5, RED if z < 4 else BLUE) for z in (2, 2.01, 2.02, 6, 6.01, 6.02)]
    yield over(
        "two clusters",
        "three layers at 2 m hide 7/8 of three layers at 6 m",
        columns([groups[::-1]]),
        background=BACKGROUND,
    )


def _total_transmittance(lists: FragmentLists) -> Check:
    expected = transmittances(lists).prod(axis=0)

    def expect(renderings: Sequence[Rendering]) -> Iterable[Expectation]:
        yield Expectation(renderings[0].image, expected, bound=Bound.DISPLAY)

    sentence = "64 layers in random order have the total transmittance Π(1 − α)"
    shot = Shot(scene_of(lists), transmittance=True)
    return Check("transmittance of 64", sentence, (shot,), expect)

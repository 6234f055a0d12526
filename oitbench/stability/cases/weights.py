"""Hard cases for weights that depend on depth alone."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from oitbench.scene import BLACK, WHITE
from oitbench.stability.cases.over import over
from oitbench.stability.check import Bound, Check, Expectation, Rendering, Shot
from oitbench.stability.layers import BACKGROUND, BLUE, GREEN, RED, Layer, columns, scene_of

SWEEP = 2001
"""Depths of the swept layer."""


def cases() -> Iterable[Check]:
    """Yield the cases."""
    pairs = [
        [Layer(z + 1, 0.5, back), Layer(z, 0.5, front)]
        for z in (1.0, 5.0, 50.0)
        for front, back in ((RED, BLUE), (BLUE, RED))
    ]
    yield over(
        "two halves",
        "of two layers with α = 1/2 at 1, 5 or 50 m, the front one gives 2/3 of their color",
        columns(pairs),
    )
    yield over(
        "near opaque",
        "a layer with α = 0.9, 0.99, 0.999 or 1 at 5 m hides that part of a white wall at 6 m",
        columns([[Layer(6, 1), Layer(5, a, RED)] for a in (0.9, 0.99, 0.999, 1.0)]),
    )
    near = [Layer(0.11 + 0.01 * i, 0.1, BLACK) for i in range(8)]
    yield over(
        "near black",
        "black layers just behind the near plane attenuate the background by Π(1 − α)",
        columns([near]),
        background=WHITE,
    )
    yield _near_planes()
    decades = [10.0**k for k in range(-3, 7)]
    colors = (RED, GREEN, BLUE)
    layers = [Layer(z, 0.3, colors[i % 3]) for i, z in enumerate(decades)][::-1]
    yield over(
        "1 mm to 1000 km",
        "ten layers from 0.001 m to 1,000,000 m are composited in their order",
        columns([layers]),
        background=BACKGROUND,
        near=5e-4,
    )
    sweep = [[Layer(z, 0.5)] for z in np.geomspace(0.2, 200.0, SWEEP)]
    yield over(
        "swept layer",
        f"a single layer in front of black gives α·L at each of {SWEEP} depths",
        columns(sweep),
    )


def _near_planes() -> Check:
    layers = [Layer(z, 0.5, color) for z, color in ((8, BLUE), (4, GREEN), (2, RED))]
    lists = columns([layers])

    def expect(renderings: Sequence[Rendering]) -> Iterable[Expectation]:
        first, *others = renderings
        for other in others:
            yield Expectation(other.image, first.image, bound=Bound.DISPLAY)

    return Check(
        "near plane",
        "the image is the same for a near plane at 0.001, 0.01, 0.1 and 1 m",
        tuple(Shot(scene_of(lists, BACKGROUND, near)) for near in (0.001, 0.01, 0.1, 1.0)),
        expect,
    )

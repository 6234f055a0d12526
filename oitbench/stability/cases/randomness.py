"""Hard cases for random masks: they must be independent, and must not scatter too much."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from math import prod

import numpy as np

from oitbench.scene import BLACK, WHITE
from oitbench.stability.cases.over import over
from oitbench.stability.check import Check, Expectation, Rendering, Shot
from oitbench.stability.layers import Layer, scene_of, stack


def cases() -> Iterable[Check]:
    """Yield the cases."""
    yield over(
        "two masks",
        "the masks of two layers with α = 1/2 are independent: the total transmittance is 1/4",
        stack([Layer(2, 0.5, BLACK), Layer(3, 0.5, BLACK)]),
        background=WHITE,
    )
    yield _scatter()


def _scatter() -> Check:
    veils = [Layer(2 + i, a, BLACK) for i, a in enumerate((0.3, 0.5, 0.4))]
    passed = prod(1 - layer.coverage for layer in veils)

    def expect(renderings: Sequence[Rendering]) -> Iterable[Expectation]:
        image = renderings[0].image.astype(np.float64)
        excess = np.maximum(image.var(axis=(0, 1)) - passed * (1 - passed), 0)
        count = image.shape[0] * image.shape[1]
        yield Expectation(excess[None, None], np.zeros((1, 1, 3)), noise=count**-0.5 / 4)

    return Check(
        "scatter",
        "the variance of pixels is at most T(1 − T), that of one independent sample per pixel",
        (Shot(scene_of(stack(veils, 128), WHITE)),),
        expect,
        exemption=lambda method: "" if method.noisy else "the method is not random",
    )

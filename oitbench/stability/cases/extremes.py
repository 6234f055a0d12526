"""Hard cases at the ends of the ranges of radiance, coverage and transmission."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from oitbench.scene import RGB
from oitbench.stability.cases.over import over
from oitbench.stability.check import Check
from oitbench.stability.layers import BACKGROUND, BLUE, GREEN, RED, Layer, columns


def cases() -> Iterable[Check]:
    """Yield the cases."""
    for radiance in (100.0, 1e4):
        light: RGB = (radiance, radiance / 2, radiance / 4)
        layers = [Layer(z, 0.5, light) for z in np.linspace(1, 4, 8)]
        yield over(
            f"radiance {radiance:g}",
            f"eight layers with α = 1/2 and radiance {radiance:g} are composited as dim ones are",
            columns([layers]),
            background=light,
        )
    bright: RGB = (1e4, 1e4, 1e4)
    clear = [Layer(z, 0.0, bright) for z in np.linspace(0.5, 5, 40)]
    yield over(
        "α = 0",
        "forty layers with α = 0 and radiance 10⁴ change nothing",
        columns([clear]),
        background=BACKGROUND,
    )
    glass = [[Layer(2, 1, (0.5, 0.5, 0.5), (t, t, t))] for t in (0.9, 0.99, 0.999, 0.9999, 1.0)]
    yield over(
        "clear glass",
        "a highlight on glass with a transmission of 0.9 to 1 keeps its radiance",
        columns(glass),
        background=(0.25, 0.25, 0.25),
    )
    stacks = [
        [Layer(4, 0.5, BLUE), Layer(3, a, GREEN), Layer(2, 0.3, RED)]
        for a in (0, 1 / 510, 1 / 255, 254 / 255, 1 - 2**-20, 1)
    ]
    yield over(
        "middle layer from 0 to 1",
        "a middle layer with α from exactly 0 to exactly 1 hides that part of the layer behind it",
        columns(stacks),
        background=BACKGROUND,
    )
    yield over(
        "faint and bright",
        "one layer with α = 0.0005 and radiance 1000 gives 0.5",
        columns([[Layer(3, 5e-4, (1000.0, 1000.0, 1000.0))]]),
    )

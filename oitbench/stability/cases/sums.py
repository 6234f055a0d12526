"""Hard cases for sums and products over many layers, which stall, saturate or underflow."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from oitbench.method.declaration import Method, Request, plan_of
from oitbench.method.passes import Gather, Loop
from oitbench.scene import BLACK
from oitbench.stability.cases.over import over
from oitbench.stability.check import Check
from oitbench.stability.layers import GREEN, RED, Layer, columns


def cases() -> Iterable[Check]:
    """Yield the cases."""
    thin = [Layer(z, 1 / 512, RED) for z in np.linspace(2, 6, 1000)]
    yield over(
        "1000 thin layers",
        "1000 layers with α = 1/512 have a total transmittance of 0.1416",
        columns([thin]),
        background=GREEN,
        repeat=False,
    )
    faint = [Layer(z, 0.003, RED) for z in np.linspace(2, 6, 200)]
    yield over(
        "200 faint layers",
        "200 layers with α = 0.003 have a total transmittance of 0.548",
        columns([faint]),
        background=GREEN,
    )
    walls = [Layer(z, 1) for z in np.linspace(0.2, 1, 3000)]
    white = over(
        "3000 white walls", "3000 opaque white layers are white", columns([walls]), repeat=False
    )
    yield replace(white, exemption=_peels)
    veils = [Layer(z, 0.5, BLACK) for z in np.linspace(2, 6, 60)]
    yield over(
        "underflow",
        "60 black layers with α = 1/2 in front of radiance 10⁴ are black",
        columns([veils]),
        background=(1e4, 1e4, 1e4),
    )


def _peels(method: Method) -> str:
    """Return a reason if the method draws the geometry once per layer."""
    steps = plan_of(method, Request()).passes
    loops = [item for item in steps if isinstance(item, Loop) and (item.until_empty or item.within)]
    peeling = any(isinstance(item, Gather) for loop in loops for item in loop.passes)
    return "3000 geometry passes over 3000 layers take too long" if peeling else ""

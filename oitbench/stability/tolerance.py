"""How far from the right answer rounding alone may take a method, by its declared formats."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from oitbench.method.declaration import Method, Plan, Request
from oitbench.method.passes import Gather, Loop, Pass
from oitbench.method.steps import passes_of
from oitbench.method.storage import Target

_SINGLE = 2.0**-23
_OPERATIONS = 8
"""Roundings of single precision that computing one layer's share takes, generously."""


def allowed(method: Method, layers: int, magnitude: float) -> float:
    """Return the error that rounding may cause in pixels up to `magnitude`.

    Each write of a target may be off by one step of its format (drivers may truncate), the opaque
    picture's too, and no later blend makes an error larger. A sum that is divided by another
    carries the relative error of both. A record that shaders pack is off by half a step in each of
    color and opacity.

    Parameters
    ----------
    method : Method
    layers : int
        Fragments a pixel.
    magnitude : float
        Largest radiance involved.
    """
    plan = method.plan(Request(method.shows, particles=True))
    targets = {"color": Target("rgba16f"), **plan.targets}
    error = step(targets["color"], 1.0) * magnitude
    for item, repeated in _passes(plan):
        writes = layers if repeated or isinstance(item, Gather) else 1
        for name in item.writes:
            if targets[name].texel.integer:
                continue  # its rounding is the record's
            quotient = name != "color" and targets[name].texel.dtype != "f1"
            error += writes * step(targets[name], 1.0) * magnitude * (2 if quotient else 1)
    error += layers * (1 + magnitude) * method.record_step / 2
    return error + _OPERATIONS * layers * _SINGLE * magnitude


def step(target: Target, magnitude: float) -> float:
    """Return the distance of neighboring values of the target's format at `magnitude`.

    Floating-point formats have `Format.step` just below one, and twice as much from each power of
    two on; normalized formats have the same step everywhere.
    """
    entry = target.texel
    if entry.dtype == "f1":
        return entry.step
    return float(entry.step * 2.0 ** (np.floor(np.log2(max(magnitude, 0.5))) + 1))


def _passes(plan: Plan) -> Iterator[tuple[Pass, bool]]:
    """Yield every pass, and whether it may run once a layer."""
    for item in plan.passes:
        for single in passes_of(item):
            yield single, isinstance(item, Loop)

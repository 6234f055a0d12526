"""Largest error that the rounding of a method's declared formats can cause."""

from __future__ import annotations

import numpy as np

from oitbench.method.declaration import Method, Request, plan_of
from oitbench.method.passes import Gather
from oitbench.method.steps import all_passes
from oitbench.method.storage import Target

_SINGLE = 2.0**-23
_OPERATIONS = 4
"""Roundings to single precision when a shader composites one stored fragment."""


def tolerance(method: Method, layers: int, magnitude: float) -> float:
    """Return the largest error that rounding can cause: of targets, and of packed records.

    A packed record is off by half a step in color and by half a step in opacity.

    Parameters
    ----------
    method : Method
    layers : int
        Fragments per pixel.
    magnitude : float
        Largest radiance involved.
    """
    records = layers * (1 + magnitude) * method.record_step / 2
    return rounding(method, layers, magnitude) + records


def rounding(method: Method, layers: int, magnitude: float) -> float:
    """Return the largest error of targets and of arithmetic alone.

    It applies to two images of the same packed records. Each write of a target may be off by one
    step of its format, because drivers may truncate; so may the opaque picture. No later blend
    makes an error larger. A sum that is divided by another sum has the relative error of both.

    A pass over fragments writes once per layer, inside a loop too. A pass over pixels counts once
    even inside a loop, because the loop's passes over fragments already count twice per layer.

    Parameters
    ----------
    method, layers, magnitude
        As in `tolerance`.
    """
    plan = plan_of(method, Request(method.shows, particles=True))
    targets = {"color": Target("rgba16f"), **plan.targets}
    passes = list(all_passes(plan.passes))
    error = step(targets["color"], 1.0) * magnitude
    for item in passes:
        writes = layers if isinstance(item, Gather) else 1
        for name in item.writes:
            if targets[name].texel.integer:
                continue  # the record's step accounts for it
            quotient = name != "color" and targets[name].texel.dtype != "f1"
            error += writes * step(targets[name], 1.0) * magnitude * (2 if quotient else 1)
    if any(item.buffers for item in passes):
        error += _OPERATIONS * layers * _SINGLE * magnitude
    return error


def step(target: Target, magnitude: float) -> float:
    """Return the distance of adjacent values of the target's format at `magnitude`.

    Floating-point formats have `Format.step` just below one, and twice as much above each power of
    two. Normalized formats have the same step everywhere.
    """
    entry = target.texel
    if entry.dtype == "f1":
        return entry.step
    return float(entry.step * 2.0 ** (np.floor(np.log2(max(magnitude, 0.5))) + 1))

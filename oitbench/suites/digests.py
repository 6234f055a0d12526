"""Digests of pixels, and of what metrics do; neither depends on a machine or on code."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping

import numpy as np
import numpy.typing as npt

from oitbench.image import metrics

TOLERANCE = 1e-4
"""Relative difference of two values of a metric that processors and libraries may cause."""
_LEAST = 1e-6
_SIDE, _STOPS = 32, 0.5
_DIGITS = 9


def pixel_digest(image: npt.ArrayLike) -> str:
    """Return a digest of the values of an image, (h, w, 3) in single precision: 32 digits."""
    pixels = np.ascontiguousarray(image, dtype="<f4") + np.float32(0)  # −0 becomes 0.
    return hashlib.sha256(repr(pixels.shape).encode() + pixels.tobytes()).hexdigest()[:32]


def probe_metrics() -> dict[str, float]:
    """Return the values of all metrics for a fixed pair of pictures, to nine digits.

    The pictures have edges, gradients, black, and radiance that the display clips.
    """
    y, x, channel = np.ogrid[:_SIDE, :_SIDE, :3]
    reference = ((7 * x + 13 * y + 5 * channel) % _SIDE) / 16.0
    test = 0.75 * reference + ((x * y + 11 * channel) % 9) / 32.0
    found = metrics.compare(reference, test, _STOPS).values
    found[metrics.TRANSMITTANCE] = metrics.rmse_transmittance(reference, test)
    found |= metrics.order_spread([reference, test])
    return {name: float(f"{value:.{_DIGITS}g}") for name, value in found.items() if value}


def same_value(one: float | None, other: float | None) -> bool:
    """Return whether two values of a metric are equal, but for rounding; None is no value."""
    if one is None or other is None:
        return one is other
    return bool(np.isclose(one, other, rtol=TOLERANCE, atol=_LEAST))


def different_metrics(frozen: Mapping[str, float], current: Mapping[str, float]) -> list[str]:
    """Return one line for each metric that is not what it was when the suite was frozen."""
    return [
        f"the metric {name} gives {_shown(current.get(name))} for the probe, not {_shown(value)}"
        for name, value in frozen.items()
        if not same_value(current.get(name), value)
    ]


def _shown(value: float | None) -> str:
    return "nothing" if value is None else f"{value:.6g}"

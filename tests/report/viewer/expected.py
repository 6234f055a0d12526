"""What the viewer should show of the made-up results, in display levels, computed apart from it."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from oitbench.image.files import to_srgb
from tests.report.made_up import SIDE

EXPOSURE = 1.0
Floats = npt.NDArray[Any]


def radiance(error: float = 0.0) -> Floats:
    """Return the picture of a method whose picture is the truth times one minus an error."""
    truth = np.random.default_rng(5).random((SIDE, SIDE, 3), dtype=np.float32)
    return np.asarray(truth * np.float32(1 - error), np.float64)


def levels(error: float = 0.0) -> Floats:
    """Return the 8-bit levels of that picture at the exposure of its scene."""
    rounded: Floats = np.rint(255.0 * to_srgb(radiance(error), EXPOSURE))
    return rounded


def linear(values: Floats) -> Floats:
    """Return the linear value of display levels."""
    display = values / 255
    values = np.where(display <= 0.04045, display / 12.92, ((display + 0.055) / 1.055) ** 2.4)
    return np.asarray(values)

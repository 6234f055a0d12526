"""The logarithmic axis of errors: the smallest ones share a place beyond a visible break."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Literal

from oitbench.report.figures import QUIET

if TYPE_CHECKING:
    from matplotlib.axes import Axes

FLOOR = 1e-3
"""Errors up to this one share one place, below a break of the axis."""
LABEL = "FLIP error, lower is better (logarithmic)"
_SHARED = FLOOR / 1.9
_ROOM = 1.6

Direction = Literal["x", "y"]


def place(error: float) -> float:
    """Return where an error is on the axis."""
    return error if error > FLOOR else _SHARED


def set_scale(axes: Axes, highest: float, direction: Direction = "y") -> None:
    """Make one axis that of errors.

    Parameters
    ----------
    axes : Axes
    highest : float
        The largest error.
    direction : {"x", "y"}
    """
    from matplotlib.ticker import NullLocator

    decades = math.ceil(math.log10(max(highest / FLOOR, 10)))
    powers = [FLOOR * 10**k for k in range(1, 1 + decades)]
    ticks, words = [_SHARED, FLOOR, *powers], [f"≤ {FLOOR:g}", "", *(f"{p:g}" for p in powers)]
    limits = _SHARED / 1.7, max(highest, 10 * FLOOR) * _ROOM
    if direction == "x":
        axes.set_xscale("log")
        axes.set_xlim(*limits)
        axes.set_xticks(ticks, words)
        axes.xaxis.set_minor_locator(NullLocator())
    else:
        axes.set_yscale("log")
        axes.set_ylim(*limits)
        axes.set_yticks(ticks, words)
        axes.yaxis.set_minor_locator(NullLocator())


def draw_break(axes: Axes, direction: Direction = "y") -> None:
    """Draw the break of the axis as a dotted line."""
    draw = axes.axhline if direction == "y" else axes.axvline
    draw(FLOOR, color=QUIET, linewidth=0.7, linestyle=(0, (1, 2)))

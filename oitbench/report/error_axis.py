"""The logarithmic axis of errors: the smallest ones share a place beyond a visible break."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Literal

from oitbench.report.figures import QUIET

if TYPE_CHECKING:
    from matplotlib.axes import Axes

FLOOR = 1e-3
"""Errors up to this one share one place, below a break of the axis."""
_SHARED = FLOOR / 1.9
_ROOM = 1.6
_NARROW = 30
"""An axis whose ends differ by less than this factor has more ticks."""

Direction = Literal["x", "y"]


def label(metric: str) -> str:
    """Return the label of the axis of a metric, by its name for readers."""
    return f"{metric} error, lower is better (logarithmic)"


def place(error: float) -> float:
    """Return where an error is on the axis."""
    return error if error > FLOOR else _SHARED


def set_scale(axes: Axes, highest: float, direction: Direction = "y", lowest: float = 0.0) -> bool:
    """Make one axis that of errors.

    Parameters
    ----------
    axes : Axes
    highest, lowest : float
        The largest and the smallest error.
    direction : {"x", "y"}

    Returns
    -------
    bool
        Whether the axis has a break; it has none if all errors are well above `FLOOR`.
    """
    from matplotlib.ticker import NullLocator

    broken = lowest <= 2 * FLOOR
    top = max(highest, (10 * FLOOR if broken else lowest)) * _ROOM
    bottom = _SHARED / 1.7 if broken else lowest / _ROOM
    factors = (1, 2, 5) if top < _NARROW * bottom else (1,)
    decades = range(math.floor(math.log10(FLOOR)), math.ceil(math.log10(top)) + 1)
    values = [factor * 10.0**decade for decade in decades for factor in factors]
    ticks = [value for value in values if max(bottom, 1.01 * FLOOR) < value <= top]
    words = [f"{tick:g}" for tick in ticks]
    if broken:
        ticks, words = [_SHARED, FLOOR, *ticks], [f"≤ {FLOOR:g}", "", *words]
    if direction == "x":
        axes.set_xscale("log")
        axes.set_xlim(bottom, top)
        axes.set_xticks(ticks, words)
        axes.xaxis.set_minor_locator(NullLocator())
    else:
        axes.set_yscale("log")
        axes.set_ylim(bottom, top)
        axes.set_yticks(ticks, words)
        axes.yaxis.set_minor_locator(NullLocator())
    return broken


def draw_break(axes: Axes, direction: Direction = "y") -> None:
    """Draw the break of the axis as a dotted line."""
    draw = axes.axhline if direction == "y" else axes.axvline
    draw(FLOOR, color=QUIET, linewidth=0.7, linestyle=(0, (1, 2)))

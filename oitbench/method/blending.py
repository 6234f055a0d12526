"""How the output of a shader meets the target that it is written to."""

from __future__ import annotations

import enum
from dataclasses import dataclass


class Factor(enum.IntEnum):
    """Blend factors of OpenGL."""

    ZERO = 0
    ONE = 1
    SOURCE_COLOR = 0x0300
    ONE_MINUS_SOURCE_COLOR = 0x0301
    ONE_MINUS_SOURCE_ALPHA = 0x0303
    ONE_MINUS_TARGET_ALPHA = 0x0305
    SECOND_SOURCE_COLOR = 0x88F9


class Equation(enum.IntEnum):
    """Blend equations of OpenGL."""

    SUM = 0x8006
    MINIMUM = 0x8007
    MAXIMUM = 0x8008


@dataclass(frozen=True)
class Blend:
    """Combination of a shader's output with a target.

    The result is source × `source` (equation) target × `target`.

    Parameters
    ----------
    source, target : Factor
        Factors of red, green and blue. They also apply to alpha unless alpha has its own.
    equation : Equation
    source_alpha, target_alpha : Factor, optional
        Factors of alpha.
    dual : bool
        The shader has a second output `NAME_factor` for this target. The target must then be the
        only one of its pass.
    programmable : bool
        The shader itself combines: see `PROGRAMMABLE`.
    counts : bool
        The shader counts in the target: see `COUNT`.
    """

    source: Factor
    target: Factor
    equation: Equation = Equation.SUM
    source_alpha: Factor | None = None
    target_alpha: Factor | None = None
    dual: bool = False
    programmable: bool = False
    counts: bool = False

    @property
    def reads(self) -> bool:
        """Whether blending reads the target."""
        by_shader = self.programmable or self.counts
        return by_shader or self.equation is not Equation.SUM or self.target is not Factor.ZERO


REPLACE = Blend(Factor.ONE, Factor.ZERO)
"""target ← source"""
ADD = Blend(Factor.ONE, Factor.ONE)
"""target ← target + source"""
OVER = Blend(Factor.ONE, Factor.ONE_MINUS_SOURCE_ALPHA)
"""target ← source + (1 − source alpha)·target, premultiplied (Porter and Duff 1984)"""
UNDER = Blend(Factor.ONE_MINUS_TARGET_ALPHA, Factor.ONE)
"""target ← target + (1 − target alpha)·source, premultiplied: `OVER` from near to far"""
ATTENUATE = Blend(Factor.ZERO, Factor.ONE_MINUS_SOURCE_COLOR)
"""target ← (1 − source)·target, per channel"""
MODULATE = Blend(Factor.ZERO, Factor.SOURCE_COLOR)
"""target ← source·target, per channel"""
COMPOSITE = Blend(Factor.ONE, Factor.SECOND_SOURCE_COLOR, dual=True)
"""target ← source + factor·target, per channel, by dual-source blending"""
MINIMUM = Blend(Factor.ONE, Factor.ONE, Equation.MINIMUM)
"""target ← min(source, target), per channel"""
MAXIMUM = Blend(Factor.ONE, Factor.ONE, Equation.MAXIMUM)
"""target ← max(source, target), per channel"""
PROGRAMMABLE = Blend(Factor.ONE, Factor.ZERO, programmable=True)
"""target ← the value that `gather` leaves in it.

The output's name holds the target's value when `gather` begins. The fragments of a pixel run one at
a time, by framebuffer fetch, fragment-shader interlock or a spin lock, whichever the driver offers;
`Frame.mechanism` names the one in use. All targets of such a pass must be programmable.
"""
COUNT = Blend(Factor.ONE, Factor.ZERO, counts=True)
"""target ← target + 1 at each call of `count_NAME()`, which returns the value before.

The fragments of a pixel get different numbers, in no particular order. The target is `r32ui` and
the only one of its pass. It counts by framebuffer fetch if the driver offers that, and else, or if
it is `single` in a multisampled frame, by atomics on an image. Such a `single` target counts the
fragments of all samples, once each.
"""

"""One visibility curve per pixel, built from all fragments and then composited against.

A curve is built from lists of all fragments or, in fixed memory, by geometry passes. Colored
transmission takes three curves, which are built and used one after another. `channels.glsl` selects
the channels that a round serves.
"""

from __future__ import annotations

from typing import ClassVar

from oitbench.effects import Effect
from oitbench.method.declaration import MSAA, Method, Plan, Request
from oitbench.method.kits.linked_lists import RECORD_STEPS, linked_lists
from oitbench.method.passes import Loop, Pass, Step
from oitbench.method.storage import Target
from oitbench.parameters import Parameter


class CurveMethod(Method):
    """Base of such methods; a subclass defines `list_steps` and `fixed_plan`."""

    memory = Parameter(
        "variable",
        choices=("variable", "fixed"),
        grid=("variable", "fixed"),
        help="`variable` keeps all fragments in lists, `fixed` keeps the curve in targets",
    )
    channels = Parameter("gray", choices=("gray", "rgb"), help="one curve, or one per channel")
    node = Parameter(
        "compact",
        choices=("compact", "precise"),
        help="record of a list; `compact` clips radiance above one and holds 8 bits per value",
    )
    msaa = MSAA

    traversals: ClassVar[int]
    """Number of times that one shader invocation traverses its list."""

    @property
    def fixed(self) -> bool:
        """Whether the curve is kept in targets."""
        return self.memory == "fixed"

    @property
    def tinted(self) -> bool:
        """Whether each channel has its own curve."""
        return self.channels == "rgb"

    @property
    def precise(self) -> bool:
        """Whether colors are stored as floats."""
        return self.fixed or self.node == "precise"

    @property
    def expresses(self) -> Effect:
        """Colored transmission if each channel has its own curve."""
        return Effect.COVERAGE | (Effect.COLORED_TRANSMISSION if self.tinted else Effect.NONE)

    @property
    def record_step(self) -> float:
        """The step of a list's record; curves are floats."""
        return 0.0 if self.fixed else RECORD_STEPS[self.node]

    def loop_steps(self, fragments: int) -> float:
        """Return the steps of all traversals of a list."""
        return 0 if self.fixed else self.traversals * fragments

    def plan(self, request: Request) -> Plan:
        """Return the plan for lists or for fixed memory."""
        color = {"color": Target("rgba32f" if self.precise else "rgba16f")}
        if not self.fixed:
            return Plan(color, self.list_steps, linked_lists(self.node, self.tinted))
        fixed = self.fixed_plan
        return Plan({**color, **fixed.targets}, fixed.passes)

    @property
    def list_steps(self) -> tuple[Step, ...]:
        """Steps that fill the lists and resolve them."""
        raise NotImplementedError

    @property
    def fixed_plan(self) -> Plan:
        """Targets and steps that keep the curve in fixed memory."""
        raise NotImplementedError

    def rounds(self, *passes: Pass) -> tuple[Step, ...]:
        """Return passes that serve all channels at once, or a loop that serves one per round."""
        return (Loop(passes, times=3),) if self.tinted else passes

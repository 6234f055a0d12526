"""What methods have in common that keep absorbance over depth in a fixed set of terms.

Such a method has a shader `curve.glsl` with an array `float terms[TERMS]` and

    void deposit(float u, float absorbance)   adds a layer at relative depth u in [0, 1]
    float absorbed(float u)                   returns the absorbance of all in front of u

and everything else comes from here and from `absorbance_*.glsl`: bounds of depth in each pixel,
building the curve, and compositing against it, in lists or in targets.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

from oitbench.effects import Effect
from oitbench.method.declaration import (
    ADD,
    COMPOSITE,
    MAXIMUM,
    MODULATE,
    Buffer,
    Draws,
    Loop,
    Method,
    Pass,
    Step,
    Target,
)
from oitbench.method.kits.linked_lists import CAPTURE, LISTS, RECORD_STEPS, linked_lists
from oitbench.parameters import Parameter

_NO_BOUNDS = -1e38


class AbsorbanceMap(Method):
    """Visibility of a layer at relative depth u in its pixel is exp(-absorbed(u)).

    A subclass adds a parameter for the size of the curve to these.
    """

    parameters: ClassVar[Mapping[str, Parameter]] = {
        "memory": Parameter(
            "variable", choices=("variable", "fixed"), grid=("variable", "fixed"), help="storage"
        ),
        "channels": Parameter("grey", choices=("grey", "rgb"), help="one curve, or three"),
        "node": Parameter("compact", choices=("compact", "precise"), help="record of a list"),
        "msaa": Parameter(1, choices=(1, 4), help="samples a pixel"),
    }

    @property
    def terms(self) -> int:
        """Floats that a curve has, a multiple of four and at most 32."""
        raise NotImplementedError

    @property
    def expresses(self) -> Effect:
        """Colored transmission where each channel has a curve."""
        return Effect.COVERAGE | (Effect.COLORED_TRANSMISSION if self._tinted else Effect.NONE)

    @property
    def holds(self) -> frozenset[str]:
        """What sums of absorbance give; packed records clip radiance."""
        held = {"U1", "U2", "U4", "U6", "U7"}
        held |= {"U2c"} if self._tinted else set()
        return frozenset(held | ({"U10"} if self._precise else set()))

    @property
    def record_step(self) -> float:
        """That of lists; terms are floats."""
        return 0.0 if self._fixed else RECORD_STEPS[self.text("node")]

    @property
    def samples(self) -> int:
        """One, or four."""
        return int(self.values["msaa"])

    @property
    def deepest(self) -> int | None:
        """Three traversals of a list in one shader count; without lists, any number goes."""
        return None if self._fixed else 21_000

    @property
    def targets(self) -> Mapping[str, Target]:
        """Bounds and curve, with fixed memory; sums need floats."""
        color = {"color": Target("rgba32f" if self._precise else "rgba16f")}
        if not self._fixed:
            return color
        bounds = Target("rg32f", clear=(_NO_BOUNDS, _NO_BOUNDS))
        return {**color, "bounds": bounds, **dict.fromkeys(self._curve, Target("rgba32f"))}

    @property
    def buffers(self) -> Mapping[str, Buffer]:
        """Lists, with variable memory."""
        return {} if self._fixed else linked_lists(self.text("node"), self._tinted)

    @property
    def passes(self) -> tuple[Step, ...]:
        """Capture and resolve; or bounds, build, attenuate and composite."""
        size = {"TERMS": self.terms}
        if not self._fixed:
            resolve = Pass(
                "absorbance_resolve.glsl",
                Draws.PIXELS,
                writes={"color": COMPOSITE},
                buffers=LISTS,
                defines=size,
            )
            return (CAPTURE, *self._rounds(resolve))
        bounds = Pass("absorbance_bounds.glsl", Draws.FRAGMENTS, writes={"bounds": MAXIMUM})
        build = Pass(
            "absorbance_build.glsl",
            Draws.FRAGMENTS,
            reads=("bounds",),
            writes=dict.fromkeys(self._curve, ADD),
            clears=self._curve if self._tinted else (),
            defines=size,
        )
        attenuate = Pass(
            "absorbance_attenuate.glsl",
            Draws.PIXELS,
            reads=self._curve,
            writes={"color": MODULATE},
            defines=size,
        )
        composite = Pass(
            "absorbance_composite.glsl",
            Draws.FRAGMENTS,
            reads=("bounds", *self._curve),
            writes={"color": ADD},
            defines=size,
        )
        return (bounds, *self._rounds(build, attenuate, composite))

    def _rounds(self, *passes: Pass) -> tuple[Step, ...]:
        """Return passes that serve all channels at once, or one channel a round."""
        return (Loop(passes, times=3),) if self._tinted else passes

    @property
    def _curve(self) -> tuple[str, ...]:
        return tuple(f"curve{i}" for i in range(self.terms // 4))

    @property
    def _fixed(self) -> bool:
        return self.text("memory") == "fixed"

    @property
    def _precise(self) -> bool:
        return self._fixed or self.text("node") == "precise"

    @property
    def _tinted(self) -> bool:
        return self.text("channels") == "rgb"

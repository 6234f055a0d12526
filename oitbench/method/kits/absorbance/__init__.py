"""Absorbance over depth, as a curve with a fixed number of terms.

A method has a shader `curve.glsl` with an array `float terms[TERMS]` and

    void deposit(float u, float absorbance)   adds a layer at relative depth u in [0, 1]
    float absorbed(float u)                   returns the absorbance of all layers in front of u

The rest comes from this kit: depth bounds per pixel, building the curve, and compositing against
it, in lists or in targets.
"""

from __future__ import annotations

from oitbench.method.blending import ADD, COMPOSITE, MAXIMUM, MODULATE
from oitbench.method.declaration import Plan
from oitbench.method.kits.curves import CurveMethod
from oitbench.method.kits.linked_lists import CAPTURE, LISTS
from oitbench.method.passes import Gather, Resolve, Step
from oitbench.method.promises import promise
from oitbench.method.storage import Target

_NO_BOUNDS = -1e38


class AbsorbanceMap(CurveMethod):
    """The visibility of a layer at relative depth u in its pixel is exp(−absorbed(u))."""

    traversals = 3

    @property
    def terms(self) -> int:
        """Floats of a curve, a multiple of four and at most 32."""
        raise NotImplementedError

    @property
    def promises(self) -> frozenset[str]:
        """Promises that sums of absorbance keep; packed records clip radiance."""
        kept = promise(
            "single_layer_exact order_independent total_transmittance_exact zero_coverage_ignored"
        )
        kept |= promise("colored_layer_exact") if self.tinted else promise("")
        return kept | (promise("scales_with_radiance") if self.precise else promise(""))

    @property
    def list_steps(self) -> tuple[Step, ...]:
        """Capture and resolve."""
        resolve = Resolve(
            "absorbance/resolve.glsl",
            writes={"color": COMPOSITE},
            buffers=LISTS,
            defines={"TERMS": self.terms},
        )
        return (CAPTURE, *self.rounds(resolve))

    @property
    def fixed_plan(self) -> Plan:
        """Bounds, build, attenuate and composite."""
        curve, size = tuple(f"curve{i}" for i in range(self.terms // 4)), {"TERMS": self.terms}
        build = Gather(
            "absorbance/build.glsl",
            reads=("bounds",),
            writes=dict.fromkeys(curve, ADD),
            clears=curve if self.tinted else (),
            defines=size,
        )
        attenuate = Resolve(
            "absorbance/attenuate.glsl", reads=curve, writes={"color": MODULATE}, defines=size
        )
        composite = Gather(
            "absorbance/composite.glsl",
            reads=("bounds", *curve),
            writes={"color": ADD},
            defines=size,
        )
        bounds = Target("rg32f", clear=(_NO_BOUNDS, _NO_BOUNDS))
        return Plan(
            targets={"bounds": bounds, **dict.fromkeys(curve, Target("rgba32f"))},
            passes=(
                Gather("absorbance/bounds.glsl", writes={"bounds": MAXIMUM}),
                *self.rounds(build, attenuate, composite),
            ),
        )

"""Absorbance over depth, as a curve with a fixed number of terms.

A method has a shader `curve.glsl` with an array `float terms[TERMS]` and

    void deposit(float u, float absorbance)   adds a layer at relative depth u in [0, 1]
    float absorbed(float u, float own)        returns the absorbance of all layers in front of u,
                                              seen by a layer that itself has the absorbance `own`

The rest comes from this kit: depth bounds per pixel, building the curve, and compositing against
it, in lists or in targets. `normalize.glsl` also serves methods with other plans.

    plain:       C = sum_i alpha_i L_i vis(u_i) + C0 T
    normalized:  C = (1 - T) sum_i alpha_i L_i vis(u_i) / sum_i o_i vis(u_i) + C0 T

with o = 1 - transmittance. Normalized, any visibility is exact for layers of one color, and errors
of visibility change colors but not the light's amount.
"""

from __future__ import annotations

from oitbench.method.blending import ADD, COMPOSITE, MAXIMUM, MODULATE, OVER
from oitbench.method.declaration import Plan
from oitbench.method.kits.curves import CurveMethod
from oitbench.method.kits.linked_lists import CAPTURE, LISTS
from oitbench.method.passes import Gather, Pass, Resolve, Step
from oitbench.method.promises import promise
from oitbench.method.storage import Target
from oitbench.parameters import Parameter

BOUNDS = Target("rg32f", clear=(-1e38, -1e38))
"""Distances of the absorbing layers of a pixel: (-nearest, farthest)."""
FIND_BOUNDS = Gather("absorbance/bounds.glsl", writes={"bounds": MAXIMUM})
"""Fills a target `bounds`."""


class AbsorbanceMap(CurveMethod):
    """The visibility of a layer at relative depth u in its pixel is exp(−absorbed(u))."""

    normalized = Parameter(False, help="divide the sum of layers by the sum of their weights")
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
        kept |= promise("equal_layers_exact white_furnace") if self.normalized else promise("")
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
    def curve_format(self) -> str:
        """Format of the targets that hold a curve, four terms each."""
        return "rgba32f"

    @property
    def fixed_plan(self) -> Plan:
        """Bounds, the curve, and layers composited against it."""
        curve = {f"curve{i}": Target(self.curve_format) for i in range(self.terms // 4)}
        sums = {"sum": Target("rgba32f")} if self.normalized else {}
        build = Gather(
            "absorbance/build.glsl",
            reads=("bounds",),
            writes=dict.fromkeys(curve, ADD),
            clears=tuple(curve) if self.tinted else (),
            defines={"TERMS": self.terms},
        )
        steps = self._fill_steps(*curve) if self.normalized else self._add_steps(*curve)
        targets = {"bounds": BOUNDS, **curve, **sums}
        return Plan(targets, (FIND_BOUNDS, *self.rounds(build, *steps)))

    def _add_steps(self, *curve: str) -> tuple[Pass, ...]:
        """Return passes that attenuate the background and add the layers to it."""
        size = {"TERMS": self.terms}
        return (
            Resolve(
                "absorbance/attenuate.glsl", reads=curve, writes={"color": MODULATE}, defines=size
            ),
            Gather(
                "absorbance/composite.glsl",
                reads=("bounds", *curve),
                writes={"color": ADD},
                defines=size,
            ),
        )

    def _fill_steps(self, *curve: str) -> tuple[Pass, ...]:
        """Return passes that sum the layers, and put their mean over the background."""
        size = {"TERMS": self.terms}
        return (
            Gather(
                "absorbance/composite.glsl",
                reads=("bounds", *curve),
                writes={"sum": ADD},
                clears=("sum",) if self.tinted else (),
                defines=size,
            ),
            Resolve(
                "absorbance/fill.glsl",
                reads=("sum", *curve),
                writes={"color": COMPOSITE if self.tinted else OVER},
                defines=size,
            ),
        )

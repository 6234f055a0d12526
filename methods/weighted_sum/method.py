"""Weighted sum: all layers are added, and the background is weighted by one minus their opacities.

    C = sum alpha L + C0 (1 - sum o),    o = alpha (1 - mean t)

The over operator to first order in o: one unordered geometry pass and one resolve; nothing depends
on depth. 64 bits per pixel, 16 bytes of blending per fragment, both four times with `msaa` 4. As
published, the weight of the background, and with it the color, is negative where opacities sum to
more than one.

Source: Meshkin 2007 [Meshkin2007], "Sort-Independent Alpha Blending", GDC.

Known failures: exact for one layer and approximately for thin ones only. Opaque layers add up like
thin ones, so deep stacks become ever brighter, and the background turns negative; half floats clip
both at 65504.
"""

import oitbench as oit


class WeightedSum(oit.Method):
    family = "blending"
    quick = False
    expresses = oit.Effect.COVERAGE
    clamp = oit.Parameter(False, grid=(False, True), help="no negative weight of the background")
    precision = oit.Parameter("half", choices=("half", "float"), help="of every target")
    msaa = oit.MSAA

    @property
    def promises(self) -> frozenset[str]:
        kept = oit.promise(
            "single_layer_exact order_independent zero_coverage_ignored scales_with_radiance"
        )
        # A white scene before a white background stays white only with a negative weight.
        return kept | oit.promise("" if self.clamp else "white_furnace")

    @property
    def may_be_negative(self) -> bool:
        return not self.clamp

    def plan(self, request: oit.Request) -> oit.Plan:
        color = oit.Target(oit.float_format("rgba", self.precision))
        gather = oit.Gather("gather.glsl", writes={"sum": oit.ADD})
        resolve = oit.Resolve(
            "resolve.glsl", reads=("sum", "opaque_color"), writes={"color": oit.REPLACE}
        )
        return oit.Plan({"sum": color, "color": color}, (gather, resolve))

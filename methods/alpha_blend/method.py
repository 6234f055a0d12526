"""Unsorted alpha blending: the over operator in submission order.

    color <- alpha L + (1 - o) color,    o = alpha (1 - mean t)

The fastest picture, and the unit of every cost ratio: one pass, one blended target, no sort. It is
exact for one layer, and where the submission happens to run from far to near. With `msaa` 4 the
hardware blends each layer into the samples that it covers.

Source: Porter & Duff 1984 [PorterDuff1984], "Compositing Digital Images", SIGGRAPH.

Known failures: the image depends on the order of the draws. Colored transmission turns gray. A half
float stops changing where a layer adds less than 1/2048 of it.
"""

import oitbench as oit


class AlphaBlend(oit.Method):
    family = "blending"
    expresses = oit.Effect.COVERAGE
    precision = oit.Parameter("half", choices=("half", "float"), help="number format of the color")
    msaa = oit.MSAA
    promises = oit.promise(
        "single_layer_exact equal_layers_exact total_transmittance_exact zero_coverage_ignored"
        " white_furnace scales_with_radiance"
    )

    def plan(self, request: oit.Request) -> oit.Plan:
        color = oit.Target(oit.float_format("rgba", self.precision))
        return oit.Plan({"color": color}, (oit.Gather("over.glsl", writes={"color": oit.OVER}),))

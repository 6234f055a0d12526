"""Sorted blending in two passes per surface: modulate the background, then add reflected light.

    color <- tau color,    then    color <- color + alpha L

Every unit is drawn twice before the next one, from far to near: the classic way to render colored
glass with fixed-function blending, at 2n draws and twice the traffic of one pass. Sorting runs on
the CPU and is timed separately. With `msaa` 4 both halves are blended into the samples that the
surface covers.

Source: McGuire & Mara 2017 [McGuireMara2017], "Phenomenological Transparency", section 2 and
figures 7 and 12.

Known failures: exact only if each unit has one layer per pixel. With two, both are added after both
have multiplied, so the near one does not attenuate the far one.
"""

import oitbench as oit


class SortedTwoPass(oit.Method):
    family = "sorting"
    quick = False
    expresses = oit.Effect.COVERAGE | oit.Effect.COLORED_TRANSMISSION
    sort = oit.Parameter(
        "object",
        choices=("object", "triangle", "none"),
        grid=("object", "none"),
        help="unit of sorting, `none` for submission order",
    )
    precision = oit.Parameter("half", choices=("half", "float"), help="number format of the color")
    msaa = oit.MSAA

    @property
    def promises(self) -> frozenset[str]:
        kept = oit.promise(
            "single_layer_exact colored_layer_exact equal_layers_exact total_transmittance_exact"
            " zero_coverage_ignored white_furnace scales_with_radiance"
        )
        ordered = oit.promise("opaque_front_hides two_layers_ordered")
        return kept if self.sort == "none" else kept | ordered

    def plan(self, request: oit.Request) -> oit.Plan:
        color = oit.Target(oit.float_format("rgba", self.precision))
        order = oit.Order.SUBMISSION if self.sort == "none" else oit.Order(self.sort)
        modulate = oit.Gather("modulate.glsl", writes={"color": oit.MODULATE}, order=order)
        add = oit.Gather("add.glsl", writes={"color": oit.ADD}, order=order)
        return oit.Plan({"color": color}, (oit.Interleaved((modulate, add)),))

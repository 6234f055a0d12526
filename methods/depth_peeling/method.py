"""Depth peeling: each geometry pass keeps the nearest fragment that is not yet peeled.

    sum <- sum + T alpha L,    T <- T tau,    C = sum + T C0

A fragment is peeled when its depth lies beyond the last peeled depth of its pixel, compared bit for
bit. Each pass draws only the rectangle around the blocks of 16 x 16 pixels in which the one before
it found a layer. Peeling ends after the first pass that finds none, or after `layers` passes; the
result is then exact for these first layers. Fragments with zero coverage are not layers.

Memory 40 B/pixel, or 72 with floats: two depths, the peeled layer, its transmittance, and the sum
and the product of all layers.

Source: Everitt 2001 [Everitt2001], "Interactive Order-Independent Transparency", NVIDIA.

Known failures: of several fragments at exactly equal depth only the first one drawn is kept, which
also happens pixel by pixel where two meshes cross. Depth is a float: layers that are closer than
about 1e-7 of their distance count as equal. The number of geometry passes is the depth complexity
plus one.
"""

import oitbench as oit

_BLOCK = 16


class DepthPeeling(oit.Method):
    family = "exact"
    quick = False
    expresses = oit.Effect.COVERAGE | oit.Effect.COLORED_TRANSMISSION
    layers = oit.Parameter(0, low=0, help="largest number of layers to peel, 0 for all")
    precision = oit.Parameter("half", choices=("half", "float"), help="number format of all colors")
    no_msaa = (
        "each pass would shade every sample; a_buffer[msaa=4] shows the same picture in one pass"
    )

    @property
    def promises(self) -> frozenset[str]:
        kept = oit.promise(
            "single_layer_exact colored_layer_exact order_independent opaque_front_hides"
            " zero_coverage_ignored white_furnace two_layers_ordered scales_with_radiance"
        )
        return kept | oit.promise("" if self.layers else "total_transmittance_exact")

    def plan(self, request: oit.Request) -> oit.Plan:
        texel = oit.float_format("rgba", self.precision)
        peel = oit.Gather(
            "peel.glsl",
            reads=("opaque_depth", "peeled"),
            writes={"layer": oit.REPLACE, "factor": oit.REPLACE},
            depth="depth",
            clears=("depth", "layer", "factor"),
        )
        add = oit.Resolve("add.glsl", reads=("layer", "through"), writes={"sum": oit.ADD})
        attenuate = oit.Resolve(
            "attenuate.glsl", reads=("factor",), writes={"through": oit.MODULATE}
        )
        mark = oit.Resolve(
            "mark.glsl", ("layer",), {"left": oit.REPLACE}, defines={"BLOCK": _BLOCK}
        )
        loop = oit.Loop(
            (peel, add, attenuate, mark),
            times=self.layers or None,
            swaps=(("depth", "peeled"),),
            within="left",
        )
        combine = oit.Resolve(
            "combine.glsl", reads=("sum", "through"), writes={"color": oit.COMPOSITE}
        )
        return oit.Plan(
            targets={
                "color": oit.Target(texel),
                "depth": oit.Target("depth32f"),
                "peeled": oit.Target("depth32f", clear=(1.0,)),
                "layer": oit.Target(texel),
                "factor": oit.Target(texel, clear=(1.0,)),
                "sum": oit.Target(texel),
                "through": oit.Target(texel, clear=(1.0,)),
                "left": oit.Target("r8", subsample=_BLOCK),
            },
            passes=(loop, combine),
        )

"""Dual depth peeling: each geometry pass peels the nearest and the farthest remaining layer.

    front <- front + (1 - A) (alpha L, o),    back <- (alpha L, o) + (1 - o) back
    C = front + (1 - A_front) (back + (1 - A_back) C0)

A is the fourth channel. A geometry pass composites the fragments at the two depths that the
previous pass found, and finds the next two as the maximum of (d, -d) over the fragments between
them, with the inverse depth d. Depths are compared bit for bit, near before far, so an odd last
layer is taken once. Colored transmission has one opacity per channel, o = 1 - tau, and three fronts
and backs.

After each pass, the blocks of 16 x 16 pixels are marked in which a layer is left. The next pass
draws only the rectangle around them; peeling ends when there is none, after n/2 + 1 geometry passes
for n layers.

Each pass takes two layers, so an odd number of `layers` is rounded up, and the layers that remain
unseen lie in the middle of the stack. Fragments with zero coverage are not layers.

Memory 48 B/pixel; 112 where transmission is colored, and a byte for each block. A software renderer
takes most time to blend 40 bytes (104) for each fragment in each pass. A depth test that rejects
peeled fragments, half floats, or separate passes for depths and colors save no time there.

Source: Bavoil & Myers 2008 [BavoilMyers2008], "Order Independent Transparency with Dual Depth
Peeling", NVIDIA. There all targets blend by maximum, so two textures carry the front from pass to
pass, and the far layer takes another pass over the screen. Here each target has its own blend
function: front and back are composited at once by the operators under and over, and all fragments
of equal depth count, where a maximum would merge them. Their total transmittance is exact, and
their order is that of the draws.

Known failures: at exactly equal depths the order follows no rule. Depth is a float: layers that are
closer than about 1e-7 of their distance count as equal. The number of geometry passes grows with
the depth complexity.
"""

import oitbench as oit

_BLOCK = 16


class DualDepthPeeling(oit.Method):
    family = "exact"
    quick = False
    expresses = oit.Effect.COVERAGE | oit.Effect.COLORED_TRANSMISSION
    layers = oit.Parameter(0, low=0, help="largest number of layers to peel, 0 for all")
    no_msaa = (
        "each pass would shade every sample; a_buffer[msaa=4] shows the same picture in one pass"
    )

    @property
    def promises(self) -> frozenset[str]:
        kept = oit.promise(
            "single_layer_exact colored_layer_exact order_independent opaque_front_hides"
            " zero_coverage_ignored white_furnace two_layers_ordered scales_with_radiance"
        )
        every = oit.promise("equal_layers_exact total_transmittance_exact visibility_monotonic")
        return kept if self.layers else kept | every

    def plan(self, request: oit.Request) -> oit.Plan:
        curves = 3 if oit.Effect.COLORED_TRANSMISSION in request.effects else 1
        fronts, backs = (tuple(f"{name}{i}" for i in range(curves)) for name in ("front", "back"))
        edges, layer = oit.Target("rg32f", clear=(-1.0,)), oit.Target("rgba32f")
        peel = oit.Gather(
            "peel.glsl",
            reads=("edges",),
            writes={
                "bounds": oit.MAXIMUM,
                **dict.fromkeys(fronts, oit.UNDER),
                **dict.fromkeys(backs, oit.OVER),
            },
            clears=("bounds",),
        )
        mark = oit.Resolve(
            "mark.glsl", ("bounds",), {"left": oit.REPLACE}, defines={"BLOCK": _BLOCK}
        )
        loop = oit.Loop(
            (peel, mark),
            times=-(-self.layers // 2) or None,
            swaps=(("bounds", "edges"),),
            within="left",
        )
        combine = oit.Resolve(
            "combine.glsl", reads=(*fronts, *backs), writes={"color": oit.COMPOSITE}
        )
        targets = {
            "bounds": edges,
            "edges": edges,
            "left": oit.Target("r8", subsample=_BLOCK),
            **dict.fromkeys((*fronts, *backs), layer),
        }
        return oit.Plan(
            targets,
            (oit.Gather("find.glsl", writes={"edges": oit.MAXIMUM}), loop, combine),
        )

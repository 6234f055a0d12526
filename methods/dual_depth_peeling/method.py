"""Dual depth peeling: each geometry pass peels the nearest and the farthest layer that are left.

    front <- front + (1 - A) (alpha L, o),    back <- (alpha L, o) + (1 - o) back
    C = front + (1 - A_front) (back + (1 - A_back) C0)

with A the fourth channel. A geometry pass composites the fragments at the two depths that the pass
before has found, and finds the next two with a maximum of (-depth, depth) over the fragments
between them. Depths are compared bit for bit, near before far, so an odd last layer is taken once.
Colored transmission has its own opacity a channel, o = 1 - tau, and three fronts and backs. Peeling
ends after the first pass that passes no sample: n/2 + 2 geometry passes for n layers.

Parameters
----------
layers : the most layers to peel, 0 for all. Each pass takes two, so odd numbers are rounded up, and
    what remains unseen lies in the middle of the stack. What covers nothing is no layer.

Memory 48 B/pixel; 112 where transmission is colored.

Source: Bavoil & Myers 2008, "Order Independent Transparency with Dual Depth Peeling", NVIDIA. There
all targets blend by maximum, so the front is carried from pass to pass in two textures, and the far
layer takes another pass over the screen. Where each target has a blend function of its own, front
and back are composited at once by the operators under and over, and fragments of equal depth all
count, where a maximum would merge them: their total transmittance is exact and their order is that
of the draws.

Known failures: at exactly equal depths the order is not that of any rule. Window depth is a float:
layers nearer to each other than its step, at z metres 6e-8 z^2 / near, count as equal. The number
of geometry passes grows with the depth complexity.
"""

from collections.abc import Mapping

from oitbench import (
    COMPOSITE,
    MAXIMUM,
    OVER,
    UNDER,
    Draws,
    Effect,
    Loop,
    Method,
    Parameter,
    Pass,
    Step,
    Target,
)

_ALL = 1 << 17
_TINTED = Effect.COLORED_TRANSMISSION


class DualDepthPeeling(Method):
    quick = False
    expresses = Effect.COVERAGE | Effect.COLORED_TRANSMISSION
    parameters = {"layers": Parameter(0, low=0, help="most layers to peel, 0 for all")}

    @property
    def holds(self) -> frozenset[str]:
        held = {"U1", "U2", "U2c", "U4", "U5", "U7", "U8", "U9", "U10"}
        return frozenset(held if self.values["layers"] else held | {"U3", "U6", "U11"})

    @property
    def targets(self) -> Mapping[str, Target]:
        edges = Target("rg32f", clear=(-1.0,))
        layers = {f"{name}0": Target("rgba32f") for name in ("front", "back")}
        tints = {
            f"{name}{i}": Target("rgba32f", when=_TINTED)
            for name in ("front", "back")
            for i in (1, 2)
        }
        return {"bounds": edges, "edges": edges, **layers, **tints}

    @property
    def passes(self) -> tuple[Step, ...]:
        fronts, backs = (tuple(f"{name}{i}" for i in range(3)) for name in ("front", "back"))
        peel = Pass(
            "peel.glsl",
            Draws.FRAGMENTS,
            reads=("edges",),
            writes={
                "bounds": MAXIMUM,
                **dict.fromkeys(fronts, UNDER),
                **dict.fromkeys(backs, OVER),
            },
            clears=("bounds",),
        )
        loop = Loop(
            (peel,),
            times=-(-int(self.values["layers"]) // 2) or _ALL,
            until_empty=peel.name,
            swaps=(("bounds", "edges"),),
        )
        return (
            Pass("find.glsl", Draws.FRAGMENTS, writes={"edges": MAXIMUM}),
            loop,
            Pass(
                "combine.glsl",
                Draws.PIXELS,
                reads=(*fronts, *backs),
                writes={"color": COMPOSITE},
            ),
        )

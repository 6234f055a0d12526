"""Depth peeling: one geometry pass a layer, each keeping the nearest fragment not yet peeled.

    sum <- sum + T alpha L,    T <- T tau,    C = sum + T C0

A fragment is peeled when its window depth lies beyond the last peeled depth of its pixel, compared
bit for bit. Peeling ends after the first pass that passes no sample, or after `layers` passes; then
the result is that of the first layers alone, exactly.

Parameters: `layers`, the most layers to peel, 0 for all; what covers nothing is no layer.
`precision` of all colors, `half` or `float`.

Memory 40 B/pixel, or 72 with floats: two depths, the layer peeled, its transmittance, and the sum
and the product of all.

Source: Everitt 2001, "Interactive Order-Independent Transparency", NVIDIA.

Known failures: of fragments at exactly equal depth the one drawn first is kept, and the others are
lost; so they are where two meshes cross, pixel by pixel. Window depth is a float, and layers nearer
to each other than its step, at z metres 6e-8 z^2 / near, count as equal. The number of geometry
passes is the depth complexity plus one.
"""

from collections.abc import Mapping

from oitbench import (
    ADD,
    COMPOSITE,
    MODULATE,
    REPLACE,
    Draws,
    Effect,
    Loop,
    Method,
    Parameter,
    Pass,
    Step,
    Target,
)

_ALL = 1 << 16


class DepthPeeling(Method):
    quick = False
    expresses = Effect.COVERAGE | Effect.COLORED_TRANSMISSION
    parameters = {
        "layers": Parameter(0, low=0, help="most layers to peel, 0 for all"),
        "precision": Parameter("half", choices=("half", "float"), help="of every color"),
    }

    @property
    def holds(self) -> frozenset[str]:
        held = {"U1", "U2", "U2c", "U4", "U5", "U7", "U8", "U9", "U10"}
        return frozenset(held if self.values["layers"] else held | {"U6"})

    @property
    def targets(self) -> Mapping[str, Target]:
        texel = {"half": "rgba16f", "float": "rgba32f"}[self.text("precision")]
        return {
            "color": Target(texel),
            "depth": Target("depth32f", clear=(1.0,)),
            "peeled": Target("depth32f", clear=(0.0,)),
            "layer": Target(texel),
            "factor": Target(texel, clear=(1.0,)),
            "sum": Target(texel),
            "through": Target(texel, clear=(1.0,)),
        }

    @property
    def passes(self) -> tuple[Step, ...]:
        layer = ("layer", "factor")
        peel = Pass(
            "peel.glsl",
            Draws.FRAGMENTS,
            reads=("opaque_depth", "peeled"),
            writes={"layer": REPLACE, "factor": REPLACE},
            depth="depth",
            clears=("depth", *layer),
        )
        add = Pass("add.glsl", Draws.PIXELS, reads=("layer", "through"), writes={"sum": ADD})
        attenuate = Pass(
            "attenuate.glsl", Draws.PIXELS, reads=("factor",), writes={"through": MODULATE}
        )
        return (
            Loop(
                (peel, add, attenuate),
                times=int(self.values["layers"]) or _ALL,
                until_empty=peel.name,
                swaps=(("depth", "peeled"),),
            ),
            Pass(
                "combine.glsl",
                Draws.PIXELS,
                reads=("sum", "through"),
                writes={"color": COMPOSITE},
            ),
        )

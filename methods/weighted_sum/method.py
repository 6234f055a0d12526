"""Weighted sum: all layers are added, and the background by what their opacities leave of one.

    C = sum alpha L + C0 (1 - sum o),    o = alpha (1 - mean t)

The over operator to first order in o: one unordered geometry pass, one resolve, nothing that
depends on depth. 64 bits a pixel, 16 bytes of blending a fragment.

Parameters
----------
clamp : keep the background's weight from falling below zero. Without it (as published) the weight
    is negative where opacities sum to more than one, and so may the color be; a white scene before
    a white background stays white only so.
precision : of every target, `half` or `float`.

Source: Meshkin 2007, "Sort-Independent Alpha Blending", GDC.

Known failures: right for one layer and for thin ones only; opaque layers add up like thin ones, so
that deep stacks grow ever brighter, and the background turns negative.
"""

from collections.abc import Mapping

from oitbench import ADD, OVER, Draws, Effect, Method, Parameter, Pass, Target


class WeightedSum(Method):
    quick = False
    expresses = Effect.COVERAGE
    parameters = {
        "clamp": Parameter(False, grid=(False, True), help="no negative background"),
        "precision": Parameter("half", choices=("half", "float"), help="of every target"),
    }
    passes = (
        Pass("gather.glsl", Draws.FRAGMENTS, writes={"sum": ADD}),
        Pass("resolve.glsl", Draws.PIXELS, reads=("sum",), writes={"color": OVER}),
    )

    @property
    def holds(self) -> frozenset[str]:
        held = {"U1", "U2", "U4", "U7", "U10"}
        return frozenset(held if self.values["clamp"] else held | {"U8"})

    @property
    def may_be_negative(self) -> bool:
        return not self.values["clamp"]

    @property
    def targets(self) -> Mapping[str, Target]:
        texel = {"half": "rgba16f", "float": "rgba32f"}[self.text("precision")]
        return {"sum": Target(texel), "color": Target(texel)}

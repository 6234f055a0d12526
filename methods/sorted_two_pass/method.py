"""Sorted blending in two passes a surface: modulate what lies behind, then add what is reflected.

    color <- tau color,    then    color <- color + alpha L

Every unit is drawn twice before the next one, from far to near: the classic way to colored glass on
fixed-function blending, at 2n draws and twice the traffic of one pass.

Parameters: `sort` is by `object`, by `triangle` over all objects, or `none` for submission order.
Sorting runs on the CPU and is timed apart. `precision` is that of the color, `half` or `float`.

Source: McGuire & Mara 2017, "Phenomenological Transparency", section 2 and figures 7 and 12.

Known failures: exact only if each unit has one layer a pixel. With two, both are added after both
have multiplied, so the far one is not attenuated by the near one.
"""

from collections.abc import Mapping

from oitbench import (
    ADD,
    MODULATE,
    Draws,
    Effect,
    Interleaved,
    Method,
    Order,
    Parameter,
    Pass,
    Step,
    Target,
)


class SortedTwoPass(Method):
    expresses = Effect.COVERAGE | Effect.COLORED_TRANSMISSION
    quick = False
    parameters = {
        "sort": Parameter(
            "object",
            choices=("object", "triangle", "none"),
            grid=("object", "none"),
            help="unit of sorting",
        ),
        "precision": Parameter("half", choices=("half", "float"), help="of every target"),
    }

    @property
    def holds(self) -> frozenset[str]:
        held = {"U1", "U2", "U2c", "U3", "U6", "U7", "U8", "U10"}
        return frozenset(held if self.text("sort") == "none" else held | {"U5", "U9"})

    @property
    def targets(self) -> Mapping[str, Target]:
        return {"color": Target({"half": "rgba16f", "float": "rgba32f"}[self.text("precision")])}

    @property
    def passes(self) -> tuple[Step, ...]:
        sort = self.text("sort")
        order = Order.SUBMISSION if sort == "none" else Order(sort)
        modulate = Pass("modulate.glsl", Draws.FRAGMENTS, writes={"color": MODULATE}, order=order)
        add = Pass("add.glsl", Draws.FRAGMENTS, writes={"color": ADD}, order=order)
        return (Interleaved((modulate, add), order),)

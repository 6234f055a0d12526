"""Sorted blending in one pass, with wavelength-dependent transmittance.

    color <- alpha L + tau color,    tau = 1 - alpha + alpha t

Geometry is drawn from far to near. The second source of dual-source blending carries tau, so that
a single pass attenuates each channel by itself; a fixed-function blend with one source cannot.

Parameters: `sort` is by view distance of each object's bounding box center (`object`), or of each
triangle's centroid over all objects (`triangle`). Sorting runs on the CPU and is timed apart.
`precision` is that of the color, `half` or `float`.

Source: the over operator of Porter & Duff 1984 with RGB transmittance (McGuire & Mara 2017,
"Phenomenological Transparency", eq. 1 unrolled).

Known failures: objects that contain or intersect each other (`object`), triangles that intersect or
overlap in a cycle, large triangles whose centroids mislead, popping when the order flips.
"""

from collections.abc import Mapping

from oitbench import COMPOSITE, Draws, Effect, Method, Order, Parameter, Pass, Step, Target


class SortedOver(Method):
    expresses = Effect.COVERAGE | Effect.COLORED_TRANSMISSION
    requires = ("dual_source",)
    parameters = {
        "sort": Parameter(
            "triangle",
            choices=("object", "triangle"),
            grid=("object", "triangle"),
            help="unit that is sorted",
        ),
        "precision": Parameter("half", choices=("half", "float"), help="of every target"),
    }
    holds = frozenset({"U1", "U2", "U2c", "U3", "U5", "U6", "U7", "U8", "U9", "U10"})

    @property
    def targets(self) -> Mapping[str, Target]:
        return {"color": Target({"half": "rgba16f", "float": "rgba32f"}[self.text("precision")])}

    @property
    def passes(self) -> tuple[Step, ...]:
        order = Order(self.text("sort"))
        return (Pass("over.glsl", Draws.FRAGMENTS, writes={"color": COMPOSITE}, order=order),)

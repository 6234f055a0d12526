"""Sorted blending in one pass, with wavelength-dependent transmittance.

    color <- alpha L + tau color,    tau = 1 - alpha + alpha t

Geometry is drawn from far to near. The second source of dual-source blending carries tau, so that a
single pass attenuates each channel separately; fixed-function blending with one source cannot.
Sorting runs on the CPU and is timed separately. With `msaa` 4 the hardware blends each triangle
into the samples that it covers, in one order for all samples.

Source: the over operator of Porter & Duff 1984 [PorterDuff1984] with RGB transmittance (McGuire &
Mara 2017 [McGuireMara2017], "Phenomenological Transparency", eq. 1 unrolled).

Known failures: objects that contain or intersect each other (`object`), triangles that intersect or
overlap in a cycle, large triangles with misleading centroids, popping when the order flips.
"""

import oitbench as oit


class SortedOver(oit.Method):
    family = "sorting"
    expresses = oit.Effect.COVERAGE | oit.Effect.COLORED_TRANSMISSION
    sort = oit.Parameter(
        "triangle",
        choices=("object", "triangle"),
        grid=("object", "triangle"),
        help="unit of sorting: objects by bounding box center, or all triangles by centroid",
    )
    precision = oit.Parameter("half", choices=("half", "float"), help="number format of the color")
    msaa = oit.MSAA
    promises = oit.promise(
        "single_layer_exact colored_layer_exact equal_layers_exact opaque_front_hides"
        " total_transmittance_exact zero_coverage_ignored white_furnace two_layers_ordered"
        " scales_with_radiance"
    )

    def plan(self, request: oit.Request) -> oit.Plan:
        color = oit.Target(oit.float_format("rgba", self.precision))
        writes, order = {"color": oit.COMPOSITE}, oit.Order(self.sort)
        return oit.Plan({"color": color}, (oit.Gather("over.glsl", writes=writes, order=order),))

"""Alpha to coverage: a fragment covers a part of a pixel's samples, which the hardware chooses.

A fragment of net opacity o = alpha (1 - mean t) takes about o S of the S samples of its pixel, by
GL_SAMPLE_ALPHA_TO_COVERAGE. Those that pass the depth test keep its color alpha L / o and its
depth, as if it were opaque there. The picture is the mean of the samples. Nothing is sorted and
nothing is blended, so the order of the draws does not count.

Which samples a fragment takes is up to the driver; OpenGL demands no sample for o = 0, all for
o = 1, and more for a larger o. Some drivers have S + 1 masks (llvmpipe among them), others dither
them over neighboring pixels.

The method has no random numbers, and no parameters `noise` and `frames`: the masks of the hardware
are the same in every frame, and noise in the opacity would leave them nested.

Memory is 4 S bytes per pixel of depth, besides the color of S samples. A first pass copies the
depth of the opaque picture.

Source: OpenGL 4.5 [OpenGL2014], section 17.3.1; in games since Kharlamov, Cantlay & Stepanenko 2007
[Kharlamov2007], "Next-Generation SpeedTree Rendering" (GPU Gems 3, chapter 4).

Known failures: layers of equal opacity cover the same samples, so the nearest one hides the others
completely, and several transmit as much light as one. A layer has one of S + 1 opacities, off by up
to 1 / S. Light from surfaces without coverage (o = 0) is lost.
"""

import oitbench as oit


class AlphaToCoverage(oit.Method):
    family = "random"
    quick = False
    expresses = oit.Effect.COVERAGE
    msaa = oit.Parameter(4, choices=(4, 8), help="S, samples per pixel")
    promises = oit.promise(
        "order_independent opaque_front_hides zero_coverage_ignored white_furnace"
        " scales_with_radiance"
    )

    def plan(self, request: oit.Request) -> oit.Plan:
        copy = oit.Resolve("copy_depth.glsl", reads=("opaque_depth",), depth="depth")
        cover = oit.Gather(
            "cover.glsl",
            writes={"color": oit.REPLACE},
            depth="depth",
            masked_by_alpha=True,
        )
        return oit.Plan({"depth": oit.Target("depth32f")}, (copy, cover))

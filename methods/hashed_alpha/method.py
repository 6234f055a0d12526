"""Hashed alpha testing: a fragment is opaque or absent, by a threshold fixed in the scene.

A fragment of net opacity o = alpha (1 - mean t) is kept where o reaches a threshold tau, uniform in
[0, 1] and hashed from its position in world space; of those kept, the nearest is shown as
alpha L / o. The mean over thresholds is the exact picture. Positions are quantized to cells of
about `scale` pixels, so that the pattern sticks to surfaces as the camera moves:

    m = max(|dp/dx|, |dp/dy|),  s = 1 / (scale m)
    tau between the hashes of floor(2^floor(log2 s) p) and floor(2^ceil(log2 s) p), made uniform

One geometry pass writes color and its own depth buffer: 32 bits per pixel, no blending, no
resolve.

With `noise=blue`, tau comes from a blue-noise mask over the pixels, shifted at random for each
primitive and frame. Behind one layer, a sixth of the low frequencies of the error is left, behind
three layers two thirds. The pattern does not stick to surfaces then, and depends on the order of
the draws. The image of `frames` is the mean of pictures with other thresholds each; 16 bytes per
pixel hold the sum.

Sources: Wyman & McGuire 2017 [WymanMcGuire2017], "Hashed Alpha Testing", I3D; Georgiev & Fajardo
2016 [GeorgievFajardo2016], "Blue-noise dithered sampling". The hash of the former, fract(1e4 sin
...), is not uniform in single precision (on planes at 24 distances a Kolmogorov-Smirnov test finds
a median of 1.35 / sqrt(n) where chance gives 0.83) and differs between drivers; here cells are
hashed as integers.

Known failures: noise of one sample per pixel. Layers that are closer than a cell share a threshold
and transmit more light than their product, except with `noise=blue`. Light from surfaces without
coverage (o = 0) is lost.
"""

import oitbench as oit


class HashedAlpha(oit.Method):
    family = "random"
    quick = False
    noisy = True
    expresses = oit.Effect.COVERAGE
    scale = oit.Parameter(1.0, low=0.01, high=64.0, help="side of a cell in pixels")
    noise = oit.Parameter(
        "white",
        choices=("white", "blue"),
        grid=("white", "blue"),
        help="of tau over the pixels of a surface",
    )
    frames = oit.Parameter(1, low=1, high=64, help="frames whose mean is the image")
    no_msaa = (
        "a threshold belongs to a place, so the samples of a pixel would all keep or lose a layer"
    )

    @property
    def promises(self) -> frozenset[str]:
        kept = oit.promise("opaque_front_hides zero_coverage_ignored scales_with_radiance")
        return kept | oit.promise("order_independent" if self.noise == "white" else "")

    def plan(self, request: oit.Request) -> oit.Plan:
        mask = ("blue_noise",) if self.noise == "blue" else ()
        test = oit.Gather(
            "test.glsl",
            reads=("opaque_depth", *mask),
            writes={"color": oit.REPLACE},
            depth="depth",
        )
        return oit.Plan({"depth": oit.Target("depth32f")}, (test,))

"""Hashed alpha testing: a fragment is opaque or absent, by a threshold fixed in the scene.

A fragment of net opacity o = alpha (1 - mean t) is kept where o reaches a threshold tau, uniform in
[0, 1] and hashed from its position in world space; of those kept, the nearest is shown as
alpha L / o. The mean over thresholds is the exact picture. Positions are quantized to cells of
about `scale` pixels, so that the pattern sticks to surfaces as the camera moves:

    m = max(|dp/dx|, |dp/dy|),  s = 1 / (scale m)
    tau between the hashes of floor(2^floor(log2 s) p) and floor(2^ceil(log2 s) p), made uniform

One geometry pass writes color and its own depth buffer: 32 bits per pixel, no blending, no
resolve.

Source: Wyman & McGuire 2017, "Hashed Alpha Testing", I3D. Their hash, fract(1e4 sin ...), is not
uniform in single precision (on planes at 24 distances a Kolmogorov-Smirnov test finds a median of
1.35 / sqrt(n) where chance gives 0.83) and differs between drivers; here cells are hashed as
integers.

Known failures: noise of one sample per pixel. Layers that are closer than a cell share a threshold
and transmit more light than their product. Light from surfaces without coverage (o = 0) is lost.
"""

import oitbench as oit


class HashedAlpha(oit.Method):
    quick = False
    noisy = True
    expresses = oit.Effect.COVERAGE
    scale = oit.Parameter(1.0, low=0.01, high=64.0, help="side of a cell in pixels")
    no_msaa = (
        "a threshold belongs to a place, so the samples of a pixel would all keep or lose a layer"
    )
    promises = oit.promise(
        "order_independent opaque_front_hides zero_coverage_ignored scales_with_radiance"
    )

    def plan(self, request: oit.Request) -> oit.Plan:
        test = oit.Gather(
            "test.glsl", reads=("opaque_depth",), writes={"color": oit.REPLACE}, depth="depth"
        )
        return oit.Plan({"depth": oit.Target("depth32f")}, (test,))

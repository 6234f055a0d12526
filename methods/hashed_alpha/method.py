"""Hashed alpha testing: a fragment is opaque or not there, by a threshold fixed in the scene.

A fragment of net opacity o = alpha (1 - mean t) is kept where o reaches a threshold tau, uniform in
[0, 1] and hashed from its position in world space; of those kept the nearest is shown, as
alpha L / o. In the mean over thresholds that is the exact picture. Positions are quantized to cells
of about `scale` pixels, so that the pattern sticks to surfaces as the camera moves:

    m = max(|dp/dx|, |dp/dy|),  s = 1 / (scale m)
    tau between the hashes of floor(2^floor(log2 s) p) and floor(2^ceil(log2 s) p), made uniform

One geometry pass that writes color and a depth buffer of its own: 32 bits a pixel, no blending, no
resolve.

Parameters: `scale`, side of a cell in pixels.

Source: Wyman & McGuire 2017, "Hashed Alpha Testing", I3D. Their hash, fract(1e4 sin ...), is not
uniform in single precision (on planes at 24 distances a Kolmogorov-Smirnov test finds a median of
1.35 / sqrt(n) where chance gives 0.83) and differs between drivers; here cells are hashed as
integers.

Known failures: noise of one sample a pixel; layers that are closer than a cell share a threshold,
and let more light through than their product; what shines without covering (o = 0) is lost.
"""

from oitbench import REPLACE, Draws, Effect, Method, Parameter, Pass, Target


class HashedAlpha(Method):
    quick = False
    noisy = True
    expresses = Effect.COVERAGE
    parameters = {"scale": Parameter(1.0, low=0.01, high=64.0, help="side of a cell, pixels")}
    holds = frozenset({"U1", "U4", "U5", "U7", "U10"})
    targets = {"depth": Target("depth32f", clear=(1.0,))}
    passes = (
        Pass(
            "test.glsl",
            Draws.FRAGMENTS,
            reads=("opaque_depth",),
            writes={"color": REPLACE},
            depth="depth",
        ),
    )

"""Stochastic transparency: each fragment covers a random part of a pixel's samples.

A fragment of net opacity o = alpha (1 - mean t) takes R = floor(o S + xi) of S samples, xi uniform
in [0, 1), where all sets of R samples are equally likely. Every sample keeps its nearest depth z_s.
Then the share v of samples at which a fragment is visible is an unbiased estimate of its
visibility, without any sorting:

    depth:  v = #{s: z <= z_s} / S,               C = T C0 + (1 - T) sum alpha L v / sum o v
    alpha:  v = #{s taken: z = z_s} / (o S),      C = T C0 + (1 - T) sum alpha L v / sum o v
    none:   v as for `alpha`,                     C = (1 - sum o v) C0 + sum alpha L v

with the exact T = prod (1 - o). `none` and the sum of `depth` are right in the mean. A ratio of
sums is exact where all layers share a color, and slightly biased elsewhere.

Up to 32 samples share one pass, four to a target that blends by minimum. More take several rounds
with other random numbers; their uncorrected sums are averaged before one correction. Sets are drawn
by selection sampling from a hash of pixel, primitive, seed and round: no table of masks, and
different masks for each surface of a pixel. Depths are compared as they were written, and a
fragment does not hide itself. Where T hides less than 1/64, its half float is too coarse for a
correction, and `depth` uses the plain sum, which has no bias.

With `noise=blue`, xi comes from a blue-noise mask that is shifted at random for each primitive,
round and frame. It makes the error that a single layer causes smoother: of its low frequencies, a
third is left with 16 samples. Sets stay white, because the products of blue masks, which several
layers form, have more low frequencies than those of white ones. The image of `frames` is the mean
of pictures with other sets each. Its noise falls with the root of their number, but the bias of the
ratio stays, so many frames need `none`.

With `msaa` 4 depths stay one set per pixel, taken at its center, and surfaces closer than 4e-6 of
their distance do not hide each other. Memory is 4 S + 10 bytes per pixel for at most 32 samples
(4 S + 40 with `msaa`); `none` has no T and 2 bytes less. Several frames add 16 bytes per pixel and
sample of color for the sum.

Sources: Enderton et al. 2010 [Enderton2010], "Stochastic Transparency"; Salvi et al. 2011
[Salvi2011], section 4, for samples in several buffers of one pass; Georgiev & Fajardo 2016
[GeorgievFajardo2016], "Blue-noise dithered sampling".

Known failures: noise of about sqrt(v (1 - v) / S), less for a single layer. Two triangles of one
surface have different masks. Layers of exactly equal depth do not hide each other, so `none`
transmits too little light through them. `none` and `alpha` lose light from surfaces without
coverage (o = 0), and `alpha` shows too little of layers with o S < 1.
"""

import oitbench as oit

_LARGEST = 3.4028234663852886e38
_AT_ONCE = 32


class Stochastic(oit.Method):
    family = "random"
    noisy = True
    quick = False
    expresses = oit.Effect.COVERAGE
    samples = oit.Parameter(
        16,
        choices=(4, 8, 12, 16, 24, 32, 48, 64),
        grid=(4, 8, 16, 64),
        sweep=True,
        help="S, per pixel",
    )
    correction = oit.Parameter(
        "depth",
        choices=("none", "alpha", "depth"),
        help="for the true opacity of all layers, by estimates from `depth` or from `alpha`",
    )
    seed = oit.Parameter(1, low=0, high=65535, help="seed of all random numbers")
    noise = oit.Parameter(
        "white", choices=("white", "blue"), grid=("white", "blue"), help="of xi over the pixels"
    )
    frames = oit.Parameter(1, low=1, high=64, help="frames whose mean is the image")
    precision = oit.Parameter("half", choices=("half", "float"), help="of T, sums and color")
    msaa = oit.Parameter(1, choices=(1, 4), help="samples per pixel of T, sums and color")

    @property
    def promises(self) -> frozenset[str]:
        kept = oit.promise("opaque_front_hides scales_with_radiance")
        if self.correction == "depth":
            kept |= oit.promise("single_layer_exact equal_layers_exact white_furnace")
        return kept | oit.promise("" if self.correction == "none" else "total_transmittance_exact")

    def plan(self, request: oit.Request) -> oit.Plan:
        rounds = -(-self.samples // _AT_ONCE)
        depths = tuple(f"depths{i}" for i in range(self.samples // 4 // rounds))
        sizes = {"QUADS": len(depths), "ROUNDS": rounds}
        mask = ("blue_noise",) if self.noise == "blue" else ()
        again = mask if self.correction != "depth" else ()
        color = oit.Target(oit.float_format("rgba", self.precision))
        depth = oit.Target("rgba32f", clear=(_LARGEST,), single=True)
        total, attenuate = {}, []
        if self.correction != "none":
            total = {"total": oit.Target(oit.float_format("r", self.precision), clear=(1.0,))}
            attenuate = [oit.Gather("attenuate.glsl", writes={"total": oit.ATTENUATE})]
        cover = oit.Gather(
            "cover.glsl",
            reads=mask,
            writes=dict.fromkeys(depths, oit.MINIMUM),
            clears=depths if rounds > 1 else (),
            defines=sizes,
        )
        gather = oit.Gather(
            "gather.glsl", reads=(*depths, *again), writes={"sum": oit.ADD}, defines=sizes
        )
        loop = oit.Loop((cover, gather), times=rounds)
        resolve = oit.Resolve("resolve.glsl", reads=("sum", *total), writes={"color": oit.OVER})
        return oit.Plan(
            {**dict.fromkeys(depths, depth), "sum": color, **total, "color": color},
            (*attenuate, loop, resolve),
        )

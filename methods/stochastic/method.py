"""Stochastic transparency: each fragment covers a random part of a pixel's samples.

A fragment of net opacity o = alpha (1 - mean t) takes R = floor(o S + xi) of S samples, xi uniform
in [0, 1), each set of R samples as likely as any other. Every sample keeps its nearest depth z_s.
Then the share v of samples at which a fragment is seen estimates its visibility without bias, and
needs no order:

    depth:  v = #{s: z <= z_s} / S,               C = T C0 + (1 - T) sum alpha L v / sum o v
    alpha:  v = #{s taken: z = z_s} / (o S),      C = T C0 + (1 - T) sum alpha L v / sum o v
    none:   v as for alpha,                       C = (1 - sum o v) C0 + sum alpha L v

with the exact T = prod (1 - o). `none` and the sum of `depth` are right in the mean. A ratio of
sums is exact where all layers share a color, and biased a little elsewhere.

Parameters
----------
samples : S. Up to 32 share one pass, four to a target that blends by minimum. More take several
    rounds with other random numbers, whose uncorrected sums are averaged before one correction.
correction : `depth` and `alpha` correct for the true opacity of all layers, `none` does not.
seed : of all random numbers.
precision : of T, the sums and the color, `half` or `float`.
msaa : samples a pixel of T, the sums and the color, 1 or 4. Depths stay one set a pixel, taken at
    its center, and surfaces closer than 4e-6 of their distance see past each other: 4 S + 40 bytes
    a pixel.

Sets are drawn by selection sampling from a hash of pixel, primitive, seed and round: no table of
masks, and other masks for each surface of a pixel. Depths are compared as they were written, and a
fragment sees past itself. Memory is 4 S + 10 bytes a pixel for 32 samples at most; `none` has no T
and 2 bytes less. Where T hides less than 1/64, its half float is too coarse to correct anything,
and `depth` uses the plain sum, which has no bias.

Sources: Enderton et al. 2010, "Stochastic Transparency"; Salvi et al. 2011, section 4, for samples
in several buffers of one pass.

Known failures: noise of about sqrt(v (1 - v) / S), less for a single layer; two triangles of one
surface have different masks; layers of exactly one depth do not hide each other, so that `none`
lets too little light through them; `none` and `alpha` lose what shines without covering (o = 0),
and `alpha` shows too little of layers with o S < 1.
"""

from collections.abc import Mapping

from oitbench import (
    ADD,
    ATTENUATE,
    MINIMUM,
    OVER,
    Draws,
    Effect,
    Loop,
    Method,
    Parameter,
    Pass,
    Step,
    Target,
)

_LARGEST = 3.4028234663852886e38
_AT_ONCE = 32


class Stochastic(Method):
    noisy = True
    quick = False
    expresses = Effect.COVERAGE
    parameters = {
        "samples": Parameter(
            16, choices=(4, 8, 12, 16, 24, 32, 48, 64), grid=(8, 16, 64), help="S, a pixel"
        ),
        "correction": Parameter(
            "depth", choices=("none", "alpha", "depth"), help="for the true opacity"
        ),
        "seed": Parameter(1, low=0, high=65535, help="of all random numbers"),
        "precision": Parameter("half", choices=("half", "float"), help="of all but depths"),
        "msaa": Parameter(1, choices=(1, 4), help="samples a pixel of all but depths"),
    }

    @property
    def holds(self) -> frozenset[str]:
        held = {
            "none": {"U1", "U5", "U10"},
            "alpha": {"U1", "U5", "U6", "U10"},
            "depth": {"U1", "U2", "U3", "U5", "U6", "U8", "U10"},
        }
        return frozenset(held[self.text("correction")])

    @property
    def samples(self) -> int:
        return int(self.values["msaa"])

    @property
    def targets(self) -> Mapping[str, Target]:
        depths = {name: Target("rgba32f", clear=(_LARGEST,), single=True) for name in self._depths}
        bits = {"half": "16f", "float": "32f"}[self.text("precision")]
        total = {"total": Target(f"r{bits}", clear=(1.0,))} if self._corrected else {}
        color = Target(f"rgba{bits}")
        return {**depths, "sum": color, **total, "color": color}

    @property
    def passes(self) -> tuple[Step, ...]:
        sizes = {"QUADS": len(self._depths), "ROUNDS": self._rounds}
        cover = Pass(
            "cover.glsl",
            Draws.FRAGMENTS,
            writes=dict.fromkeys(self._depths, MINIMUM),
            clears=self._depths if self._rounds > 1 else (),
            defines=sizes,
        )
        gather = Pass(
            "gather.glsl", Draws.FRAGMENTS, reads=self._depths, writes={"sum": ADD}, defines=sizes
        )
        sums = ("sum", "total") if self._corrected else ("sum",)
        resolve = Pass("resolve.glsl", Draws.PIXELS, reads=sums, writes={"color": OVER})
        attenuate = Pass("attenuate.glsl", Draws.FRAGMENTS, writes={"total": ATTENUATE})
        before = (attenuate,) if self._corrected else ()
        return (*before, Loop((cover, gather), times=self._rounds), resolve)

    @property
    def _corrected(self) -> bool:
        return self.text("correction") != "none"

    @property
    def _rounds(self) -> int:
        return -(-int(self.values["samples"]) // _AT_ONCE)

    @property
    def _depths(self) -> tuple[str, ...]:
        return tuple(f"depths{i}" for i in range(int(self.values["samples"]) // 4 // self._rounds))

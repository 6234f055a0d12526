"""Phenomenological transparency: one unordered geometry pass, one resolve that bends and blurs.

    A = sum w (alpha L, o),   beta = prod (1 - alpha (1 - t)),   D^2 = sum D_i^2,   d = sum d_i
    C = beta B(d, D) + (1 - beta) S A.rgb / max(A.a, 1e-5)

with o = alpha (1 - mean t), w = clamp((10 (1 - 0.99 depth) o)^3, 0.01, 30), depth in the window.
B is the opaque picture seen at an offset of d pixels and blurred over D pixels; S is
self-modulation. For a layer at distance z before a background at z_B, f the focal length in pixels:

    D_i = f k0 (1 - c) alpha (1 - k1 / (k1 + |z_B - z|)) / z,      k0 = 0.25 m, k1 = 0.5 m

and d_i is where the ray that Snell's law bends at the surface meets a plane behind it, projected.
Nothing of this is stored that the scene does not call for: 88 bits a pixel for grey coverage, 112
with diffusion and refraction. 14 bytes are blended a fragment.

A medium is marched through in one pass over the screen: slices of its part of the view ray, each of
alpha = 1 - exp(-extinction * length), t = 0 and the middle's distance, are summed in registers as
planes would be in targets, and blended once. Light and density of a slice are those of one point in
it, L = albedo (mean radiance around + sum over lights of visibility * irradiance * phase function);
what the medium keeps back on the way from a light is left out.

Parameters
----------
depth_weight : equation of w. `eq5` as above; `g3d` is that of the authors' engine,
    clamp(o clamp(1e4 (1 - 0.99 d)^3, 1e-3, 1), 1e-3, 150).
modulation : S. `tvcg` blends half of beta's hue into A and leaves opaque layers as they are; `i3d`
    halves them; `none` is 1.
kernel : `disk` of radius D, or `gaussian` of standard deviation D, cut at 2.5 D.
weight : of a layer's blur: its coverage `alpha`, or its `net` opacity o, by which clear frosted
    glass does not blur at all.
offset : weight of a layer's refraction: its coverage `alpha`, `net` opacity, or `normalized`, the
    mean over all refracting layers by coverage (16 more bits a pixel).
reach : distance behind a surface of the plane that a bent ray is followed to: `background`, the
    opaque surface at the pixel, or `paper`, 2 m.
radius : of the blur at most, in pixels; its cost grows with the square. Blurs beyond it do not
    scale with the resolution.
subsample : pixels along each side of the blocks that particles (`Object.particles`) are accumulated
    for, in targets of their own; a joint bilateral filter spreads these over the frame before the
    resolve, and what is finer than a block is lost. All else, fog too, keeps the frame's
    resolution. 1 is without: no target, no pass.
steps : slices of the march. Their points are spread over neighboring pixels, so that too few look
    grainy, not banded: 64 err by 1/255 of the displayed range (rms) in a hall of sunbeams, twice as
    many by half. Where density is constant, transmittance is exact with any number.
precision : `paper` has 16, 8, and 8 bits a channel of A, of beta and D, and of d; with 8 bits the
    smallest blur is 3.95 pixels, and offsets have steps of half a pixel and end at 63 pixels after
    each layer, so that glass of many strongly bent layers shows streaks in the order of its draws.
    `half` and `float` have that for all targets, and `float` also for the final color.

Source: McGuire & Mara 2017, "Phenomenological transparency", IEEE TVCG, equations 1 to 14 and
listings 1 and 3; McGuire & Mara 2016, I3D. Where text and listings disagree: beta has no factor
1/3; D is weighted by alpha; k1 is the text's 0.5 m, and k0 = 0.25 m is the listing's 120/63 stored
and decoded, 381 pixel metres, over its focal lengths; f belongs into D, so that blur scales with
resolution; variances add, not deviations; the bent ray is Snell's; offsets are encoded and decoded
by 63 pixels; self-modulation is TVCG's, under which opaque layers keep their brightness.

Known failures: behind several tinted layers 8 bits hold beta to one part in three, and so S depends
on the order of the draws; a layer of colored transmission tints its own reflection by (1 - t) / (1
- mean t), and a perfectly clear one loses highlights, emission and refraction where beta rounds to
one; front layers of alpha = 1 do not hide the color of transparent layers behind them; transparent
layers do not bend or blur each other; what lies beyond the edge of the picture cannot be seen in a
bend. w reaches its clamps beyond 86 near-plane distances, where all layers weigh the same: hair
comes out as unordered blending does. So light in near fog does not outweigh that behind it. As D
weighs a slice by alpha and not by its root, fog blurs the less, the more slices it is cut into, and
most near the eye; blurs of fog below 2.8 pixels round to none in 8 bits.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace

from oitbench import (
    ADD,
    REPLACE,
    Blend,
    Draws,
    Effect,
    Factor,
    Method,
    Objects,
    Parameter,
    Pass,
    Target,
)

BACKGROUND = Blend(
    Factor.ZERO, Factor.ONE_MINUS_SOURCE_COLOR, source_alpha=Factor.ONE, target_alpha=Factor.ONE
)
"""Colors attenuate the target, as the background is; variances of blur in alpha add up."""
GATHERED = {"accum": ADD, "beta": BACKGROUND, "delta": ADD, "bending": ADD}
"""How what layers add meets each target."""


class Phenomenological(Method):
    expresses = (
        Effect.COVERAGE
        | Effect.COLORED_TRANSMISSION
        | Effect.REFRACTION
        | Effect.DIFFUSION
        | Effect.VOLUME
    )
    parameters = {
        "depth_weight": Parameter("eq5", choices=("eq5", "g3d"), help="equation of w"),
        "modulation": Parameter(
            "tvcg", choices=("none", "i3d", "tvcg"), grid=("none", "tvcg"), help="of A by beta"
        ),
        "kernel": Parameter("disk", choices=("disk", "gaussian"), help="shape of the blur"),
        "weight": Parameter("alpha", choices=("alpha", "net"), help="of a layer's blur"),
        "offset": Parameter(
            "alpha", choices=("alpha", "net", "normalized"), help="weight of a layer's refraction"
        ),
        "reach": Parameter(
            "background", choices=("background", "paper"), help="where bent rays end"
        ),
        "radius": Parameter(16, low=1, high=256, help="of the blur at most, pixels"),
        "subsample": Parameter(
            1, choices=(1, 2, 4), help="pixels a side of the blocks that particles are rendered in"
        ),
        "steps": Parameter(64, low=1, high=4096, help="of the march through a medium"),
        "precision": Parameter(
            "paper", choices=("paper", "half", "float"), grid=("paper", "half"), help="of targets"
        ),
    }

    @property
    def holds(self) -> frozenset[str]:
        always = {"U1", "U2", "U3", "U6", "U7", "U8", "U10", "U12"}
        # Hues of a beta that 8 bits hold to one part in three depend on how it was rounded.
        coarse = self.values["precision"] == "paper" and self.values["modulation"] != "none"
        if self.values["kernel"] == "gaussian":
            always -= {"U12"}  # `radius` cuts it off at a number of pixels
        return frozenset(always if coarse else always | {"U4"})

    @property
    def targets(self) -> Mapping[str, Target]:
        accum, beta, beta_and_blur, delta, covered = {
            "paper": ("rgba16f", "rgb8", "rgba8", "rg8_snorm", "r16f"),
            "half": ("rgba16f", "rgba16f", "rgba16f", "rg16f", "r16f"),
            "float": ("rgba32f", "rgba32f", "rgba32f", "rg32f", "r32f"),
        }[self.text("precision")]
        targets = {
            "accum": Target(accum, clear=(0.0,)),
            "beta": Target(
                beta, clear=(1.0, 1.0, 1.0, 0.0), instead={Effect.DIFFUSION: beta_and_blur}
            ),
            "delta": Target(delta, when=Effect.REFRACTION),
            "color": Target("rgba32f" if accum == "rgba32f" else "rgba16f"),
        }
        if self.values["offset"] == "normalized":
            targets["bending"] = Target(covered, when=Effect.REFRACTION)
        return {**targets, **self._small_targets(targets)}

    def _small_targets(self, targets: Mapping[str, Target]) -> dict[str, Target]:
        """Return what particles are accumulated in, if that has a resolution of its own."""
        subsample = int(self.values["subsample"])
        if subsample == 1:
            return {}
        small = {
            "distance": Target("r32f", subsample=subsample),
            "depth": Target("depth32f", clear=(1.0,), subsample=subsample),
        }
        small |= {k: replace(targets[k], subsample=subsample) for k in GATHERED if k in targets}
        return {f"small_{name}": target for name, target in small.items()}

    @staticmethod
    def _small_passes(gathered: Sequence[str]) -> tuple[Pass, ...]:
        """Return what comes before all else: the particles, before what is opaque."""
        return (
            Pass(
                "shrink_depth.glsl",
                Draws.PIXELS,
                reads=("opaque_depth",),
                writes={"small_distance": REPLACE},
                depth="small_depth",
                objects=Objects.PARTICLES,
            ),
            Pass(
                "gather.glsl",
                Draws.FRAGMENTS,
                reads=("small_distance",),
                writes={f"small_{name}": GATHERED[name] for name in gathered},
                tests="small_depth",
                defines={"SMALL": 1},
                objects=Objects.PARTICLES,
            ),
        )

    @staticmethod
    def _spread(gathered: Sequence[str]) -> tuple[Pass, ...]:
        """Return what adds the particles to the other layers."""
        return (
            Pass(
                "upsample.glsl",
                Draws.PIXELS,
                reads=(*(f"small_{name}" for name in gathered), "small_distance", "opaque_depth"),
                writes={name: GATHERED[name] for name in gathered},
                objects=Objects.PARTICLES,
            ),
        )

    @property
    def passes(self) -> tuple[Pass, ...]:
        gathered = [name for name in GATHERED if name in self.targets]
        mixed = self.values["subsample"] != 1
        return (
            *(self._small_passes(gathered) if mixed else ()),
            Pass(
                "gather.glsl",
                Draws.FRAGMENTS,
                reads=("opaque_depth",),
                writes={name: GATHERED[name] for name in gathered},
                objects=Objects.OTHERS if mixed else Objects.ALL,
            ),
            Pass(
                "fog.glsl",
                Draws.PIXELS,
                reads=("opaque_depth",),
                writes={"accum": ADD, "beta": BACKGROUND},
                when=Effect.VOLUME,
            ),
            *(self._spread(gathered) if mixed else ()),
            Pass(
                "resolve.glsl",
                Draws.PIXELS,
                reads=(*gathered, "opaque_color"),
                writes={"color": REPLACE},
            ),
        )

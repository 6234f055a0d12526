"""Phenomenological transparency: one unordered geometry pass, one resolve that bends and blurs.

    A = sum w (alpha L, o),   beta = prod (1 - alpha (1 - t)),   D^2 = sum D_i^2,   d = sum d_i
    C = beta B(d, D) + (1 - beta) S A.rgb / max(A.a, 1e-5)

with o = alpha (1 - mean t), w = clamp((10 (1 - 0.99 depth) o)^3, 0.01, 30), depth in the window.
B is the opaque picture seen at an offset of d pixels and blurred over D pixels; S is
self-modulation. For a layer at distance z before a background at z_B, f the focal length in pixels:

    D_i = f k0 (1 - c) alpha (1 - k1 / (k1 + |z_B - z|)) / z,      k0 = 0.25 m, k1 = 0.5 m

and d_i is the projected offset of the point where the ray that Snell's law bends at the surface
meets a plane behind it. At both faces of a solid of index N, the bent ray is the one inside, by
reversibility: eta = 1/N. Where the view ray leaves a solid, d_i changes its sign, since leaving
undoes what entering did. A slab that is tilted by an angle a then shifts the background by cos a' /
(cos a cos(a - a')) times Snell's lateral shift, with sin a' = sin a / N: for glass of N = 1.5 by
1.01 times at 10 degrees, 1.22 at 40, 1.30 at 45 and 1.80 at 60. This needs reach=background and at
least half floats. Only effects that the scene requests are stored: 88 bits per pixel for gray
coverage, 112 with diffusion and refraction. 14 bytes are blended per fragment.

A medium is marched in one pass over the screen. Slices of its part of the view ray, each with
alpha = 1 - exp(-extinction * length), t = 0 and the distance of its middle, are summed in registers
as planes would be in targets, and blended once. Light and density of a slice are those of one point
in it, L = albedo (mean radiance around + sum over lights of visibility * irradiance * phase
function); the medium's own attenuation of light on its way from a light is neglected.

Particles (`Object.particles`) can be accumulated for blocks of `subsample` pixels per side, in
targets of their own. A joint bilateral filter spreads them over the frame before the resolve, and
details finer than a block are lost. Everything else, fog included, keeps the frame's resolution.
With 1 there is no such target and no such pass.

`paper` stores A in 16 bits, and beta, D and d in 8 bits per channel. With 8 bits the smallest blur
is 3.95 pixels, and offsets have steps of half a pixel and end at 63 pixels after each layer, so
that glass of many strongly bent layers shows streaks in the order of its draws. `half` and `float`
store all targets in that format, and `float` also the final color.

Source: McGuire & Mara 2017, "Phenomenological transparency", IEEE TVCG, equations 1 to 14 and
listings 1 and 3; McGuire & Mara 2016, I3D. Where text and listings disagree: beta has no factor
1/3; D is weighted by alpha; k1 is the text's 0.5 m, and k0 = 0.25 m is the listing's 120/63 stored
and decoded, 381 pixel meters, over its focal lengths; f belongs into D, so that blur scales with
resolution; variances add, not deviations; the bent ray is Snell's, also at faces where it leaves a
solid; offsets are encoded and decoded
by 63 pixels; self-modulation is TVCG's, under which opaque layers keep their brightness.

Known failures: behind several tinted layers 8 bits resolve beta to one part in three, so S depends
on the order of the draws. A layer of colored transmission tints its own reflection by (1 - t) / (1
- mean t), and a perfectly clear one loses highlights, emission and refraction where beta rounds to
one. Front layers of alpha = 1 do not hide the color of transparent layers behind them. Transparent
layers do not bend or blur each other. A bend cannot show anything beyond the edge of the picture. w
reaches its clamps beyond 86 near-plane distances, where all layers weigh the same: hair looks as in
unordered blending, and light in near fog does not outweigh light behind it. As D weighs a slice by
alpha and not by its root, fog blurs less the more slices it is cut into, and most near the eye;
blurs of fog below 2.8 pixels round to none in 8 bits.
"""

from dataclasses import replace

import oitbench as oit

BACKGROUND = oit.Blend(
    oit.Factor.ZERO,
    oit.Factor.ONE_MINUS_SOURCE_COLOR,
    source_alpha=oit.Factor.ONE,
    target_alpha=oit.Factor.ONE,
)
"""Colors attenuate the target, as they do the background; variances of blur in alpha add up."""
GATHERED = {"accum": oit.ADD, "beta": BACKGROUND, "delta": oit.ADD, "bending": oit.ADD}
"""Blending of a layer's contribution to each target."""


class Phenomenological(oit.Method):
    expresses = (
        oit.Effect.COVERAGE
        | oit.Effect.COLORED_TRANSMISSION
        | oit.Effect.REFRACTION
        | oit.Effect.DIFFUSION
        | oit.Effect.VOLUME
    )
    depth_weight = oit.Parameter(
        "eq5",
        choices=("eq5", "g3d"),
        help="equation of w: 5, or G3D's clamp(o clamp(1e4(1 - 0.99d)^3, 1e-3, 1), 1e-3, 150)",
    )
    modulation = oit.Parameter(
        "tvcg",
        choices=("none", "i3d", "tvcg"),
        grid=("none", "tvcg"),
        help="S: `tvcg` blends half of beta's hue into A, `i3d` also halves opaque layers",
    )
    kernel = oit.Parameter(
        "disk",
        choices=("disk", "gaussian"),
        help="blur: disk of radius D, or Gaussian of standard deviation D cut at 2.5 D",
    )
    weight = oit.Parameter(
        "alpha",
        choices=("alpha", "net"),
        help="of a layer's blur: coverage, or net opacity, by which clear frosted glass is sharp",
    )
    offset = oit.Parameter(
        "alpha",
        choices=("alpha", "net", "normalized"),
        help="weight of a layer's refraction: coverage, net opacity, or mean over all by coverage",
    )
    reach = oit.Parameter(
        "background",
        choices=("background", "paper"),
        help="end of a bent ray: opaque surface at the pixel, or 2 m behind the layer",
    )
    radius = oit.Parameter(16, low=1, high=256, help="largest blur, pixels at any resolution")
    subsample = oit.Parameter(1, choices=(1, 2, 4), help="side in pixels of blocks of particles")
    steps = oit.Parameter(
        64,
        low=1,
        high=4096,
        help="of the march; 64 give an rms error of 1/255 in a hall of sunbeams, 128 half of it",
    )
    precision = oit.Parameter(
        "paper", choices=("paper", "half", "float"), grid=("paper", "half"), help="of all targets"
    )

    @property
    def promises(self) -> frozenset[str]:
        kept = oit.promise(
            "single_layer_exact equal_layers_exact total_transmittance_exact zero_coverage_ignored"
            " white_furnace scales_with_radiance"
        )
        # `radius` cuts a Gaussian off at a number of pixels.
        kept |= oit.promise("" if self.kernel == "gaussian" else "resolution_independent")
        # The hue of a beta in 8 bits depends on the order in which it was rounded.
        coarse = self.precision == "paper" and self.modulation != "none"
        return kept | oit.promise("" if coarse else "order_independent")

    def _targets(self, effects: oit.Effect) -> dict[str, oit.Target]:
        accum, beta, delta, bending = {
            "paper": ("rgba16f", "rgb8", "rg8_snorm", "r16f"),
            "half": ("rgba16f", "rgba16f", "rg16f", "r16f"),
            "float": ("rgba32f", "rgba32f", "rg32f", "r32f"),
        }[self.precision]
        if oit.Effect.DIFFUSION in effects:
            beta = beta.replace("rgb8", "rgba8")
        targets = {
            "accum": oit.Target(accum, clear=(0.0,)),
            "beta": oit.Target(beta, clear=(1.0, 1.0, 1.0, 0.0)[: 3 if beta == "rgb8" else 4]),
        }
        if oit.Effect.REFRACTION in effects:
            targets["delta"] = oit.Target(delta)
            if self.offset == "normalized":
                targets["bending"] = oit.Target(bending)
        return targets

    def plan(self, request: oit.Request) -> oit.Plan:
        targets = self._targets(request.effects)
        color = oit.Target("rgba32f" if self.precision == "float" else "rgba16f")
        depth, mixed = ("opaque_depth",), request.particles and self.subsample > 1
        writes = {name: GATHERED[name] for name in targets}
        objects = oit.Objects.OTHERS if mixed else oit.Objects.ALL
        gather = oit.Gather("gather.glsl", reads=depth, writes=writes, objects=objects)
        gathers = (gather,) if request.others or not mixed else ()
        march = oit.Resolve("fog.glsl", reads=depth, writes={"accum": oit.ADD, "beta": BACKGROUND})
        resolve = oit.Resolve(
            "resolve.glsl", reads=(*targets, "opaque_color"), writes={"color": oit.REPLACE}
        )
        fog = (march,) if oit.Effect.VOLUME in request.effects else ()
        if not mixed:
            return oit.Plan({**targets, "color": color}, (*gathers, *fog, resolve))
        small = {f"small_{name}": GATHERED[name] for name in targets}
        shrink = oit.Resolve(
            "shrink_depth.glsl",
            reads=depth,
            writes={"small_distance": oit.REPLACE},
            depth="small_depth",
        )
        particles = oit.Gather(
            "gather.glsl",
            reads=("small_distance",),
            writes=small,
            depth="small_depth",
            depth_writes=False,
            defines={"SMALL": 1},
            objects=oit.Objects.PARTICLES,
        )
        spread = oit.Resolve(
            "upsample.glsl", reads=(*small, "small_distance", *depth), writes=writes
        )
        extra = {
            "distance": oit.Target("r32f"), "depth": oit.Target("depth32f"), **targets
        }  # fmt: skip
        blocks = {f"small_{k}": replace(t, subsample=self.subsample) for k, t in extra.items()}
        steps = (shrink, particles, *gathers, *fog, spread, resolve)
        return oit.Plan({**targets, "color": color, **blocks}, steps)

"""Phenomenological transparency: one unordered geometry pass, one resolve that bends and blurs.

    A = sum w (alpha L, o),   beta = prod (1 - alpha (1 - t)),   D^2 = sum D_i^2,   d = sum d_i
    C = beta B(d, D) + (1 - beta) S A.rgb / max(A.a, 1e-5)

with o = alpha (1 - mean t), w = clamp((10 (1 - 0.99 depth) o)^3, 0.01, 30), depth in the window. B
is the opaque picture seen at an offset of d pixels and blurred by a kernel of standard deviation D
pixels along each axis: a disk of radius 2 D, or a Gaussian cut at 3.5 D. S is self-modulation. For
a layer at distance z before a background at z_B, f the focal length in pixels:

    D_i = f k0 (1 - c) alpha (1 - k1 / (k1 + |z_B - z|)) / z,      k0 = 0.375 m, k1 = 0.5 m

and d_i is the projected offset of the point where the ray that Snell's law bends at the surface
meets a plane behind it. At both faces of a solid of index N, the bent ray is the one inside, by
reversibility: eta = 1/N. Where the view ray leaves a solid, d_i changes its sign, since leaving
undoes what entering did. A slab that is tilted by an angle a then shifts the background by cos a' /
(cos a cos(a - a')) times Snell's lateral shift, with sin a' = sin a / N: for glass of N = 1.5 by
1.01 times at 10 degrees, 1.22 at 40, 1.30 at 45 and 1.80 at 60. This needs reach=background and at
least half floats.

The path tracer spreads light behind a sheet into a uniform disk of slopes of radius (1 - c) / 2.
Its blur has the deviation f (1 - c) g / (4 (z + g)) with the gap g = |z_B - z|. Both agree for k0 =
z (k1 + g) / (4 (z + g)), and the default is that of z = g = 2.5 m. Nearer to the glass, equation 7
blurs more than the path tracer, and farther from it less. Published are
[kernel=listing,limit=listing,k0=0.25,reach=fixed]: the disk has the radius D, and so half of the
deviation, and 16 pixels at most at any resolution.

Only effects that the scene requests are stored: 88 bits per pixel for gray coverage, 112 with
diffusion and refraction. 14 bytes are blended per fragment.

A medium is marched in one pass over the screen. Slices of its part of the view ray, each with alpha
= 1 - exp(-extinction * length), t = 0 and the distance of its middle, are summed in registers as
planes would be in targets, and blended once. Light and density of a slice are those of one point in
it, L = albedo (ambient radiance + sum over lights of visibility * irradiance * phase function). The
medium dims light on its way to the slice by exp(-optical depth), in closed form for a constant
density, else by the midpoint rule of `light_steps` steps. A slice of optical depth u adds u E^2 to
the variance D^2 of the blur, so that D does not depend on the number of slices. E = f s (1 - c) g /
(z + g) is the blur by slopes of one deviation s. Equation 7 grows without bound toward the eye, so
that the distance of the near plane would decide on the blur of fog. s = 2 k0 / (k1 + 2.5 m) makes
both equal at z = g = 2.5 m, and is 0.25 by default, as in the path tracer's sheets. With
weight=optical, surfaces follow this rule too, and count as at most one optical depth: planes then
blur as much as the fog that they stand for.

Particles (`Object.particles`) and the medium can be accumulated for blocks of `subsample` pixels
per side, in targets of their own. A joint bilateral filter spreads them over the frame before the
resolve, and details finer than a block are lost. Everything else keeps the frame's resolution. With
1 there is no such target and no such pass.

With `msaa` 4 each sample has targets of its own. It is shaded at its place, marched up to its own
opaque surface, and bent and blurred on the grid of the same sample of other pixels. Blocks keep one
sample.

`paper` stores A in 16 bits, and beta, D and d in 8 bits per channel. With 8 bits the smallest blur
is 3.95 pixels, and offsets have steps of half a pixel and end at 63 pixels after each layer, so
that glass of many strongly bent layers shows streaks in the order of its draws. `half` and `float`
store all targets in that format, and `float` also the final color.

Source: McGuire & Mara 2017 [McGuireMara2017], "Phenomenological transparency", IEEE TVCG, equations
1 to 14 and listings 1 and 3; McGuire & Mara 2016 [McGuireMara2016], I3D. Where text and listings
disagree: beta has no factor 1/3; D is weighted by alpha; k1 is the text's 0.5 m; k0, which the text
does not give, is chosen as above, and the listing's 120/63 stored and decoded, 381 pixel meters,
over its focal lengths is 0.25 m; f belongs into D, so that blur scales with resolution; variances
add, not deviations; the bent ray is Snell's, also at faces where it leaves a solid; offsets are
encoded and decoded by 63 pixels; self-modulation is TVCG's, under which opaque layers keep their
brightness.

Known failures: behind several tinted layers 8 bits resolve beta to one part in three, so S depends
on the order of the draws. A layer of colored transmission tints its own reflection by (1 - t) / (1
- mean t), and a perfectly clear one loses highlights, emission and refraction where beta rounds to
one. Front layers of alpha = 1 do not hide the color of transparent layers behind them. Transparent
layers do not bend or blur each other. A bend cannot show anything beyond the edge of the picture. w
grows with the cube of o, so that the light of thin smoke in front of a strong pane is lost in the
mean. It reaches its clamps beyond 86 near-plane distances, where all layers weigh the same: hair
looks as in unordered blending, and light in near fog does not outweigh light behind it. A sheet
inside fog keeps its own light: fog in front of it attenuates the background, but not the sheet.
Blurs beyond 63 pixels end there in 8 bits.
"""

from collections.abc import Mapping
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
MARCHED = ("accum", "beta")
"""Targets to which a medium contributes: it does not bend light."""
DEPTH = ("opaque_depth",)


class Phenomenological(oit.Method):
    family = "blending"
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
        choices=("disk", "gaussian", "listing"),
        help="blur of deviation D: disk, or Gaussian cut at 3.5 D; `listing`: disk of radius D",
    )
    weight = oit.Parameter(
        "alpha",
        choices=("alpha", "net", "optical"),
        help="of D: coverage, net opacity, or root of optical depth by slopes as in a medium",
    )
    k0 = oit.Parameter(
        0.375, low=0.0, high=10.0, help="of the blur, meters; 0.25 follows from listing 1"
    )
    k1 = oit.Parameter(
        0.5, low=0.01, high=100.0, help="of the blur, meters; 0.5 in the text, 0.05 in listing 1"
    )
    offset = oit.Parameter(
        "alpha",
        choices=("alpha", "net", "normalized"),
        help="weight of a layer's refraction: coverage, net opacity, or mean over all by coverage",
    )
    reach = oit.Parameter(
        "background",
        choices=("background", "fixed"),
        help="end of a bent ray: opaque surface at the pixel, or `dz` behind the layer",
    )
    dz = oit.Parameter(
        2.0, low=0.0, high=1e4, help="reach of bent rays with reach=fixed, meters; published: 2"
    )
    limit = oit.Parameter(
        "radius",
        choices=("radius", "listing"),
        help="largest radius of a blur: `radius`, or the listing's 16 pixels at any resolution",
    )
    radius = oit.Parameter(
        0.125, low=0.0, high=1.0, help="largest radius of a blur, part of the frame's height"
    )
    subsample = oit.Parameter(
        1, choices=(1, 2, 4), help="side in pixels of blocks of particles and of the medium"
    )
    steps = oit.Parameter(
        64,
        low=1,
        high=4096,
        help="of the march; 64 give an rms error of 1/255 in a hall of sunbeams, 128 half of it",
    )
    light_steps = oit.Parameter(
        8,
        low=1,
        high=32,
        help="of the march from each slice to a light, if the density of the medium varies",
    )
    precision = oit.Parameter(
        "paper", choices=("paper", "half", "float"), grid=("paper", "half"), help="of all targets"
    )
    msaa = oit.MSAA

    @property
    def promises(self) -> frozenset[str]:
        kept = oit.promise(
            "single_layer_exact equal_layers_exact total_transmittance_exact zero_coverage_ignored"
            " white_furnace scales_with_radiance"
        )
        # The listing cuts blurs off at a number of pixels.
        kept |= oit.promise("" if self.limit == "listing" else "resolution_independent")
        # The hue of a beta in 8 bits depends on the order in which it was rounded.
        coarse = self.precision == "paper" and self.modulation != "none"
        return kept | oit.promise("" if coarse else "order_independent")

    @property
    def views(self) -> Mapping[str, oit.View]:
        unit = 63.0 if self.precision == "paper" else 1.0  # UNIT of model.glsl
        diffusion, refraction = oit.Effect.DIFFUSION, oit.Effect.REFRACTION
        return {
            "accumulated": oit.View("accum", "rgb", oit.Show.SUM),
            "transmittance": oit.View("beta", "rgb", oit.Show.FRACTION),
            "diffusion": oit.View("beta", "a", scale=unit, power=0.5, unit="px", effect=diffusion),
            "refraction": oit.View(
                "delta", "rg", oit.Show.SIGNED, scale=unit, unit="px", effect=refraction
            ),
        }

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
        marches, coarse = oit.Effect.VOLUME in request.effects, self.subsample > 1
        apart = coarse and request.particles
        writes = {name: GATHERED[name] for name in targets}
        objects = oit.Objects.OTHERS if apart else oit.Objects.ALL
        gather = oit.Gather("gather.glsl", reads=DEPTH, writes=writes, objects=objects)
        gathers = (gather,) if request.others or not apart else ()
        resolve = oit.Resolve(
            "resolve.glsl", reads=(*targets, "opaque_color"), writes={"color": oit.REPLACE}
        )
        if not (apart or (coarse and marches)):
            march = (_march(DEPTH),) if marches else ()
            return oit.Plan({**targets, "color": color}, (*gathers, *march, resolve))
        shrink = oit.Resolve(
            "shrink_depth.glsl",
            reads=DEPTH,
            writes={"small_distance": oit.REPLACE},
            depth="small_depth" if apart else None,
        )
        small = {f"small_{name}": blend for name, blend in writes.items()}
        particles = oit.Gather(
            "gather.glsl",
            reads=("small_distance",),
            writes=small,
            depth="small_depth",
            depth_writes=False,
            defines={"SMALL": 1},
            objects=oit.Objects.PARTICLES,
        )
        march = (_march(("small_distance",), "small_", {"SMALL": 1}),) if marches else ()
        spread = tuple(targets) if apart else MARCHED
        upsample = oit.Resolve(
            "upsample.glsl",
            reads=(*(f"small_{name}" for name in spread), "small_distance", *DEPTH),
            writes={name: GATHERED[name] for name in spread},
            defines={"BENDS": 1} if "delta" in spread else {},
        )
        blocks = {"distance": oit.Target("r32f"), **{name: targets[name] for name in spread}}
        if apart:
            blocks["depth"] = oit.Target("depth32f")
        blocks = {
            f"small_{name}": replace(target, subsample=self.subsample, single=True)
            for name, target in blocks.items()
        }
        first = (shrink, particles) if apart else (shrink,)
        steps = (*first, *gathers, *march, upsample, resolve)
        return oit.Plan({**targets, "color": color, **blocks}, steps)


def _march(
    reads: tuple[str, ...], prefix: str = "", defines: Mapping[str, float] | None = None
) -> oit.Resolve:
    """Return the march through a medium, into the targets whose names start with `prefix`."""
    writes = {f"{prefix}{name}": GATHERED[name] for name in MARCHED}
    return oit.Resolve("fog.glsl", reads=reads, writes=writes, defines=defines or {})

"""How surfaces reflect and refract, for drjit arrays; shading in GL uses the same formulas.

Vectors are unit; `n` is on the side of `v`, which points to the eye, or to where a path came from.
"""

from __future__ import annotations

from typing import Any

from oitbench.scene import Material

HALF_SPREAD = 0.25
"""Metres behind a sheet of collimation 0 … (k₀ and k₁ of McGuire & Mara 2017, equation 7)"""
SPREAD_DISTANCE = 0.5
"""… over which the disk that a point is spread to grows by that radius."""
LEAST_BEND = 0.02
"""Least N − 1 for which the roughness of an interface is still derived from its collimation."""


def spread(collimation: float) -> float:
    """Return the radius, as a slope, of the uniform disk of directions that a sheet spreads to.

    Equation 7 blurs what lies Δz behind a layer by a radius of k₀ (1 − c) (1 − k₁/(k₁ + Δz)) at
    the layer's distance, which grows as k₀ (1 − c) Δz / k₁ from contact on.
    """
    return HALF_SPREAD / SPREAD_DISTANCE * (1 - collimation)


def interface_roughness(material: Material) -> float:
    """Return α of the Beckmann microfacets of a solid's surface; 0 for a smooth one.

    A facet tilted by a slope m turns light by (N − 1) m, and α²/2 is the variance of m along an
    axis. Entering and leaving thus spread by (N − 1)² α², which is set to the variance along an
    axis of a sheet's disk of radius R, R²/4.
    """
    if material.collimation == 1:
        return 0.0
    return min(1.0, spread(material.collimation) / 2 / max(material.index - 1, LEAST_BEND))


def schlick(drjit: Any, reflectance: Any, cosine: Any) -> Any:
    """Return Fresnel's reflectance (Schlick 1994); zero where none is at normal incidence."""
    away = 1 - drjit.clip(cosine, 0, 1)
    fifth = drjit.square(drjit.square(away)) * away
    return drjit.select(reflectance > 0, reflectance + (1 - reflectance) * fifth, 0)


def microfacets(drjit: Any, reflectance: Any, roughness: Any, n: Any, v: Any, toward: Any) -> Any:
    """Return the microfacet lobe times its cosine, sr⁻¹ (GGX; Walter et al. 2007)."""
    a2 = drjit.square(drjit.square(roughness))
    nl, nv = drjit.dot(n, toward), drjit.maximum(drjit.dot(n, v), 1e-4)
    half = drjit.normalize(toward + v)
    nh = drjit.clip(drjit.dot(n, half), 0, 1)
    density = a2 / drjit.maximum(drjit.pi * drjit.square(nh * nh * (a2 - 1) + 1), 1e-20)
    shared = nl * drjit.safe_sqrt(nv * nv * (1 - a2) + a2)
    shared += nv * drjit.safe_sqrt(nl * nl * (1 - a2) + a2)
    lobe = density * 0.5 / drjit.maximum(shared, 1e-8)
    lobe *= schlick(drjit, reflectance, drjit.dot(half, v)) * nl
    return drjit.select((a2 > 0) & (reflectance > 0) & (nl > 0), lobe, 0)


def reflected(mitsuba: Any, drjit: Any, roughness: Any, n: Any, v: Any, two: Any) -> Any:
    """Return a direction of the microfacet lobe round the mirrored one.

    The lobe keeps all light, as what it takes is what transmission loses: directions that would
    leave below the surface are turned up.
    """
    frame = mitsuba.Frame3f(n)
    local = frame.to_local(v)
    alpha = drjit.square(roughness)
    kind = mitsuba.MicrofacetType.GGX
    facets = mitsuba.MicrofacetDistribution(kind, drjit.maximum(alpha, 1e-4), True)
    normal, _ = facets.sample(local, two)
    normal = drjit.select(alpha > 0, normal, mitsuba.Normal3f(0, 0, 1))
    out = 2 * drjit.dot(local, normal) * mitsuba.Vector3f(normal) - local
    return drjit.normalize(frame.to_world(mitsuba.Vector3f(out.x, out.y, drjit.abs(out.z))))


def scattered(mitsuba: Any, drjit: Any, radius: Any, d: Any, two: Any) -> Any:
    """Return a direction of the uniform disk of slopes of `radius` round the direction `d`."""
    frame = mitsuba.Frame3f(d)
    slope = radius * mitsuba.warp.square_to_uniform_disk_concentric(two)
    return drjit.normalize(d + frame.s * slope.x + frame.t * slope.y)


def interface(
    mitsuba: Any, drjit: Any, index: Any, alpha: Any, outward: Any, v: Any, one: Any, two: Any
) -> tuple[Any, Any, Any]:
    """Reflect or refract at the boundary of a solid, whichever Fresnel's equations choose.

    Parameters
    ----------
    mitsuba, drjit : module
    index : Float
        N inside.
    alpha : Float
        Of Beckmann microfacets; 0 for a smooth surface.
    outward : Vector3f
        Normal.
    v : Vector3f
        To where the path came from, on either side.
    one, two : Float, Point2f
        Random numbers.

    Returns
    -------
    direction : Vector3f
    weight : Float
        Factor on radiance, which is squeezed where it enters.
    passed : Bool
        Whether the direction is that of refraction.
    """
    frame = mitsuba.Frame3f(outward)
    local = frame.to_local(v)
    kind = mitsuba.MicrofacetType.Beckmann
    facets = mitsuba.MicrofacetDistribution(kind, drjit.maximum(alpha, 1e-4), True)
    normal, _ = facets.sample(drjit.mulsign(local, local.z), two)
    normal = drjit.select(alpha > 0, normal, mitsuba.Normal3f(0, 0, 1))
    part, cosine, _, shrink = mitsuba.fresnel(drjit.dot(local, normal), index)
    passed = one >= part
    mirrored = 2 * drjit.dot(local, normal) * mitsuba.Vector3f(normal) - local
    bent = mitsuba.refract(local, normal, cosine, shrink)
    out = drjit.select(passed, bent, mirrored)
    shadowed = facets.smith_g1(out, normal)
    # Light that leaves a facet on the wrong side of the surface is lost, as in `roughdielectric`.
    right = (local.z * out.z > 0) ^ passed
    weight = drjit.select(alpha > 0, drjit.select(right, shadowed, 0), 1)
    weight *= drjit.select(passed, drjit.square(shrink), 1)
    return drjit.normalize(frame.to_world(out)), weight, passed

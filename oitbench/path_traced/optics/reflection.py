"""Reflection and refraction at a surface, for drjit arrays; the OpenGL shading uses equal formulas.

All vectors are unit vectors. `v` points from the surface to where the path came from, which is the
eye for the first surface. `n` is the normal on the side of `v`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any


def schlick(drjit: Any, reflectance: Any, cosine: Any) -> Any:
    """Return the Fresnel reflectance (Schlick 1994); zero where `reflectance`, F₀, is zero."""
    away = 1 - drjit.clip(cosine, 0, 1)
    fifth = drjit.square(drjit.square(away)) * away
    return drjit.select(reflectance > 0, reflectance + (1 - reflectance) * fifth, 0)


def microfacets(drjit: Any, reflectance: Any, roughness: Any, n: Any, v: Any, toward: Any) -> Any:
    """Return the microfacet lobe times the cosine of `toward`, sr⁻¹ (GGX; Walter et al. 2007)."""
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


def sample_reflection(mitsuba: Any, drjit: Any, roughness: Any, n: Any, v: Any, two: Any) -> Any:
    """Return a random direction of the microfacet lobe; the mirror direction at roughness 0.

    A direction that would leave below the surface is turned up. The lobe thus keeps all of its
    light, which is the light that transmission loses.
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


def sample_spread(mitsuba: Any, drjit: Any, radius: Any, d: Any, two: Any) -> Any:
    """Return a random direction of the uniform disk of slopes of `radius` around `d`."""
    frame = mitsuba.Frame3f(d)
    slope = radius * mitsuba.warp.square_to_uniform_disk_concentric(two)
    return drjit.normalize(d + frame.s * slope.x + frame.t * slope.y)


@dataclass(frozen=True)
class Interface:
    """The two ways in which light goes on at a facet of the boundary of a solid.

    Parameters
    ----------
    reflectance : Float
        By the Fresnel equations; one at total reflection.
    shrink : Float
        Ratio of the refractive indices. Its square is the factor on radiance of refracted light.
    mirrored, refracted : Vector3f
        Unit vectors.
    mirrored_part, refracted_part : Float
        Part of the light that other facets do not hide; one if the surface is smooth.
    """

    reflectance: Any
    shrink: Any
    mirrored: Any
    refracted: Any
    mirrored_part: Any
    refracted_part: Any


def meet_interface(
    mitsuba: Any, drjit: Any, index: Any, alpha: Any, outward: Any, v: Any, two: Any
) -> Interface:
    """Return how light is reflected and refracted at a facet, which is random if it is rough.

    Parameters
    ----------
    mitsuba, drjit : module
    index : Float
        Refractive index N inside.
    alpha : Float
        Roughness of the Beckmann microfacets; 0 for a smooth surface.
    outward : Vector3f
        Normal that points out of the solid.
    v : Vector3f
        Direction to where the path came from, on either side.
    two : Point2f
        Random numbers in [0, 1), which choose the facet.
    """
    frame = mitsuba.Frame3f(outward)
    local = frame.to_local(v)
    kind = mitsuba.MicrofacetType.Beckmann
    facets = mitsuba.MicrofacetDistribution(kind, drjit.maximum(alpha, 1e-4), True)
    normal, _ = facets.sample(drjit.mulsign(local, local.z), two)
    normal = drjit.select(alpha > 0, normal, mitsuba.Normal3f(0, 0, 1))
    reflectance, cosine, _, shrink = mitsuba.fresnel(drjit.dot(local, normal), index)
    mirrored = 2 * drjit.dot(local, normal) * mitsuba.Vector3f(normal) - local
    bent = mitsuba.refract(local, normal, cosine, shrink)

    def seen(out: Any, right: Any) -> Any:
        # Light that leaves a facet on the wrong side of the surface is lost, as in
        # `roughdielectric`.
        part = drjit.select(right, facets.smith_g1(out, normal), 0)
        return drjit.select(alpha > 0, part, 1)

    return Interface(
        reflectance,
        shrink,
        drjit.normalize(frame.to_world(mirrored)),
        drjit.normalize(frame.to_world(bent)),
        seen(mirrored, local.z * mirrored.z > 0),
        seen(bent, local.z * bent.z <= 0),
    )


def sample_interface(
    mitsuba: Any, drjit: Any, index: Any, alpha: Any, outward: Any, v: Any, one: Any, two: Any
) -> tuple[Any, Any, Any, Any]:
    """Reflect or refract at the boundary of a solid, chosen by the Fresnel equations.

    Parameters
    ----------
    mitsuba, drjit : module
    index : Float
        Refractive index N inside.
    alpha : Float
        Roughness of the Beckmann microfacets; 0 for a smooth surface.
    outward : Vector3f
        Normal that points out of the solid.
    v : Vector3f
        Direction to where the path came from, on either side.
    one, two : Float, Point2f
        Random numbers in [0, 1).

    Returns
    -------
    direction : Vector3f
    weight : Float
        Factor on radiance. It includes the squared ratio of the refractive indices, by which
        radiance changes where a path is refracted.
    passed : Bool
        Whether the direction is the refracted one.
    rest : Float
        A random number in [0, 1), which is independent of this choice.
    """
    found = meet_interface(mitsuba, drjit, index, alpha, outward, v, two)
    passed = one >= found.reflectance
    direction = drjit.select(passed, found.refracted, found.mirrored)
    bent = found.refracted_part * drjit.square(found.shrink)
    # `one` is uniform on either side of the reflectance, and is stretched again.
    chance = drjit.select(passed, 1 - found.reflectance, found.reflectance)
    rest = drjit.select(passed, one - found.reflectance, one) / drjit.maximum(chance, 1e-6)
    rest = drjit.clip(rest, 0, 1 - 2**-24)
    return direction, drjit.select(passed, bent, found.mirrored_part), passed, rest

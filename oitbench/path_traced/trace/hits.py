"""The straight lines that paths consist of, and the surfaces that they hit; for drjit arrays."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from oitbench.path_traced.optics.reflection import microfacets

STEP = 6e-7
"""Advance beyond a hit, relative to the magnitudes that are added there: five float32 roundings."""
NO_FACE = 0xFFFFFFFF
"""A number that no face has."""


@dataclass
class Line:
    """A straight part of a path.

    Parameters
    ----------
    o : Point3f
        Origin, meters.
    d : Vector3f
        Direction, a unit vector.
    along : Float
        Distance in meters from the origin up to which the line has been explored.
    known : UInt32
        Number of the face that was hit last; it is not hit again.
    """

    o: Any
    d: Any
    along: Any
    known: Any

    def where(self, drjit: Any, mask: Any, other: Line) -> Line:
        """Return this line where `mask` is set, `other` elsewhere."""
        return Line(
            drjit.select(mask, self.o, other.o),
            drjit.select(mask, self.d, other.d),
            drjit.select(mask, self.along, other.along),
            drjit.select(mask, self.known, other.known),
        )

    def onward(self, drjit: Any, hit: Hit, active: Any) -> Line:
        """Return this line, explored to beyond `hit` where `active`."""
        return Line(self.o, self.d, hit.beyond, hit.face).where(drjit, active, self)

    def turned(self, drjit: Any, hit: Hit, d: Any, active: Any) -> Line:
        """Return the line from `hit` in the direction `d` where `active`, this line elsewhere."""
        start = STEP * drjit.max(drjit.abs(hit.si.p))
        return Line(hit.si.p, d, start, hit.face).where(drjit, active, self)


@dataclass
class Hit:
    """The next intersection of a line with a triangle.

    Parameters
    ----------
    valid : Bool
        Whether the line hits anything.
    fresh : Bool
        Whether the hit counts: the triangle is drawn, and is not the one that was hit last.
    at : Float
        Distance along the line in meters; infinite where nothing is hit.
    beyond : Float
        Distance from which to continue.
    face : UInt32
        Number of the face (see `surfaces`).
    si : SurfaceInteraction3f
    n : Vector3f
        Shading normal on the side that the line comes from.
    outside : Bool
        Whether the line hits the front of the triangle.
    layer : Layer
        The material.
    """

    valid: Any
    fresh: Any
    at: Any
    beyond: Any
    face: Any
    si: Any
    n: Any
    outside: Any
    layer: Layer

    def leaving(self, mitsuba: Any, drjit: Any, toward: Any) -> Line:
        """Return the line that leaves the surface in the unit direction `toward`."""
        start = STEP * drjit.max(drjit.abs(self.si.p))
        return Line(mitsuba.Point3f(self.si.p), mitsuba.Vector3f(toward), start, self.face)

    def shadowed_up_to(self, drjit: Any, distance: Any) -> Any:
        """Return the part of the `distance` to a beam in which surfaces block its light."""
        return drjit.select(self.layer.unshadowed, 0, distance)

    def scattering(self, drjit: Any, toward: Any, glossy: bool) -> Any:
        """Return α times the part of light from `toward` that is scattered to the eye, sr⁻¹.

        `glossy` says whether any surface has a microfacet lobe.
        """
        layer = self.layer
        facing = drjit.maximum(drjit.dot(self.n, toward), 0) / drjit.pi
        facing = drjit.select(layer.isotropic, 1 / (4 * drjit.pi), facing)
        value = layer.albedo * facing
        if glossy:
            v = self.si.wi
            value += microfacets(drjit, layer.reflectance, layer.roughness, self.n, v, toward)
        return value * layer.coverage


@dataclass
class Layer:
    """The material at a hit.

    Parameters
    ----------
    coverage : Float
        α.
    light : Color3f
        α·L.
    transmission, albedo : Color3f
    fresnel : Float
        F at the angle of incidence.
    reflectance, roughness : Float
        F₀, and the square root of GGX's α.
    opaque, isotropic, unshadowed, refracts : Bool
        Whether no light passes, and whether it is a particle, receives no shadows, or is the
        boundary of a refracting solid.
    index, facets : Float
        Refractive index, and roughness α of the Beckmann microfacets, of a refracting solid.
    absorption : Color3f
        Absorption coefficient inside a refracting solid, m⁻¹.
    spread : Float
        Radius of the disk of slopes into which a frosted sheet scatters light, or a solid that is
        taken for two sheets; else 0.
    """

    coverage: Any
    light: Any
    transmission: Any
    albedo: Any
    fresnel: Any
    reflectance: Any
    roughness: Any
    opaque: Any
    isotropic: Any
    unshadowed: Any
    refracts: Any
    index: Any
    facets: Any
    absorption: Any
    spread: Any

    @property
    def passing(self) -> Any:
        """T (1 − F)(1 − albedo): the transmission t of the covered part."""
        return self.transmission * (1 - self.albedo) * (1 - self.fresnel)

    @property
    def transmittance(self) -> Any:
        """τ = 1 − α + αt."""
        return 1 - self.coverage + self.coverage * self.passing

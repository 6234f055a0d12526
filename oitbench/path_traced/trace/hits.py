"""The straight lines that paths consist of, and the surfaces that they hit; for drjit arrays."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from oitbench.path_traced.optics.advance import NO_FACE, STEP
from oitbench.path_traced.optics.reflection import microfacets
from oitbench.path_traced.optics.solids import Nest


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
    nest : Nest
        The refracting solids that the line runs inside of.
    """

    o: Any
    d: Any
    along: Any
    known: Any
    nest: Nest

    def where(self, drjit: Any, mask: Any, other: Line) -> Line:
        """Return this line where `mask` is set, `other` elsewhere."""
        return Line(
            drjit.select(mask, self.o, other.o),
            drjit.select(mask, self.d, other.d),
            drjit.select(mask, self.along, other.along),
            drjit.select(mask, self.known, other.known),
            tuple(drjit.select(mask, a, b) for a, b in zip(self.nest, other.nest, strict=True)),
        )

    def onward(self, drjit: Any, hit: Hit, active: Any) -> Line:
        """Return this line, explored to beyond `hit` where `active`."""
        return Line(self.o, self.d, hit.beyond, hit.face, hit.behind).where(drjit, active, self)

    def turned(self, drjit: Any, hit: Hit, d: Any, active: Any, crosses: Any = False) -> Line:
        """Return the line from `hit` in the direction `d` where `active`, this line elsewhere.

        `crosses` says where the line goes on behind the face of a solid.
        """
        start = STEP * drjit.max(drjit.abs(hit.si.p))
        nest = tuple(
            drjit.select(crosses, a, b) for a, b in zip(hit.behind, hit.before, strict=True)
        )
        return Line(hit.si.p, d, start, hit.face, nest).where(drjit, active, self)

    def scattered(self, p: Any, d: Any) -> Line:
        """Return the line that leaves the point `p` of a medium in the unit direction `d`."""
        zero, face = type(self.along)(0), type(self.known)(NO_FACE)
        return Line(p, d, zero, face, self.nest)


@dataclass
class Hit:
    """The next intersection of a line with a triangle.

    Parameters
    ----------
    valid : Bool
        Whether the line hits anything.
    fresh : Bool
        Whether the hit counts: the triangle is drawn, is not the one that was hit last, and is not
        hidden inside of a solid of higher priority.
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
    inner : Bool
        Whether the line comes from inside of a refracting solid.
    before, behind : Nest
        The solids on the side that the line comes from, and behind the triangle.
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
    inner: Any
    before: Nest
    behind: Nest
    layer: Layer

    def leaving(self, mitsuba: Any, drjit: Any, toward: Any) -> Line:
        """Return the line that leaves the surface in the unit direction `toward`."""
        start = STEP * drjit.max(drjit.abs(self.si.p))
        p, d = mitsuba.Point3f(self.si.p), mitsuba.Vector3f(toward)
        return Line(p, d, start, self.face, self.before)

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
        Refractive index of a refracting solid relative to what it lies in, and roughness α of its
        Beckmann microfacets.
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
    spread: Any

    @property
    def passing(self) -> Any:
        """T (1 − F)(1 − albedo): the transmission t of the covered part."""
        return self.transmission * (1 - self.albedo) * (1 - self.fresnel)

    @property
    def transmittance(self) -> Any:
        """τ = 1 − α + αt."""
        return 1 - self.coverage + self.coverage * self.passing

"""The paths of photons: refracted by solids, tinted by films, and received by every film."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

DEPTH = 32
"""Largest number of surfaces that a photon hits."""


@dataclass(frozen=True)
class Interiors:
    """The shapes of refracting solids, and what is inside of them.

    Parameters
    ----------
    shapes : sequence of (mitsuba.ShapePtr, UInt32)
        Each shape, and the number of its first face.
    rows : UInt32
        Number of the solid that each face bounds.
    absorption : Float
        σ of each solid, three channels, m⁻¹.
    kept : Float
        1 − albedo of each solid, three channels: the part of the light that enters.
    """

    shapes: Sequence[tuple[Any, Any]]
    rows: Any
    absorption: Any
    kept: Any


@dataclass(frozen=True)
class PhotonPaths:
    """The surfaces on which photons are traced.

    Parameters
    ----------
    mitsuba, drjit : module
        With a variant that is not scalar.
    scene : mitsuba.Scene
    solids : Interiors
        The refracting solids. All other surfaces are films, which let light straight through or
        not at all.
    seeds : sequence of int
        Two for each of `DEPTH` surfaces.
    """

    mitsuba: Any
    drjit: Any
    scene: Any
    solids: Interiors
    seeds: Sequence[int]

    def follow(self, ray: Any, power: Any, index: Any) -> Iterator[tuple[Any, Any, Any, Any]]:
        """Trace photons, surface by surface.

        Parameters
        ----------
        ray : Ray3f
        power : Color3f
            W for each channel.
        index : UInt32
            Numbers of the photons. They determine the random numbers.

        Yields
        ------
        point, normal : Point3f, Normal3f
            Where the photons hit a surface, and the geometric normal.
        power : Color3f
            Power that arrives there, W.
        received : Bool
            Whether the surface is a film and the light has passed a solid.
        """
        drjit, mitsuba = self.drjit, self.mitsuba
        inside = drjit.zeros(mitsuba.Color3f, len(index))
        bent = drjit.zeros(mitsuba.Bool, len(index))
        for depth in range(DEPTH):
            si = self.scene.ray_intersect(ray)
            arriving = drjit.select(si.is_valid(), power * drjit.exp(-inside * si.t), 0)
            solid, sigma, kept = self._solid(si)
            received = bent & ~solid & drjit.any(arriving > 0)
            direction, weight = self._scatter(si, solid, index, depth)
            enters = drjit.dot(direction, si.n) < 0
            passes_in = solid & enters & (drjit.dot(ray.d, si.n) < 0)
            power = arriving * weight * drjit.select(passes_in, kept, 1)
            inside = drjit.select(solid, drjit.select(enters, sigma, 0), inside)
            bent = bent | solid
            ray = si.spawn_ray(direction)
            alive = si.is_valid() & drjit.any(power > 0)
            drjit.eval(si.p, si.n, arriving, received, ray, power, inside, bent, alive)
            yield si.p, si.n, arriving, received
            left = drjit.compress(alive)
            if not len(left):
                return
            ray, power, inside, bent, index = (
                drjit.gather(type(value), value, left)
                for value in (ray, power, inside, bent, index)
            )

    def _solid(self, si: Any) -> tuple[Any, Any, Any]:
        """Return whether `si` is on a solid, σ inside, and the part of the light that enters."""
        drjit, mitsuba = self.drjit, self.mitsuba
        solid, face = mitsuba.Bool(False), mitsuba.UInt32(0)
        for shape, first in self.solids.shapes:
            here = si.shape == shape
            solid |= here
            face = drjit.select(here, first + si.prim_index, face)
        row = drjit.gather(mitsuba.UInt32, self.solids.rows, face, solid)
        sigma = drjit.gather(mitsuba.Color3f, self.solids.absorption, row, solid)
        kept = drjit.gather(mitsuba.Color3f, self.solids.kept, row, solid)
        return solid, sigma, drjit.select(solid, kept, 1)

    def _scatter(self, si: Any, solid: Any, index: Any, depth: int) -> tuple[Any, Any]:
        """Return the direction in which a photon continues, and the factor on its power."""
        drjit, mitsuba = self.drjit, self.mitsuba
        seeds = [drjit.opaque(mitsuba.UInt32, seed) for seed in self.seeds[2 * depth :][:2]]
        choice = mitsuba.sample_tea_float32(index, seeds[0])
        # A float32 holds 24 bits: the upper ones of 32.
        place = [(bits >> 8) * 2.0**-24 for bits in mitsuba.sample_tea_32(index, seeds[1])]
        # Importance mode, because refraction changes radiance but not power.
        context = mitsuba.BSDFContext(mitsuba.TransportMode.Importance)
        bsdf = si.bsdf()
        sample, weight = bsdf.sample(context, si, choice, mitsuba.Point2f(*place), solid)
        straight = bsdf.eval_null_transmission(si, si.is_valid() & ~solid)
        direction = si.to_world(drjit.select(solid, sample.wo, -si.wi))
        return direction, drjit.select(solid, weight, straight)

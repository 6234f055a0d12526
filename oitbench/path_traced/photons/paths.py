"""The paths of photons: refracted by solids, tinted by films, and received by every film."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from oitbench.path_traced.export.shapes import SOLIDS, layout, solids
from oitbench.path_traced.optics.advance import NO_FACE, STEP
from oitbench.path_traced.optics.materials import interface_roughness
from oitbench.path_traced.optics.reflection import meet_interface
from oitbench.path_traced.optics.solids import Meeting, Solids
from oitbench.scene import Floats, Scene
from oitbench.scene.texturing import constant

DEPTH = 32
"""Largest number of surfaces that a photon hits."""


@dataclass(frozen=True)
class Interiors:
    """All faces, and what is behind those of refracting solids.

    Parameters
    ----------
    offsets : UInt32
        Number of the first face of each shape, by Mitsuba's number of the shape.
    ranks : UInt32
        Rank of the solid that each face bounds, 0 for a film.
    facets : Float or None
        Roughness α of the Beckmann microfacets of each rank; None if all solids are smooth.
    culled : Bool or None
        Whether each face is a film without a back; None if there is none.
    kept : Float
        1 − albedo of each rank, three channels: the part of the light that enters.
    solids : Solids
        Photons start where its lines do.
    """

    offsets: Any
    ranks: Any
    facets: Any
    culled: Any
    kept: Any
    solids: Solids

    @classmethod
    def build(
        cls, mitsuba: Any, drjit: Any, content: Any, scene: Scene, start: Floats
    ) -> Interiors:
        """Upload the refracting solids of `scene`, for photons that start at the point `start`.

        Raises
        ------
        ValueError
            If `content` is another scene, and lacks the shape of the solids.
        """
        items = solids(scene)
        if SOLIDS not in {shape.id() for shape in content.shapes()}:
            raise ValueError(f"the Mitsuba scene has no shape {SOLIDS}; export the same scene")
        found, by_name = Solids.build(mitsuba, drjit, scene, start)
        numbers, counts, ranks = [], [], []
        groups, culled = layout(scene), [np.zeros(0, dtype=bool)]
        for shape in content.shapes():
            number = drjit.reinterpret_array(mitsuba.UInt32, mitsuba.ShapePtr(shape))
            numbers.append(int(number.numpy()[0]))
            counts.append(shape.primitive_count())
            group = groups.get(shape.id(), ())
            culled += [np.full(len(item.mesh.triangles), item.material.culled) for item in group]
            if shape.id() == SOLIDS:
                values = [by_name[item.name] for item in items]
                sizes = [len(item.mesh.triangles) for item in items]
                ranks.append(np.repeat(np.asarray(values, np.uint32), sizes))
            else:
                ranks.append(np.zeros(counts[-1], np.uint32))
        offsets = np.zeros(max(numbers) + 1, dtype=np.uint32)
        offsets[numbers] = np.cumsum([0, *counts[:-1]])
        facets, kept = np.zeros(len(by_name) + 1), np.ones((len(by_name) + 1, 3))
        for item in items:
            facets[by_name[item.name]] = interface_roughness(item.material)
            kept[by_name[item.name]] -= constant(item.material.albedo)
        return cls(
            mitsuba.UInt32(offsets),
            mitsuba.UInt32(np.concatenate(ranks)),
            mitsuba.Float(facets.astype(np.float32)) if facets.any() else None,
            mitsuba.Bool(np.concatenate(culled)) if np.concatenate(culled).any() else None,
            mitsuba.Float(kept.astype(np.float32).ravel()),
            found,
        )


@dataclass(frozen=True)
class PhotonPaths:
    """The surfaces on which photons are traced.

    Parameters
    ----------
    mitsuba, drjit : module
        With a variant that is not scalar.
    scene : mitsuba.Scene
    interiors : Interiors
        The refracting solids. All other surfaces are films, which let light straight through or
        not at all.
    seeds : sequence of int
        Two for each of `DEPTH` surfaces.
    """

    mitsuba: Any
    drjit: Any
    scene: Any
    interiors: Interiors
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
            Whether the surface is a film and the light has passed the boundary of a solid.
        """
        drjit, mitsuba, inner = self.drjit, self.mitsuba, self.interiors
        nest, known = inner.solids.start(), mitsuba.UInt32(NO_FACE)
        bent = mitsuba.Bool(False)
        for depth in range(DEPTH):
            si = self.scene.ray_intersect(ray)
            valid = si.is_valid()
            shape = drjit.reinterpret_array(mitsuba.UInt32, si.shape)
            face = drjit.gather(mitsuba.UInt32, inner.offsets, shape, valid) + si.prim_index
            # A ray crosses a triangle once. A second hit is a rounding error of the first one.
            fresh = valid & (face != known)
            rank = drjit.gather(mitsuba.UInt32, inner.ranks, face, fresh)
            film, outside = fresh & (rank == 0), drjit.dot(ray.d, si.n) < 0
            met = inner.solids.meet(nest, rank, outside, rank > 0)
            crossed = (rank > 0) & ~met.hidden
            arriving = drjit.select(valid, power * inner.solids.passing(nest, si.t, valid), 0)
            if inner.culled is not None:
                film = film & (outside | ~drjit.gather(mitsuba.Bool, inner.culled, face, fresh))
            received = bent & film & drjit.any(arriving > 0)
            d, part = self._refract(si, ray.d, met, rank, index, depth)
            d = drjit.select(crossed, d, ray.d)
            behind = ~crossed | ((drjit.dot(d, si.n) < 0) == outside)
            kept = drjit.gather(mitsuba.Color3f, inner.kept, rank, crossed & outside & behind)
            power = arriving * drjit.select(crossed, part, 1)
            power *= drjit.select(crossed & outside & behind, kept, 1)
            power *= drjit.select(film, si.bsdf().eval_null_transmission(si, film), 1)
            nest = tuple(
                drjit.select(behind, a, b) for a, b in zip(met.behind, met.before, strict=True)
            )
            bent, known = bent | crossed, face
            ray = mitsuba.Ray3f(si.p + d * (STEP * drjit.max(drjit.abs(si.p))), d)
            alive = valid & drjit.any(power > 0)
            drjit.eval(si.p, si.n, arriving, received, ray, power, nest, known, bent, alive)
            yield si.p, si.n, arriving, received
            left = drjit.compress(alive)
            if not len(left):
                return
            ray, power, known, bent, index, *slots = (
                drjit.gather(type(value), value, left)
                for value in (ray, power, known, bent, index, *nest)
            )
            nest = tuple(slots)

    def _refract(
        self, si: Any, d: Any, met: Meeting, rank: Any, index: Any, depth: int
    ) -> tuple[Any, Any]:
        """Return the direction behind or before the boundary of a solid, and a factor on power."""
        drjit, mitsuba = self.drjit, self.mitsuba
        seeds = [drjit.opaque(mitsuba.UInt32, seed) for seed in self.seeds[2 * depth :][:2]]
        choice = mitsuba.sample_tea_float32(index, seeds[0])
        # A float32 holds 24 bits: the upper ones of 32.
        place = [(bits >> 8) * 2.0**-24 for bits in mitsuba.sample_tea_32(index, seeds[1])]
        # With a constant roughness of 0, drjit leaves out the microfacets.
        alpha, facets = mitsuba.Float(0), self.interiors.facets
        if facets is not None:
            alpha = drjit.gather(mitsuba.Float, facets, rank)
        found = meet_interface(
            mitsuba, drjit, met.index, alpha, si.sh_frame.n, -d, mitsuba.Point2f(*place)
        )
        passed = choice >= found.reflectance
        # Refraction changes radiance but not power: there is no factor of the squared indices.
        part = drjit.select(passed, found.refracted_part, found.mirrored_part)
        return drjit.select(passed, found.refracted, found.mirrored), part

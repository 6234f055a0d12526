"""Next-event estimation: light from beams and from the environment at the points of a path.

Light from a beam is followed straight through films. Their transmittances color the shadow.
Refracting solids block it, because the light that they let through is a caustic, which photons
deliver. Light from the environment is followed along paths that solids refract and a medium
scatters.

Where a scene needs random numbers, a path passes many points from which it could look for light. It
looks from one of them, which reservoir sampling selects in proportion to the unshadowed light (see
`reservoirs`).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

from oitbench.path_traced.trace.hits import Hit, Line
from oitbench.path_traced.trace.lights import TracedBeam, TracedEnvironment
from oitbench.path_traced.trace.medium import TracedMedium
from oitbench.path_traced.trace.reservoirs import Candidate, Reservoir, Reservoirs
from oitbench.path_traced.trace.surfaces import Surfaces
from oitbench.scene import Scene

CrossInterface = Callable[[Line, Hit, Any, Any, Any, Any], tuple[Line, Any, Any, Any]]
"""Crosses the boundary of a refracting solid; see `PathTracer`."""
LEAST_SHARE = 0.1
"""Part of the mean radiance that is added to the weight of a direction, as solids may refract it
toward brighter parts of the environment."""
MAX_BOUNCES = 200
"""Refractions and scattering events after which light from the environment is given up."""


class LightSampler:
    """Finds the light that reaches the points of a path.

    Parameters
    ----------
    mitsuba, drjit : module
        With an LLVM or CUDA variant set.
    scene : Scene
    surfaces : Surfaces
    environment : TracedEnvironment
    medium : TracedMedium or None
    """

    def __init__(
        self,
        mitsuba: Any,
        drjit: Any,
        scene: Scene,
        surfaces: Surfaces,
        environment: TracedEnvironment,
        medium: TracedMedium | None,
    ) -> None:
        self._mitsuba, self._drjit = mitsuba, drjit
        self._surfaces, self._environment, self._medium = surfaces, environment, medium
        self._glossy = "reflectance" in surfaces.has
        self._beams = [TracedBeam(mitsuba, drjit, light) for light in scene.beams]

    def empty(self) -> Reservoirs:
        """Return reservoirs without candidates."""
        diffuse = self._environment.lights and "albedo" in self._surfaces.has
        beam = bool(self._beams)
        medium = beam and self._medium is not None
        needed = (beam, medium, medium, diffuse)
        mitsuba, drjit = self._mitsuba, self._drjit
        line = self._surfaces.eye_line(mitsuba.Point3f(0), mitsuba.Vector3f(0, 0, 1))
        found = [Reservoir.empty(mitsuba, drjit, line) if one else None for one in needed]
        return Reservoirs(*found)

    def beam_light(self, line: Line, hit: Hit, active: Any) -> Any:
        """Return α·L that all beams cause at `hit`, without random numbers."""
        mitsuba, drjit = self._mitsuba, self._drjit
        total = mitsuba.Color3f(0)
        for beam in self._beams:
            toward, distance, arriving = beam.toward(hit.si.p)
            value = hit.scattering(drjit, toward, self._glossy) * arriving
            lit = active & drjit.any(value > 0)
            limit = hit.shadowed_up_to(drjit, distance)
            part = self._transmittance(hit.leaving(mitsuba, drjit, toward), limit, lit)
            total += drjit.select(lit, value * part, 0)
        return total

    def add_surface(
        self,
        reservoirs: Reservoirs,
        hit: Hit,
        throughput: Any,
        look: tuple[Any, Any],
        rng: Any,
        active: Any,
    ) -> tuple[Reservoirs, Any]:
        """Add the candidates of a surface: one for each beam, and one for the environment.

        `look` are the random numbers of the latter's direction, Float and Point2f.
        """
        mitsuba, drjit, layer = self._mitsuba, self._drjit, hit.layer
        active = active & (hit.outside | ~layer.refracts)
        beam, environment = reservoirs.surface_beam, reservoirs.environment
        for light in self._beams:
            toward, distance, arriving = light.toward(hit.si.p)
            value = throughput * hit.scattering(drjit, toward, self._glossy) * arriving
            limit = hit.shadowed_up_to(drjit, distance)
            found = Candidate(hit.leaving(mitsuba, drjit, toward), limit, value, drjit.mean(value))
            assert beam is not None
            beam, rng = beam.add(mitsuba, drjit, found, rng, active)
        if environment is not None:
            found = self._environment_candidate(hit, throughput, *look)
            environment, rng = environment.add(mitsuba, drjit, found, rng, active)
        return replace(reservoirs, surface_beam=beam, environment=environment), rng

    def _environment_candidate(self, hit: Hit, throughput: Any, one: Any, two: Any) -> Candidate:
        """Return a candidate in one random direction."""
        mitsuba, drjit, layer = self._mitsuba, self._drjit, hit.layer

        def density(d: Any) -> Any:
            lambert = drjit.maximum(drjit.dot(hit.n, d), 0) / drjit.pi
            return drjit.select(layer.isotropic, 1 / (4 * drjit.pi), lambert)

        own = drjit.select(
            layer.isotropic,
            mitsuba.warp.square_to_uniform_sphere(two),
            mitsuba.Frame3f(hit.n).to_world(mitsuba.warp.square_to_cosine_hemisphere(two)),
        )
        d, chance = self._environment.sample_direction(hit.si, own, density, one, two)
        factor = throughput * layer.coverage * layer.albedo * (density(d) / chance)
        floor = mitsuba.Color3f(*[LEAST_SHARE * part for part in self._environment.mean])
        weight = drjit.mean(factor * (self._environment.radiance(d) + floor))
        infinite = mitsuba.Float(drjit.inf)
        leaving = hit.leaving(mitsuba, drjit, d)
        return Candidate(leaving, infinite, mitsuba.Color3f(factor), weight)

    def add_medium(
        self,
        selected: Reservoir | None,
        line: Line,
        end: Any,
        throughput: Any,
        place: Any,
        rng: Any,
        active: Any,
    ) -> tuple[Reservoir | None, Any]:
        """Add one candidate for each beam, at a random point of the medium on `line` before `end`.

        `place` is the random number that chooses the point. The environment needs no candidate: the
        path itself reaches it where it leaves the medium.
        """
        mitsuba, drjit, medium = self._mitsuba, self._drjit, self._medium
        assert medium is not None
        if selected is None:
            return None, rng
        near, far = medium.clip(line.o, line.d, line.along, end)
        crosses = active & (near < far)
        for light in self._beams:
            at, chance = light.sample_distance(line.o, line.d, near, far, medium.falloff, place)
            p = line.o + line.d * drjit.select(crosses, at, 0)
            toward, distance, arriving = light.toward(p)
            part = medium.transmittance(line.o, line.d, near, at, crosses)
            part *= medium.extinction(p, crosses) * medium.phase(drjit.dot(toward, line.d)) / chance
            value = throughput * medium.albedo * arriving * part
            part *= self._surfaces.passing(line, at, crosses)
            leaving = line.scattered(p, toward)
            found = Candidate(leaving, distance, value, drjit.mean(value))
            selected, rng = selected.add(mitsuba, drjit, found, rng, crosses)
        return selected, rng

    def _transmittance(self, line: Line, limit: Any, active: Any) -> Any:
        """Return the transmittance of all surfaces on a straight line up to `limit`."""
        drjit, mitsuba = self._drjit, self._mitsuba

        def step(line: Line, part: Any, active: Any) -> tuple[Any, ...]:
            hit = self._surfaces.intersect(line, active, limit, to_light=True)
            part = drjit.select(hit.fresh, part * self._film_transmittance(hit), part)
            line = line.onward(drjit, hit, hit.valid)
            return line, part, hit.valid & drjit.any(part > 0)

        state = (line, mitsuba.Color3f(1), active)
        return drjit.while_loop(state, lambda *v: v[2], step)[1]

    def _film_transmittance(self, hit: Hit) -> Any:
        """Return τ; refracting solids block."""
        layer = hit.layer
        passing = self._drjit.select(layer.refracts, 0, layer.passing)
        return 1 - layer.coverage + layer.coverage * passing

    def selected_light(self, reservoirs: Reservoirs, rng: Any, cross: CrossInterface) -> Any:
        """Return the light of the selected candidates, with everything that is in the way."""
        found = self._mitsuba.Color3f(0)
        beams = reservoirs.surface_beam, reservoirs.single_beam, reservoirs.medium_beam
        for reservoir in beams:
            if reservoir is not None:
                found += self._selected_beam(reservoir)
        if reservoirs.environment is not None:
            found += self._selected_environment(reservoirs.environment, rng, cross)
        return found

    def _selected_beam(self, selected: Reservoir) -> Any:
        line, lit = selected.line, selected.total > 0
        light = selected.value * selected.total * self._transmittance(line, selected.limit, lit)
        if self._medium is not None:
            o, d, start, end = line.o, line.d, line.along, selected.limit
            light *= self._medium.transmittance(o, d, start, end, lit)
        return self._drjit.select(lit, light, 0)

    def _selected_environment(self, selected: Reservoir, rng: Any, cross: CrossInterface) -> Any:
        mitsuba, drjit, medium = self._mitsuba, self._drjit, self._medium
        refracts = "refracts" in self._surfaces.has

        def step(
            line: Line, throughput: Any, bounces: Any, rng: Any, active: Any
        ) -> tuple[Any, ...]:
            hit, start = self._surfaces.intersect(line, active, to_light=True), line
            end = hit.at
            collides = mitsuba.Bool(False)
            if medium is not None:
                at, rng = medium.sample_free_path(line.o, line.d, line.along, hit.at, rng, active)
                collides = active & (at < drjit.inf)
                p = line.o + line.d * drjit.select(collides, at, 0)
                end = drjit.minimum(at, hit.at)
            throughput = throughput * self._surfaces.passing(line, end, active)
            here = active & ~collides
            solid = here & hit.fresh & hit.layer.refracts
            film = here & hit.fresh & ~hit.layer.refracts
            tinted = throughput * self._film_transmittance(hit)
            throughput = drjit.select(film, tinted, throughput)
            line = line.onward(drjit, hit, here & hit.valid & ~solid)
            if refracts:
                one, two = rng.next_float32(solid), rng.next_float32(solid)
                two = mitsuba.Point2f(two, rng.next_float32(solid))
                line, factor, _, rng = cross(line, hit, one, two, rng, solid)
                throughput = drjit.select(solid, throughput * factor, throughput)
            if medium is not None:
                two = mitsuba.Point2f(rng.next_float32(collides), rng.next_float32(collides))
                out = medium.sample_phase(start.d, two)
                line = start.scattered(p, out).where(drjit, collides, line)
                throughput = drjit.select(collides, throughput * medium.albedo, throughput)
            bounces = bounces + drjit.select(solid | collides, mitsuba.UInt32(1), 0)
            active = active & (collides | hit.valid) & drjit.any(throughput > 0)
            return line, throughput, bounces, rng, active & (bounces < MAX_BOUNCES)

        start = mitsuba.Color3f(1), mitsuba.UInt32(0), rng, selected.total > 0
        state = drjit.while_loop((selected.line, *start), lambda *v: v[4], step)
        line, throughput, bounces = state[:3]
        radiance = self._environment.radiance(line.d)
        found = throughput * selected.value * selected.total * radiance
        return drjit.select((selected.total > 0) & (bounces < MAX_BOUNCES), found, 0)

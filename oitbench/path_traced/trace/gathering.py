"""Looking for light: from one place toward a beam or the surroundings.

Beams are looked for straight through films, each tinting by its transmittance, so that shadows are
colored; solids that refract stop them, as what they let through is a caustic. The surroundings are
looked for along paths that solids bend and a medium scatters.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from oitbench.path_traced.trace.medium import Fog
from oitbench.path_traced.trace.reflection import microfacets
from oitbench.path_traced.trace.surfaces import NOWHERE, STEP, Hit, Line, Surfaces
from oitbench.path_traced.trace.surroundings import Beam, Surroundings
from oitbench.scene import Scene

Bend = Callable[[Line, Hit, Any, Any, Any], tuple[Line, Any, Any, Any]]
"""Crosses the boundary of a solid; see `walk`."""
LEAST_SHARE = 0.1
"""Part of the mean radiance that a direction's weight counts at least, as solids may bend it."""
MOST_TURNS = 200
"""Turns after which light from the surroundings is given up."""


@dataclass
class Choice:
    """Of all places from which a path could look for light, the one that was chosen.

    Parameters
    ----------
    line : Line
        From the place toward the light.
    limit : Float
        Metres to the light.
    value : Color3f
        What arrives without shadow, over its weight; for the surroundings without their radiance.
    total : Float
        Sum of all weights.
    """

    line: Line
    limit: Any
    value: Any
    total: Any


@dataclass
class Choices:
    """What was chosen for beams on surfaces and in a medium, and for the surroundings, or None.

    Shadows make weights wrong: what lies in the one's shadow must not keep the others from being
    chosen.
    """

    beam: Choice | None
    shaft: Choice | None
    around: Choice | None


class Gathering:
    """Looks for the lights of a scene."""

    def __init__(
        self,
        mitsuba: Any,
        drjit: Any,
        scene: Scene,
        surfaces: Surfaces,
        around: Surroundings,
        fog: Fog | None,
    ) -> None:
        self._mitsuba, self._drjit = mitsuba, drjit
        self._surfaces, self._around, self._fog = surfaces, around, fog
        self._beams = [Beam(mitsuba, drjit, light) for light in scene.beams]

    def nothing(self) -> Choices:
        """Return choices of nothing."""
        diffuse = self._around.lights and "albedo" in self._surfaces.has
        beam = bool(self._beams)
        wanted = (beam, beam and self._fog is not None, diffuse)
        return Choices(*[self._empty() if needed else None for needed in wanted])

    def _empty(self) -> Choice:
        mitsuba, drjit = self._mitsuba, self._drjit
        zero, color = mitsuba.Float(0), mitsuba.Color3f(0)
        line = Line(mitsuba.Point3f(0), mitsuba.Vector3f(0, 0, 1), zero, mitsuba.UInt32(0))
        return Choice(line, mitsuba.Float(drjit.inf), color, zero)

    def light_at(self, line: Line, hit: Hit, active: Any) -> Any:
        """Return α·L that the beams cause at `hit`; nothing in the way may be random."""
        drjit = self._drjit
        total = self._mitsuba.Color3f(0)
        for beam in self._beams:
            toward, distance, arriving = beam.toward(hit.si.p)
            value = self._scattering(line, hit, toward) * arriving
            lit = active & drjit.any(value > 0)
            part = self._straight(self._leaving(hit, toward), distance, lit)
            total += drjit.select(lit, value * part, 0)
        return total

    def offer(
        self, choices: Choices, line: Line, hit: Hit, through: Any, rng: Any, active: Any
    ) -> tuple[Choices, Any]:
        """Offer what each light causes at `hit`."""
        drjit, layer = self._drjit, hit.layer
        active = active & (hit.outside | ~layer.refracts)
        beam, around = choices.beam, choices.around
        for light in self._beams:
            toward, distance, arriving = light.toward(hit.si.p)
            value = through * self._scattering(line, hit, toward) * arriving
            offered = Choice(self._leaving(hit, toward), distance, value, drjit.mean(value))
            beam, rng = self._weigh(beam, offered, rng, active)
        if around is not None:
            offered, rng = self._toward_surroundings(hit, through, rng, active)
            around, rng = self._weigh(around, offered, rng, active)
        return Choices(beam, choices.shaft, around), rng

    def _toward_surroundings(
        self, hit: Hit, through: Any, rng: Any, active: Any
    ) -> tuple[Choice, Any]:
        """Return the offer of one direction to look for the surroundings in."""
        mitsuba, drjit, layer = self._mitsuba, self._drjit, hit.layer

        def density(d: Any) -> Any:
            lambert = drjit.maximum(drjit.dot(hit.n, d), 0) / drjit.pi
            return drjit.select(layer.isotropic, 1 / (4 * drjit.pi), lambert)

        two = mitsuba.Point2f(rng.next_float32(active), rng.next_float32(active))
        own = drjit.select(
            layer.isotropic,
            mitsuba.warp.square_to_uniform_sphere(two),
            mitsuba.Frame3f(hit.n).to_world(mitsuba.warp.square_to_cosine_hemisphere(two)),
        )
        one = rng.next_float32(active)
        d, chance = self._around.choose(hit.si, own, density, one, two)
        factor = through * layer.coverage * layer.albedo * (density(d) / chance)
        floor = mitsuba.Color3f(*[LEAST_SHARE * part for part in self._around.mean])
        weight = drjit.mean(factor * (self._around.radiance(d) + floor))
        infinite = mitsuba.Float(drjit.inf)
        return Choice(self._leaving(hit, d), infinite, mitsuba.Color3f(factor), weight), rng

    def offer_in_fog(
        self, choices: Choices, line: Line, end: Any, through: Any, rng: Any, active: Any
    ) -> tuple[Choices, Any]:
        """Offer what each beam causes in the medium at one place on `line` before `end`.

        The surroundings are met by the path itself, where it leaves the medium.
        """
        mitsuba, drjit, fog = self._mitsuba, self._drjit, self._fog
        assert fog is not None
        shaft = choices.shaft
        near, far = fog.within(line.o, line.d, line.along, end)
        crosses = active & (near < far)
        for light in self._beams:
            one = rng.next_float32(crosses)
            at, chance = light.place(line.o, line.d, near, far, fog.falloff, one)
            p = line.o + line.d * drjit.select(crosses, at, 0)
            toward, distance, arriving = light.toward(p)
            part, rng = fog.transmittance(line.o, line.d, near, at, rng, crosses)
            part *= fog.extinction(p, crosses) * fog.phase(drjit.dot(toward, line.d)) / chance
            value = through * fog.albedo * arriving * part
            leaving = Line(p, toward, mitsuba.Float(0), mitsuba.UInt32(NOWHERE))
            offered = Choice(leaving, distance, value, drjit.mean(value))
            shaft, rng = self._weigh(shaft, offered, rng, crosses)
        return Choices(choices.beam, shaft, choices.around), rng

    def _scattering(self, line: Line, hit: Hit, toward: Any) -> Any:
        """Return α times what the surface turns to the eye of the light from `toward`, sr⁻¹."""
        drjit, layer = self._drjit, hit.layer
        facing = drjit.maximum(drjit.dot(hit.n, toward), 0) / drjit.pi
        facing = drjit.select(layer.isotropic, 1 / (4 * drjit.pi), facing)
        value = layer.albedo * facing
        if "reflectance" in self._surfaces.has:
            value += microfacets(drjit, layer.reflectance, layer.roughness, hit.n, -line.d, toward)
        return value * layer.coverage

    def _leaving(self, hit: Hit, toward: Any) -> Line:
        mitsuba, drjit = self._mitsuba, self._drjit
        start = STEP * drjit.max(drjit.abs(hit.si.p))
        return Line(mitsuba.Point3f(hit.si.p), mitsuba.Vector3f(toward), start, hit.face)

    def _weigh(
        self, choice: Choice | None, offered: Choice, rng: Any, active: Any
    ) -> tuple[Choice, Any]:
        """Replace `choice` with a probability of the new one's weight in the sum of all."""
        drjit, mitsuba = self._drjit, self._mitsuba
        assert choice is not None
        active = active & (offered.total > 0)
        total = choice.total + drjit.select(active, offered.total, 0)
        taken = active & (rng.next_float32(active) * total < offered.total)
        value = mitsuba.Color3f(offered.value / offered.total)
        chosen = Choice(
            offered.line.where(drjit, taken, choice.line),
            drjit.select(taken, offered.limit, choice.limit),
            drjit.select(taken, value, choice.value),
            total,
        )
        return chosen, rng

    def _straight(self, line: Line, limit: Any, active: Any) -> Any:
        """Return the transmittance of all surfaces on a straight line up to `limit`."""
        drjit, mitsuba = self._drjit, self._mitsuba

        def step(line: Line, part: Any, active: Any) -> tuple[Any, ...]:
            hit = self._surfaces.meet(line, active, limit)
            part = drjit.select(hit.fresh, part * self._tint(hit), part)
            line = self._surfaces.onward(line, hit, hit.valid)
            return line, part, hit.valid & drjit.any(part > 0)

        state = (line, mitsuba.Color3f(1), active)
        return drjit.while_loop(state, lambda *v: v[2], step)[1]

    def _tint(self, hit: Hit) -> Any:
        """Return τ, as a beam sees it."""
        layer = hit.layer
        passing = self._drjit.select(layer.refracts, 0, layer.passing)
        return 1 - layer.coverage + layer.coverage * passing

    def chosen_light(self, choices: Choices, rng: Any, bend: Bend) -> Any:
        """Return the light at the places that were chosen, with all that is in the way."""
        found = self._mitsuba.Color3f(0)
        for choice in (choices.beam, choices.shaft):
            if choice is not None:
                light, rng = self._beam_light(choice, rng)
                found += light
        if choices.around is not None:
            found += self._surrounding_light(choices.around, rng, bend)
        return found

    def _beam_light(self, choice: Choice, rng: Any) -> tuple[Any, Any]:
        line, lit = choice.line, choice.total > 0
        light = choice.value * choice.total * self._straight(line, choice.limit, lit)
        if self._fog is not None:
            o, d, start, end = line.o, line.d, line.along, choice.limit
            part, rng = self._fog.transmittance(o, d, start, end, rng, lit)
            light *= part
        return self._drjit.select(lit, light, 0), rng

    def _surrounding_light(self, choice: Choice, rng: Any, bend: Bend) -> Any:
        mitsuba, drjit, fog = self._mitsuba, self._drjit, self._fog
        bends = "refracts" in self._surfaces.has

        def step(
            line: Line, through: Any, since: Any, turns: Any, rng: Any, active: Any
        ) -> tuple[Any, ...]:
            hit, start = self._surfaces.meet(line, active), line
            collides = mitsuba.Bool(False)
            if fog is not None:
                at, rng = fog.free_path(line.o, line.d, line.along, hit.at, rng, active)
                collides = active & (at < drjit.inf)
                p = line.o + line.d * drjit.select(collides, at, 0)
            here = active & ~collides
            solid = here & hit.fresh & hit.layer.refracts
            film = here & hit.fresh & ~hit.layer.refracts
            through = drjit.select(film, through * self._tint(hit), through)
            line = self._surfaces.onward(line, hit, here & hit.valid & ~solid)
            if bends:
                since = since + drjit.select(here & ~solid, hit.at - start.along, 0)
                line, factor, since, rng = bend(line, hit, since, rng, solid)
                through = drjit.select(solid, through * factor, through)
            if fog is not None:
                two = mitsuba.Point2f(rng.next_float32(collides), rng.next_float32(collides))
                out = fog.scattered(start.d, two)
                scattered = Line(p, out, mitsuba.Float(0), mitsuba.UInt32(NOWHERE))
                line = scattered.where(drjit, collides, line)
                through = drjit.select(collides, through * fog.albedo, through)
            turns = turns + drjit.select(solid | collides, mitsuba.UInt32(1), 0)
            active = active & (collides | hit.valid) & drjit.any(through > 0)
            return line, through, since, turns, rng, active & (turns < MOST_TURNS)

        start = mitsuba.Color3f(1), mitsuba.Float(0), mitsuba.UInt32(0), rng, choice.total > 0
        state = drjit.while_loop((choice.line, *start), lambda *v: v[5], step)
        line, through, _, turns = state[:4]
        found = through * choice.value * choice.total * self._around.radiance(line.d)
        return drjit.select((choice.total > 0) & (turns < MOST_TURNS), found, 0)

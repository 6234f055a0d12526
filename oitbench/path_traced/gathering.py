"""Looking for light: from one place toward a beam or the surroundings.

Beams are looked for straight through films, each tinting by its transmittance, so that shadows are
colored; solids that refract stop them, as what they let through is a caustic. The surroundings are
looked for along paths that solids bend and a medium scatters.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from oitbench.path_traced.fog import Fog
from oitbench.path_traced.reflection import microfacets
from oitbench.path_traced.surfaces import STEP, Hit, Line, Surfaces
from oitbench.path_traced.surroundings import Beam, Surroundings
from oitbench.scene import Scene

LEAST_SHARE = 0.1
"""Part of the mean radiance that a direction's weight counts at least, as solids may bend it."""
MOST_TURNS = 200
"""Turns after which light from the surroundings is given up."""


@dataclass
class Choice:
    """Of all places and lights that a path offered, the one that was chosen.

    Parameters
    ----------
    line : Line
        From the place toward the light.
    limit : Float
        Metres to the light.
    value : Color3f
        What arrives without shadow, over the weight; for the surroundings without their radiance.
    around : Bool
        Whether it is the surroundings.
    inside : Bool
        Whether the place is in no solid: always but for paths that begin behind a back face.
    total : Float
        Sum of all weights.
    """

    line: Line
    limit: Any
    value: Any
    around: Any
    total: Any


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

    def nothing(self) -> Choice:
        """Return a choice of nothing."""
        mitsuba, drjit = self._mitsuba, self._drjit
        zero, color = mitsuba.Float(0), mitsuba.Color3f(0)
        line = Line(mitsuba.Point3f(0), mitsuba.Vector3f(0, 0, 1), zero, mitsuba.UInt32(0))
        return Choice(line, mitsuba.Float(drjit.inf), color, mitsuba.Bool(False), zero)

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
        self, choice: Choice, line: Line, hit: Hit, through: Any, rng: Any, active: Any
    ) -> tuple[Choice, Any]:
        """Offer what each light causes at `hit`."""
        mitsuba, drjit, layer = self._mitsuba, self._drjit, hit.layer
        active = active & (hit.outside | ~layer.refracts)
        for beam in self._beams:
            toward, distance, arriving = beam.toward(hit.si.p)
            value = through * self._scattering(line, hit, toward) * arriving
            leaving = self._leaving(hit, toward)
            offered = Choice(leaving, distance, value, mitsuba.Bool(False), drjit.mean(value))
            choice, rng = self._weigh(choice, offered, rng, active)
        if not self._around.lights or "albedo" not in self._surfaces.has:
            return choice, rng
        frame = mitsuba.Frame3f(hit.n)

        def density(d: Any) -> Any:
            return drjit.select(
                layer.isotropic,
                1 / (4 * drjit.pi),
                drjit.maximum(drjit.dot(hit.n, d), 0) / drjit.pi,
            )

        two = mitsuba.Point2f(rng.next_float32(active), rng.next_float32(active))
        own = drjit.select(
            layer.isotropic,
            mitsuba.warp.square_to_uniform_sphere(two),
            frame.to_world(mitsuba.warp.square_to_cosine_hemisphere(two)),
        )
        d, chance = self._around.choose(hit.si, own, density, rng.next_float32(active), two)
        factor = through * layer.coverage * layer.albedo * (density(d) / chance)
        offered = self._toward_surroundings(self._leaving(hit, d), factor)
        return self._weigh(choice, offered, rng, active)

    def offer_in_fog(
        self, choice: Choice, p: Any, forward: Any, through: Any, rng: Any, active: Any
    ) -> tuple[Choice, Any]:
        """Offer what each light causes at a collision at `p` of a path that goes `forward`."""
        mitsuba, drjit, fog = self._mitsuba, self._drjit, self._fog
        assert fog is not None
        nowhere = mitsuba.UInt32(0xFFFFFFFF)
        for beam in self._beams:
            toward, distance, arriving = beam.toward(p)
            value = through * fog.phase(drjit.dot(toward, forward)) * arriving
            leaving = Line(p, toward, mitsuba.Float(0), nowhere)
            offered = Choice(leaving, distance, value, mitsuba.Bool(False), drjit.mean(value))
            choice, rng = self._weigh(choice, offered, rng, active)
        return choice, rng

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

    def _toward_surroundings(self, line: Line, factor: Any) -> Choice:
        mitsuba, drjit = self._mitsuba, self._drjit
        floor = mitsuba.Color3f(*[LEAST_SHARE * part for part in self._around.mean])
        weight = drjit.mean(factor * (self._around.radiance(line.d) + floor))
        infinite = mitsuba.Float(drjit.inf)
        return Choice(line, infinite, mitsuba.Color3f(factor), mitsuba.Bool(True), weight)

    def _weigh(self, choice: Choice, offered: Choice, rng: Any, active: Any) -> tuple[Choice, Any]:
        """Replace `choice` with a probability of the new one's weight in the sum of all."""
        drjit, mitsuba = self._drjit, self._mitsuba
        active = active & (offered.total > 0)
        total = choice.total + drjit.select(active, offered.total, 0)
        taken = active & (rng.next_float32(active) * total < offered.total)
        value = offered.value / offered.total
        old, new = choice.line, offered.line
        line = Line(
            drjit.select(taken, new.o, old.o),
            drjit.select(taken, new.d, old.d),
            drjit.select(taken, new.along, old.along),
            drjit.select(taken, new.known, old.known),
        )
        chosen = Choice(
            line,
            drjit.select(taken, offered.limit, choice.limit),
            drjit.select(taken, mitsuba.Color3f(value), choice.value),
            drjit.select(taken, offered.around, choice.around),
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

    def chosen_light(self, choice: Choice, rng: Any, bend: Callable[..., Any]) -> Any:
        """Return the light of the place and light that were chosen, in all that is in the way."""
        mitsuba, drjit, fog = self._mitsuba, self._drjit, self._fog
        around = choice.around
        active = choice.total > 0
        through, zero = mitsuba.Color3f(1), mitsuba.Float(0)
        if fog is not None:
            line = choice.line
            part, rng = fog.transmittance(
                line.o, line.d, line.along, choice.limit, rng, active & ~around
            )
            through = through * drjit.select(around, 1, part)
        bends = "refracts" in self._surfaces.has and self._around.lights

        def step(
            line: Line, through: Any, since: Any, turns: Any, rng: Any, active: Any
        ) -> tuple[Any, ...]:
            hit = self._surfaces.meet(line, active, choice.limit)
            here = active
            if fog is not None:
                at, rng = fog.free_path(line.o, line.d, line.along, hit.at, rng, active & around)
                collides = active & around & (at < drjit.inf)
                here = active & ~collides
            valid, fresh = here & hit.valid, here & hit.fresh
            before = line
            solid = fresh & hit.layer.refracts & around
            through = drjit.select(fresh & ~solid, through * self._tint(hit), through)
            line = self._surfaces.onward(line, hit, valid & ~solid)
            since = since + drjit.select(valid & ~solid, hit.at - before.along, 0)
            if bends:
                line, factor, since, rng = bend(line, hit, since, rng, solid)
                through = drjit.select(solid, through * factor, through)
                turns = turns + drjit.select(solid, mitsuba.UInt32(1), 0)
            active = valid
            if fog is not None:
                two = mitsuba.Point2f(rng.next_float32(collides), rng.next_float32(collides))
                p = before.o + before.d * drjit.select(collides, at, 0)
                line = Line(
                    drjit.select(collides, p, line.o),
                    drjit.select(collides, fog.scattered(before.d, two), line.d),
                    drjit.select(collides, 0, line.along),
                    drjit.select(collides, mitsuba.UInt32(0xFFFFFFFF), line.known),
                )
                through = drjit.select(collides, through * fog.albedo, through)
                turns = turns + drjit.select(collides, mitsuba.UInt32(1), 0)
                active = valid | collides
            active = active & drjit.any(through > 0) & (turns < MOST_TURNS)
            return line, through, since, turns, rng, active

        state = (choice.line, through, zero, mitsuba.UInt32(0), rng, active)
        line, through, _, turns, _, _ = drjit.while_loop(state, lambda *v: v[5], step)
        arrives = drjit.select(turns < MOST_TURNS, through * choice.value * choice.total, 0)
        found = drjit.select(around, self._around.radiance(line.d), mitsuba.Color3f(1))
        return drjit.select(choice.total > 0, arrives * found, 0)

"""The walk along a straight line of sight, through all layers in order."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from oitbench.effects import Effect
from oitbench.path_traced.matched.environment import OpenEnvironment
from oitbench.path_traced.matched.medium import SingleScattering
from oitbench.path_traced.matched.shading import Shading
from oitbench.path_traced.matched.visibility import FAINT
from oitbench.path_traced.trace.hits import Hit, Line
from oitbench.path_traced.trace.sequence import Choices, Turn
from oitbench.path_traced.trace.surfaces import Surfaces

SHADOW_RAYS = 64
"""Most shadow rays to a beam that the layers of a pixel get in the mean, in a sample of each of its
sub-pixels, if the picture is random."""


@dataclass
class Sight:
    """The state of a line of sight.

    Parameters
    ----------
    line : Line
    light : Color3f
        Radiance found so far.
    throughput : Color3f
        Part of the light from ahead that reaches the eye.
    rng : PCG32 or None
        None if no effect needs random numbers.
    choices : Choices or None
        Evenly spread random numbers for the first choices.
    teeth : Float
        Shadow rays that the layers so far have deserved, plus a random number in [0, 1).
    most : Float
        Shadow rays that this line of sight gets in the mean, at most.
    """

    line: Line
    light: Any
    throughput: Any
    rng: Any
    choices: Choices | None
    teeth: Any
    most: Any


class StraightWalk:
    """An integrator (see `trace.integrators.Integrator`) that composites all layers exactly.

    It computes C = Σᵢ αᵢ Lᵢ Πⱼ τⱼ + C₀ Πₖ τₖ, where j runs over the layers nearer than i, and draws
    no random numbers but to shift the steps of a march and the rays of occlusion.

    Parameters
    ----------
    mitsuba, drjit : module
    surfaces : Surfaces
    shading : Shading
    environment : OpenEnvironment
    effects : Effect
        Without COLORED_TRANSMISSION, layers transmit the mean of the channels.
    medium : SingleScattering or None
        None unless it runs.
    random : bool
        Whether any effect needs random numbers.
    """

    def __init__(
        self,
        mitsuba: Any,
        drjit: Any,
        surfaces: Surfaces,
        shading: Shading,
        environment: OpenEnvironment,
        effects: Effect,
        medium: SingleScattering | None,
        random: bool,
    ) -> None:
        self._mitsuba, self._drjit = mitsuba, drjit
        self._surfaces, self._shading, self._environment = surfaces, shading, environment
        self._effects, self._medium, self._random = effects, medium, random

    def __call__(self, content: Any, ray: Any, turn: Turn) -> Any:
        """Return the radiance along `ray`."""
        state = (self._start(ray, turn), self._mitsuba.Bool(True))
        return self._drjit.while_loop(state, lambda *v: v[1], self._advance)[0].light

    def _start(self, ray: Any, turn: Turn) -> Sight:
        mitsuba, rng, choices = self._mitsuba, None, None
        if self._random:
            count, state = ray.o.shape[1], self._drjit.opaque(mitsuba.UInt64, turn.seed)
            rng = mitsuba.PCG32(size=count, initstate=state)
            choices = turn.choices(mitsuba, self._drjit, count)
        line = self._surfaces.eye_line(ray.o, ray.d)
        teeth = mitsuba.Float(0) if choices is None else choices.side
        most = self._drjit.opaque(mitsuba.Float, max(1, SHADOW_RAYS / turn.ssaa**2))
        return Sight(line, mitsuba.Color3f(0), mitsuba.Color3f(1), rng, choices, teeth, most)

    def _advance(self, sight: Sight, active: Any) -> tuple[Sight, Any]:
        """Go on behind the next layer."""
        drjit = self._drjit
        hit = self._surfaces.intersect(sight.line, active)
        self._look(sight, hit, hit.fresh, active)
        tau = self._perceived(hit.layer.transmittance)
        sight.throughput = drjit.select(hit.fresh, sight.throughput * tau, sight.throughput)
        sight.line = sight.line.onward(drjit, hit, hit.valid)
        return sight, hit.valid & drjit.any(sight.throughput > FAINT)

    def _look(self, sight: Sight, hit: Hit, shaded: Any, active: Any) -> None:
        """Add the light before `hit`, of its surface where `shaded`, or of the background."""
        drjit = self._drjit
        if self._medium is not None:
            assert sight.choices is not None
            start = sight.choices.place
            shading = self._shading
            found, passed = self._medium.march(
                sight.line, hit.at, shading.beams, shading.visibility.along, start, active
            )
            sight.light = sight.light + sight.throughput * found
            sight.throughput = sight.throughput * passed
        around = self._environment.radiance(sight.line.d)
        share = self._share(sight, hit, shaded)
        found = drjit.select(shaded, self._shading.light(hit, sight.rng, shaded, share), 0)
        found = drjit.select(active & ~hit.valid, around, found)
        sight.light = sight.light + sight.throughput * found

    def _share(self, sight: Sight, hit: Hit, shaded: Any) -> Any:
        """Return the factor on the light of beams at `hit`; where it is 0, they need no shadow ray.

        Where a picture is random anyway, a layer that contributes less than 1/`most` gets its
        shadow ray by systematic sampling: whenever the sum of contributions passes the next
        tooth of a comb.
        """
        drjit = self._drjit
        if not self._random:
            return self._mitsuba.Float(1)
        part = sight.most * drjit.max(sight.throughput) * hit.layer.coverage
        part = drjit.select(shaded, drjit.minimum(part, 1), 0)
        chosen = drjit.floor(sight.teeth + part) > drjit.floor(sight.teeth)
        sight.teeth = sight.teeth + drjit.select(part < 1, part, 0)
        return drjit.select(part >= 1, 1, drjit.select(chosen, 1 / part, 0))

    def _perceived(self, transmittance: Any) -> Any:
        """Return a transmittance as the effects that run express it."""
        if Effect.COLORED_TRANSMISSION in self._effects:
            return transmittance
        return self._mitsuba.Color3f(self._drjit.mean(transmittance))

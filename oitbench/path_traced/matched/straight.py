"""The walk along a straight line of sight, through all layers in order."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from oitbench.effects import Effect
from oitbench.path_traced.matched.shading import Shading
from oitbench.path_traced.trace.hits import NO_FACE, Hit, Line
from oitbench.path_traced.trace.lights import TracedEnvironment
from oitbench.path_traced.trace.surfaces import Surfaces


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
    """

    line: Line
    light: Any
    throughput: Any


class StraightWalk:
    """An integrator (see `trace.integrators.Integrator`) that composites all layers exactly.

    It computes C = Σᵢ αᵢ Lᵢ Πⱼ τⱼ + C₀ Πₖ τₖ, where j runs over the layers nearer than i, and draws
    no random numbers.

    Parameters
    ----------
    mitsuba, drjit : module
    surfaces : Surfaces
    shading : Shading
    environment : TracedEnvironment
    effects : Effect
        Without COLORED_TRANSMISSION, layers transmit the mean of the channels.
    """

    def __init__(
        self,
        mitsuba: Any,
        drjit: Any,
        surfaces: Surfaces,
        shading: Shading,
        environment: TracedEnvironment,
        effects: Effect,
    ) -> None:
        self._mitsuba, self._drjit = mitsuba, drjit
        self._surfaces, self._shading, self._environment = surfaces, shading, environment
        self._effects = effects

    def __call__(self, content: Any, ray: Any, seed: int) -> Any:
        """Return the radiance along `ray`."""
        state = (self._start(ray), self._mitsuba.Bool(True))
        return self._drjit.while_loop(state, lambda *v: v[1], self._advance)[0].light

    def _start(self, ray: Any) -> Sight:
        mitsuba = self._mitsuba
        o, d = mitsuba.Point3f(ray.o), mitsuba.Vector3f(ray.d)
        line = Line(o, d, mitsuba.Float(0), mitsuba.UInt32(NO_FACE))
        return Sight(line, mitsuba.Color3f(0), mitsuba.Color3f(1))

    def _advance(self, sight: Sight, active: Any) -> tuple[Sight, Any]:
        """Go on behind the next layer."""
        drjit = self._drjit
        hit = self._surfaces.intersect(sight.line, active)
        self._look(sight, hit, hit.fresh, active)
        tau = self._perceived(hit.layer.transmittance)
        sight.throughput = drjit.select(hit.fresh, sight.throughput * tau, sight.throughput)
        sight.line = sight.line.onward(drjit, hit, hit.valid)
        return sight, hit.valid & drjit.any(sight.throughput > 0)

    def _look(self, sight: Sight, hit: Hit, shaded: Any, active: Any) -> None:
        """Add the light of the surface at `hit` where `shaded`, or of the background."""
        drjit = self._drjit
        around = self._environment.radiance(sight.line.d)
        found = drjit.select(shaded, self._shading.light(hit, shaded), 0)
        found = drjit.select(active & ~hit.valid, around, found)
        sight.light = sight.light + sight.throughput * found

    def _perceived(self, transmittance: Any) -> Any:
        """Return a transmittance as the effects that run express it."""
        if Effect.COLORED_TRANSMISSION in self._effects:
            return transmittance
        return self._mitsuba.Color3f(self._drjit.mean(transmittance))

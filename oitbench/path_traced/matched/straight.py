"""The walk along a straight line of sight, through all layers in order."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from oitbench.effects import Effect
from oitbench.path_traced.matched.shading import Shading
from oitbench.path_traced.trace.hits import NO_FACE, Line
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
        self._colored = Effect.COLORED_TRANSMISSION in effects

    def __call__(self, content: Any, ray: Any, seed: int) -> Any:
        """Return the radiance along `ray`."""
        mitsuba, drjit = self._mitsuba, self._drjit
        o, d = mitsuba.Point3f(ray.o), mitsuba.Vector3f(ray.d)
        line = Line(o, d, mitsuba.Float(0), mitsuba.UInt32(NO_FACE))
        sight = Sight(line, mitsuba.Color3f(0), mitsuba.Color3f(1))
        state = (sight, mitsuba.Bool(True))
        return drjit.while_loop(state, lambda *v: v[1], self._advance)[0].light

    def _advance(self, sight: Sight, active: Any) -> tuple[Sight, Any]:
        """Go on behind the next layer."""
        mitsuba, drjit = self._mitsuba, self._drjit
        hit = self._surfaces.intersect(sight.line, active)
        around = self._environment.radiance(sight.line.d)
        found = drjit.select(hit.fresh, self._shading.light(hit, hit.fresh), 0)
        found = drjit.select(active & ~hit.valid, around, found)
        sight.light = sight.light + sight.throughput * found
        tau = hit.layer.transmittance
        if not self._colored:
            tau = mitsuba.Color3f(drjit.mean(tau))
        passed = sight.throughput * tau
        sight.throughput = drjit.select(hit.fresh, passed, sight.throughput)
        sight.line = sight.line.onward(drjit, hit, hit.valid)
        return sight, hit.valid & drjit.any(sight.throughput > 0)

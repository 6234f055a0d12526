"""Reservoir sampling of the points from which a path looks for light.

Of all candidates, each weighted by the light that would arrive without shadows, one is selected in
a single pass (Talbot et al. 2005, "Importance resampling for global illumination").
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from oitbench.path_traced.trace.hits import Line


@dataclass
class Candidate:
    """A point and a direction from which a path could look for light.

    Parameters
    ----------
    line : Line
        From the point toward the light.
    limit : Float
        Distance of the light in meters.
    value : Color3f
        Light that reaches the eye if nothing is in the way; for the environment, without the factor
        of its radiance.
    weight : Float
    """

    line: Line
    limit: Any
    value: Any
    weight: Any


@dataclass
class Reservoir:
    """The selected one of all candidates so far.

    Parameters
    ----------
    line, limit
        Those of the selected candidate.
    value : Color3f
        Value of the candidate, divided by its weight.
    total : Float
        Sum of the weights of all candidates.
    """

    line: Line
    limit: Any
    value: Any
    total: Any

    @classmethod
    def empty(cls, mitsuba: Any, drjit: Any, line: Line) -> Reservoir:
        """Return a reservoir without candidates, with any `line`."""
        return cls(line, mitsuba.Float(drjit.inf), mitsuba.Color3f(0), mitsuba.Float(0))

    def add(
        self, mitsuba: Any, drjit: Any, candidate: Candidate, rng: Any, active: Any
    ) -> tuple[Reservoir, Any]:
        """Select `candidate` with the probability of its part in the sum of all weights.

        Return the new reservoir and the generator of random numbers.
        """
        active = active & (candidate.weight > 0)
        total = self.total + drjit.select(active, candidate.weight, 0)
        taken = active & (rng.next_float32(active) * total < candidate.weight)
        value = mitsuba.Color3f(candidate.value / candidate.weight)
        selected = Reservoir(
            candidate.line.where(drjit, taken, self.line),
            drjit.select(taken, candidate.limit, self.limit),
            drjit.select(taken, value, self.value),
            total,
        )
        return selected, rng


@dataclass
class Reservoirs:
    """Reservoirs for beams on surfaces, for beams in a medium, and for the environment.

    Light that is scattered once, on the straight part of a path, has a reservoir of its own.
    They are None where a scene lacks the light. They are separate because the weights ignore
    shadows: a strong light that is shadowed must not keep lights of the other kinds from being
    selected.
    """

    surface_beam: Reservoir | None
    single_beam: Reservoir | None
    medium_beam: Reservoir | None
    environment: Reservoir | None

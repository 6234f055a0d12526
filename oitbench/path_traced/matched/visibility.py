"""The part of a beam that arrives at a point, along a straight line."""

from __future__ import annotations

from typing import Any

from oitbench.effects import Effect
from oitbench.path_traced.matched.medium import SingleScattering
from oitbench.path_traced.trace.hits import Hit, Line
from oitbench.path_traced.trace.surfaces import Surfaces

FAINT = 2.0**-16
"""Part of the light below which a shadow ray or a line of sight is given up."""
_CASTING = Effect.SHADOWS | Effect.TRANSLUCENT_SHADOWS | Effect.CAUSTICS


class BeamVisibility:
    """Shadow rays through all surfaces, by the effects of shadows that run.

    | effect | without it |
    |---|---|
    | SHADOWS | opaque surfaces block no light |
    | TRANSLUCENT_SHADOWS | transparent surfaces block all light if they block more than half |
    | COLORED_SHADOWS | they block the mean of the channels |
    | CAUSTICS | solids are two sheets; with it they block, as photons bring the light |

    Parameters
    ----------
    mitsuba, drjit : module
    surfaces : Surfaces
    effects : Effect
    medium : SingleScattering or None
        The medium that dims beams on their way, if it runs.
    """

    def __init__(
        self,
        mitsuba: Any,
        drjit: Any,
        surfaces: Surfaces,
        effects: Effect,
        medium: SingleScattering | None,
    ) -> None:
        self._mitsuba, self._drjit = mitsuba, drjit
        self._surfaces, self._effects, self._medium = surfaces, effects, medium
        self._casts = bool(effects & _CASTING)

    def along(self, line: Line, limit: Any, active: Any) -> Any:
        """Return the transmittance of a line up to `limit` meters, Color3f."""
        part = self._mitsuba.Color3f(1)
        if self._casts:
            part = self._through_surfaces(line, limit, active)
        if self._medium is not None:
            lit = active & self._drjit.any(part > 0)
            part = part * self._medium.transmittance(line, limit, lit)
        return part

    def _through_surfaces(self, line: Line, limit: Any, active: Any) -> Any:
        drjit, mitsuba = self._drjit, self._mitsuba

        def step(line: Line, part: Any, active: Any) -> tuple[Any, ...]:
            hit = self._surfaces.intersect(line, active, limit, to_light=True)
            part = drjit.select(hit.fresh, part * self._passing(hit), part)
            line = line.onward(drjit, hit, hit.valid)
            return line, part, hit.valid & drjit.any(part > FAINT)

        state = (line, mitsuba.Color3f(1), active)
        return drjit.while_loop(state, lambda *v: v[2], step)[1]

    def _passing(self, hit: Hit) -> Any:
        """Return the part of each channel that passes the surface at `hit`."""
        drjit, mitsuba, effects, layer = self._drjit, self._mitsuba, self._effects, hit.layer
        blocked = mitsuba.Color3f(1 if Effect.SHADOWS in effects else 0)
        through = layer.transmittance
        if Effect.COLORED_SHADOWS not in effects:
            through = mitsuba.Color3f(drjit.mean(through))
        if Effect.TRANSLUCENT_SHADOWS not in effects:
            through = drjit.select(drjit.mean(through) < 0.5, 1 - blocked, mitsuba.Color3f(1))
        if Effect.CAUSTICS in effects:
            through = drjit.select(layer.refracts, mitsuba.Color3f(0), through)
        return drjit.select(layer.opaque, 1 - blocked, through)

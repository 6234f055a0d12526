"""Ambient occlusion: the part of the environment's light that surfaces nearby let through."""

from __future__ import annotations

from typing import Any

import numpy as np

from oitbench.path_traced.trace.hits import Hit, Line
from oitbench.path_traced.trace.lights import TracedEnvironment
from oitbench.path_traced.trace.surfaces import Surfaces

RAYS = 16
"""Rays from each point."""
_PLASTIC = 0.7548776662466927, 0.5698402909980532
"""Steps of the R₂ sequence, which covers the unit square evenly (Roberts 2018)."""


class Openness:
    """Rays of occlusion, which end at the scene's radius; all surfaces tint them.

    Parameters
    ----------
    mitsuba, drjit : module
    surfaces : Surfaces
    environment : TracedEnvironment
    radius : float
        Meters.
    """

    def __init__(
        self,
        mitsuba: Any,
        drjit: Any,
        surfaces: Surfaces,
        environment: TracedEnvironment,
        radius: float,
    ) -> None:
        self._mitsuba, self._drjit = mitsuba, drjit
        self._surfaces, self._environment = surfaces, environment
        self._radius = drjit.opaque(mitsuba.Float, radius)
        index = np.arange(RAYS)
        self._points = [mitsuba.Float((index * step % 1).astype(np.float32)) for step in _PLASTIC]

    def at(self, hit: Hit, rng: Any, active: Any) -> Any:
        """Return the part of diffuse light of the environment that arrives at `hit`, Color3f.

        It is ∫ V L p dl / ∫ L p dl, where V is what passes within the radius and p is the cosine,
        or one for particles. `rng` shifts the directions.
        """
        mitsuba, drjit, layer = self._mitsuba, self._drjit, hit.layer
        frame = mitsuba.Frame3f(hit.n)
        shift = rng.next_float32(active), rng.next_float32(active)

        def step(index: Any, seen: Any, total: Any, active: Any) -> tuple[Any, ...]:
            parts = []
            for points, offset in zip(self._points, shift, strict=True):
                place = drjit.gather(mitsuba.Float, points, index, active) + offset
                parts.append(place - drjit.floor(place))
            two = mitsuba.Point2f(*parts)
            d = drjit.select(
                layer.isotropic,
                mitsuba.warp.square_to_uniform_sphere(two),
                frame.to_world(mitsuba.warp.square_to_cosine_hemisphere(two)),
            )
            radiance = self._environment.radiance(d)
            part = self._passing(hit.leaving(mitsuba, drjit, d), active)
            seen = seen + drjit.select(active, part * radiance, 0)
            total = total + drjit.select(active, radiance, 0)
            return index + 1, seen, total, active & (index + 1 < RAYS)

        state = mitsuba.UInt32(0), mitsuba.Color3f(0), mitsuba.Color3f(0), active
        _, seen, total, _ = drjit.while_loop(state, lambda *v: v[3], step)
        return drjit.select(total > 0, seen / drjit.maximum(total, 1e-30), 1)

    def _passing(self, line: Line, active: Any) -> Any:
        drjit = self._drjit

        def step(line: Line, part: Any, active: Any) -> tuple[Any, ...]:
            hit = self._surfaces.intersect(line, active, self._radius, to_light=True)
            part = drjit.select(hit.fresh, part * hit.layer.transmittance, part)
            line = line.onward(drjit, hit, hit.valid)
            return line, part, hit.valid & drjit.any(part > 0)

        state = (line, self._mitsuba.Color3f(1), active)
        return drjit.while_loop(state, lambda *v: v[2], step)[1]

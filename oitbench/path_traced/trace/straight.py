"""The integrator for scenes that only tint light, in which all rays are straight.

Mitsuba's `volpath` could trace such scenes, too. It starts each segment at a point that it has
moved off the surface along the normal, by about 1e-4 of its distance from the origin. Layers that
are closer to each other are lost (2 of 100 in a cloud of crossing cards), and at grazing angles
each layer shifts the ray sideways.

This integrator never leaves the line. It advances beyond a hit by a few rounding errors, looks back
over them for a film that it may have skipped, and ignores the triangles that it has already hit. It
misses films that are closer to each other than about 2e-7 of their distance, and all but two of the
films within one step.
"""

from __future__ import annotations

import importlib
from types import ModuleType
from typing import Any

from oitbench.path_traced.optics.advance import STEP

_EDGE = 1e-5
"""Barycentric coordinates below this may be rounding errors of zero."""


class Straight:
    """An integrator (see `integrators.Integrator`) for films; it draws no random numbers.

    Parameters
    ----------
    mitsuba : module
        With any variant set; this integrator alone also runs in a scalar one.
    """

    def __init__(self, mitsuba: ModuleType) -> None:
        self._mitsuba = mitsuba
        self._drjit: Any = importlib.import_module("drjit")
        self._scalar = mitsuba.variant().startswith("scalar")

    def __call__(self, content: Any, ray: Any, seed: int) -> Any:
        """Return the radiance along `ray`."""
        mitsuba, drjit, scalar = self._mitsuba, self._drjit, self._scalar

        def advance(
            active: Any, light: Any, throughput: Any, distance: Any, known: tuple[Any, ...]
        ) -> tuple[Any, ...]:
            """Cross the next film and, if another one is closer to it than a step, that one."""
            start = mitsuba.Ray3f(ray.o + ray.d * distance, ray.d)
            ahead = content.ray_intersect_preliminary(start, False, active)
            active = active & ahead.is_valid()
            if scalar and not active:
                return active, light, throughput, distance, known
            si = ahead.compute_surface_interaction(start, active=active)
            # A line crosses a triangle once. A second hit is a rounding error of the first one.
            fresh = active & _none_of(ahead, known)
            light, throughput = self._cross(si, fresh, light, throughput)
            step = STEP * (distance + si.t + drjit.max(drjit.abs(si.p)))
            distance = drjit.select(active, distance + si.t + step, distance)
            back = mitsuba.Ray3f(ray.o + ray.d * distance, -ray.d)
            back.maxt = 2 * step
            twin = content.ray_intersect_preliminary(back, False, active)
            # Two triangles of one surface are both hit on the edge that they share.
            inside = (_on_edge(drjit, ahead) & _on_edge(drjit, twin)) ^ True
            fresh = active & twin.is_valid() & inside & _none_of(twin, (*known, *_identity(ahead)))
            behind = twin.compute_surface_interaction(back, active=fresh)
            behind.wi = -behind.wi  # It, too, is seen along the line.
            light, throughput = self._cross(behind, fresh, light, throughput)
            active = active & drjit.any(throughput > 0)
            return active, light, throughput, distance, (*_identity(ahead), *_identity(twin))

        nothing = (None if scalar else drjit.zeros(mitsuba.ShapePtr), mitsuba.UInt32(0))
        color = mitsuba.Color3f
        state: Any = (mitsuba.Bool(True), color(0), color(1), mitsuba.Float(0), nothing + nothing)
        if scalar:
            while state[0]:
                state = advance(*state)
        else:
            state = drjit.while_loop(state, lambda *v: v[0], advance)
        _, light, throughput, _, _ = state
        return light + throughput * self._background(content, ray)

    def _cross(self, si: Any, fresh: Any, light: Any, throughput: Any) -> tuple[Any, Any]:
        """Return light and throughput behind the film at `si`, where the hit is `fresh`."""
        drjit = self._drjit
        if self._scalar and not fresh:
            return light, throughput
        emitter = si.shape.emitter()
        if emitter is not None:
            light = light + drjit.select(fresh, throughput * emitter.eval(si, fresh), 0)
        transmittance = si.bsdf().eval_null_transmission(si, fresh)
        return light, drjit.select(fresh, throughput * transmittance, throughput)

    def _background(self, content: Any, ray: Any) -> Any:
        environment = content.environment()
        if environment is None:
            return self._mitsuba.Color3f(0)
        si = self._drjit.zeros(self._mitsuba.SurfaceInteraction3f)
        si.wi = -ray.d
        return environment.eval(si, True)


def _identity(hit: Any) -> tuple[Any, Any]:
    return hit.shape, hit.prim_index


def _none_of(hit: Any, known: tuple[Any, ...]) -> Any:
    """Return whether the triangle that was hit is not in `known`: (shape, index, shape, …)."""
    # Not `~`, which would turn the Python bool of a scalar variant into an int.
    other = ((hit.shape == known[0]) & (hit.prim_index == known[1])) ^ True
    return other & _none_of(hit, known[2:]) if len(known) > 2 else other


def _on_edge(drjit: Any, hit: Any) -> Any:
    u, v = hit.prim_uv.x, hit.prim_uv.y
    return drjit.minimum(drjit.minimum(u, v), 1 - u - v) < _EDGE

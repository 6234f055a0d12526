"""Two ways to follow a ray through films: exactly straight, and Mitsuba's `volpath`.

`volpath` starts each segment at a point that it has moved off the surface along the normal, by
about 1e-4 of its distance from the origin. Layers that lie nearer than that are lost (2 of 100 in a
cloud of crossing cards), and at grazing angles the ray drifts sideways with every layer. While all
that a scene does to light is to tint it, the straight integrator stays on the one line: it advances
by a few rounding errors, looks back over them for a film that it skipped, and recognizes the
triangles that it has met already. What is left unmet are films nearer than about 2e-7 of their
distance, and all but two of those within one step.
"""

from __future__ import annotations

import importlib
from collections.abc import Callable
from types import ModuleType
from typing import Any

import numpy as np
import numpy.typing as npt

from oitbench.image.files import Image
from oitbench.path_traced.trace.surfaces import STEP

Integrator = Callable[[Any, Any, int], Any]
"""Maps a Mitsuba scene, rays and a seed to radiance."""

_EDGE = 1e-5
"""Barycentric coordinates below this may be rounding errors of zero."""


def make_straight(mitsuba: ModuleType) -> Integrator:
    """Return an integrator for scenes whose surfaces are all films; it draws no random number."""
    drjit: Any = importlib.import_module("drjit")
    scalar = mitsuba.variant().startswith("scalar")

    def cross(si: Any, fresh: Any, light: Any, through: Any) -> tuple[Any, Any]:
        """Return light and transmittance behind the film at `si`, where it is a fresh one."""
        if scalar and not fresh:
            return light, through
        emitter = si.shape.emitter()
        if emitter is not None:
            light = light + drjit.select(fresh, through * emitter.eval(si, fresh), 0)
        transmittance = si.bsdf().eval_null_transmission(si, fresh)
        return light, drjit.select(fresh, through * transmittance, through)

    def integrate(scene: Any, ray: Any, seed: int) -> Any:
        def meet(active: Any, light: Any, through: Any, distance: Any, known: Any) -> Any:
            """Cross the next film and, if another one is closer to it than a step, that one."""
            start = mitsuba.Ray3f(ray.o + ray.d * distance, ray.d)
            ahead = scene.ray_intersect_preliminary(start, False, active)
            active = active & ahead.is_valid()
            if scalar and not active:
                return active, light, through, distance, known
            si = ahead.compute_surface_interaction(start, active=active)
            # A line crosses a triangle once; a second hit is the first one's rounding error.
            fresh = active & _none_of(ahead, known)
            light, through = cross(si, fresh, light, through)
            step = STEP * (distance + si.t + drjit.max(drjit.abs(si.p)))
            distance = drjit.select(active, distance + si.t + step, distance)
            back = mitsuba.Ray3f(ray.o + ray.d * distance, -ray.d)
            back.maxt = 2 * step
            twin = scene.ray_intersect_preliminary(back, False, active)
            # Two triangles of one surface are both hit on the edge that they share.
            inside = (_on_edge(drjit, ahead) & _on_edge(drjit, twin)) ^ True
            fresh = active & twin.is_valid() & inside & _none_of(twin, (*known, *_identity(ahead)))
            behind = twin.compute_surface_interaction(back, active=fresh)
            light, through = cross(behind, fresh, light, through)
            active = active & drjit.any(through > 0)
            return active, light, through, distance, (*_identity(ahead), *_identity(twin))

        nothing = (None if scalar else drjit.zeros(mitsuba.ShapePtr), mitsuba.UInt32(0))
        color = mitsuba.Color3f
        state = (mitsuba.Bool(True), color(0), color(1), mitsuba.Float(0), nothing + nothing)
        if scalar:
            while state[0]:
                state = meet(*state)
        else:
            state = drjit.while_loop(state, lambda *variables: variables[0], meet)
        _, light, through, _, _ = state
        return light + through * _background(mitsuba, drjit, scene, ray)

    return integrate


def _identity(hit: Any) -> tuple[Any, Any]:
    return hit.shape, hit.prim_index


def _none_of(hit: Any, known: tuple[Any, ...]) -> Any:
    """Tell whether the triangle hit is not in `known`, which is (shape, index, shape, …)."""
    # Not `~`, which would make a Python bool of the scalar variant an int.
    other = ((hit.shape == known[0]) & (hit.prim_index == known[1])) ^ True
    return other & _none_of(hit, known[2:]) if len(known) > 2 else other


def _on_edge(drjit: Any, hit: Any) -> Any:
    u, v = hit.prim_uv.x, hit.prim_uv.y
    return drjit.minimum(drjit.minimum(u, v), 1 - u - v) < _EDGE


def _background(mitsuba: ModuleType, drjit: Any, scene: Any, ray: Any) -> Any:
    environment = scene.environment()
    if environment is None:
        return mitsuba.Color3f(0)
    si = drjit.zeros(mitsuba.SurfaceInteraction3f)
    si.wi = -ray.d
    return environment.eval(si, True)


def make_volpath(mitsuba: ModuleType) -> Integrator:
    """Return Mitsuba's own volumetric path tracer, of unlimited depth."""
    # Films count as no bounce, so neither the depth nor Russian roulette limits their number.
    volpath = mitsuba.load_dict({"type": "volpath", "max_depth": -1, "rr_depth": 1 << 20})
    sampler = mitsuba.load_dict({"type": "independent"})

    def integrate(scene: Any, ray: Any, seed: int) -> Any:
        if mitsuba.variant().startswith("scalar"):
            sampler.seed(seed)
        else:
            sampler.seed(seed, ray.o.shape[1])
        return volpath.sample(scene, sampler, mitsuba.RayDifferential3f(ray))[0]

    return integrate


def trace(
    mitsuba: ModuleType,
    integrator: Integrator,
    scene: Any,
    rays: tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]],
    seed: int,
) -> Image:
    """Return the radiance along `rays`.

    Parameters
    ----------
    mitsuba : module
        With a variant set.
    integrator : Integrator
    scene : mitsuba.Scene
    rays : pair of array, shape (n, 3)
        Origins in metres and unit directions.
    seed : int

    Returns
    -------
    array, shape (n, 3), float32
        Linear Rec.709.
    """
    origins, directions = rays
    if mitsuba.variant().startswith("scalar"):
        radiance = [
            list(integrator(scene, mitsuba.Ray3f(origin, direction), seed + number))
            for number, (origin, direction) in enumerate(
                zip(origins.tolist(), directions.tolist(), strict=True)
            )
        ]
        return np.asarray(radiance, dtype=np.float32)
    ray = mitsuba.Ray3f(
        mitsuba.Point3f(*origins.T.astype(np.float32)),
        mitsuba.Vector3f(*directions.T.astype(np.float32)),
    )
    return np.array(integrator(scene, ray, seed), dtype=np.float32).T

"""Two ways to follow a ray through films: exactly straight, and Mitsuba's `volpath`.

`volpath` starts each segment at a point that it has moved off the surface along the normal, by
about 1e-4 of its distance from the origin. Layers that lie nearer than that are lost (2 of 100 in a
cloud of crossing cards), and at grazing angles the ray drifts sideways with every layer. While all
that a scene does to light is to tint it, the straight integrator stays on the one line: it advances
by some rounding errors and recognizes the triangle that it has just left.
"""

from __future__ import annotations

import importlib
from collections.abc import Callable
from types import ModuleType
from typing import Any

import numpy as np
import numpy.typing as npt

from oitbench.images import Image

Integrator = Callable[[Any, Any, int], Any]
"""Maps a Mitsuba scene, rays and a seed to radiance."""

_STEP = 6e-7
"""Advance beyond a hit, relative to the magnitudes added up there: five float32 roundings."""


def make_straight(mitsuba: ModuleType) -> Integrator:
    """Return an integrator for scenes whose surfaces are all films; it draws no random number."""
    drjit: Any = importlib.import_module("drjit")
    scalar = mitsuba.variant().startswith("scalar")

    def integrate(scene: Any, ray: Any, seed: int) -> Any:
        def meet(active: Any, light: Any, through: Any, distance: Any, last: Any) -> Any:
            start = ray.o + ray.d * distance
            si = scene.ray_intersect(mitsuba.Ray3f(start, ray.d), active)
            # A line crosses a triangle once; a second hit is the first one's rounding error.
            fresh = active & ~((si.shape == last[0]) & (si.prim_index == last[1]))
            if scalar:
                fresh = bool(fresh)
            emitter = si.emitter(scene)
            if emitter is not None:
                light = light + drjit.select(fresh, through * emitter.eval(si, fresh), 0)
            active = active & si.is_valid()
            if scalar and not active:
                return active, light, through, distance, last
            film = si.bsdf()
            fresh = fresh & active
            through = drjit.select(fresh, through * film.eval_null_transmission(si, fresh), through)
            magnitude = distance + si.t + drjit.max(drjit.abs(si.p))
            distance = drjit.select(active, distance + si.t + _STEP * magnitude, distance)
            active = active & drjit.any(through > 0)
            return active, light, through, distance, (si.shape, si.prim_index)

        none = None if scalar else drjit.zeros(mitsuba.ShapePtr)
        state = (
            mitsuba.Bool(True),
            mitsuba.Color3f(0),
            mitsuba.Color3f(1),
            mitsuba.Float(0),
            (none, mitsuba.UInt32(0)),
        )
        if scalar:
            while state[0]:
                state = meet(*state)
            return state[1]
        return drjit.while_loop(state, lambda *variables: variables[0], meet)[1]

    return integrate


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

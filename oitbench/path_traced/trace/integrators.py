"""Which integrator traces a scene, and how rays are handed to it.

A new integrator is a callable in a module of its own, like `straight` and `path_tracer`, and gets
its case in `prepare`.
"""

from __future__ import annotations

import importlib
from collections.abc import Callable
from types import ModuleType
from typing import Any

import numpy as np
import numpy.typing as npt

from oitbench.effects import Effect
from oitbench.errors import CapabilityError, SceneError
from oitbench.image.files import Image
from oitbench.path_traced import llvm
from oitbench.path_traced.export.scene import export
from oitbench.path_traced.export.view import View
from oitbench.path_traced.photons.map import CausticMap
from oitbench.path_traced.trace.path_tracer import PathTracer, is_random
from oitbench.path_traced.trace.sequence import Turn, seed_of
from oitbench.path_traced.trace.straight import Straight
from oitbench.path_traced.trace.surfaces import Surfaces
from oitbench.scene import Scene

Integrator = Callable[[Any, Any, Any], Any]
"""Maps a `mitsuba.Scene`, a `Ray3f` and the random numbers' seed or `Turn` to the
radiance along the rays, Color3f."""

_PHOTONS = 4
"""Photons of a caustic map for each sub-pixel. Cells of the map are then about as large as a
pixel."""
_FEWEST_PHOTONS = 1 << 14


def is_straight(scene: Scene) -> bool:
    """Return whether `scene` does nothing to light but tint it."""
    return not scene.lights and not is_random(scene)


def prepare(
    scene: Scene, view: View, mitsuba: ModuleType, seed: int
) -> tuple[Any, Callable[[int], Integrator]]:
    """Export a scene and choose its integrator.

    Parameters
    ----------
    scene : Scene
    view : View
    mitsuba : module
        With a variant set.
    seed : int

    Returns
    -------
    content : mitsuba.Scene
    make : callable
        Maps the number of a sample to the integrator for it and for the following ones, with a
        caustic map of its own.

    Raises
    ------
    CapabilityError
        If the scene cannot be path traced, or not in this variant.
    """
    if is_straight(scene):
        straight = Straight(mitsuba)
        return export(scene, view, mitsuba).content, lambda sample: straight
    require_wide(scene, mitsuba)
    drjit = importlib.import_module("drjit")
    exported = export(scene, view, mitsuba)
    surfaces = Surfaces.build(mitsuba, drjit, view, exported)
    photons = max(_FEWEST_PHOTONS, _PHOTONS * view.width * view.height)

    def make(sample: int) -> Integrator:
        caustics = None
        if Effect.CAUSTICS in scene.effects:
            caustics = CausticMap.build(
                mitsuba, drjit, exported.content, exported.scene, photons, seed_of(seed, sample)
            )
        return PathTracer(mitsuba, scene, surfaces, caustics)

    return exported.content, make


def require_wide(scene: Scene, mitsuba: ModuleType) -> None:
    """Raise `CapabilityError` if the variant of Mitsuba traces one ray at a time."""
    if mitsuba.variant().startswith("scalar"):
        raise CapabilityError(
            f"scene {scene.name}: lights, reflection and scattering can be path traced with LLVM "
            f"only; {llvm.INSTALL}"
        )


def require_finite_rays(scene: Scene, image: Image) -> None:
    """Raise `SceneError` if the radiance of a ray is not finite; `image` has shape (h, w, 3)."""
    broken = int((~np.isfinite(image)).any(axis=-1).sum())
    if broken:
        raise SceneError(
            f"scene {scene.name}: the radiance of {broken} path-traced rays is not finite; "
            "check its materials and lights for extreme values"
        )


def trace(
    mitsuba: ModuleType,
    integrator: Integrator,
    content: Any,
    rays: tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]],
    seed: int | Turn,
) -> Image:
    """Return the radiance along rays.

    Parameters
    ----------
    mitsuba : module
        With a variant set.
    integrator : Integrator
    content : mitsuba.Scene
    rays : pair of array, shape (n, 3)
        Origins in meters, and unit directions.
    seed : int or Turn
        As the integrator takes it.

    Returns
    -------
    array, shape (n, 3), float32
        Linear Rec.709.
    """
    origins, directions = rays
    if mitsuba.variant().startswith("scalar"):
        radiance = [
            list(integrator(content, mitsuba.Ray3f(origin, direction), seed))
            for origin, direction in zip(origins.tolist(), directions.tolist(), strict=True)
        ]
        return np.asarray(radiance, dtype=np.float32)
    ray = mitsuba.Ray3f(
        mitsuba.Point3f(*origins.T.astype(np.float32)),
        mitsuba.Vector3f(*directions.T.astype(np.float32)),
    )
    return np.array(integrator(content, ray, seed), dtype=np.float32).T

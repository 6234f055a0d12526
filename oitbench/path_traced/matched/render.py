"""Rendering of a matched reference."""

from __future__ import annotations

import importlib
from types import ModuleType
from typing import Any

import numpy as np

from oitbench.effects import Effect
from oitbench.errors import UsageError
from oitbench.image.files import Image, box_downsample
from oitbench.path_traced import llvm
from oitbench.path_traced.export.scene import ExportedScene, export
from oitbench.path_traced.export.view import View
from oitbench.path_traced.matched.branching import BranchingWalk
from oitbench.path_traced.matched.environment import OpenEnvironment
from oitbench.path_traced.matched.medium import SingleScattering
from oitbench.path_traced.matched.openness import Openness
from oitbench.path_traced.matched.shading import Shading
from oitbench.path_traced.matched.straight import StraightWalk
from oitbench.path_traced.matched.visibility import BeamVisibility
from oitbench.path_traced.photons.map import CausticMap
from oitbench.path_traced.trace.integrators import (
    Integrator,
    require_finite_rays,
    require_wide,
    trace,
)
from oitbench.path_traced.trace.lights import TracedEnvironment
from oitbench.path_traced.trace.medium import TracedMedium
from oitbench.path_traced.trace.sequence import Turn, seed_of
from oitbench.path_traced.trace.surfaces import Surfaces
from oitbench.scene import Scene
from oitbench.scene.environment import ambient_of_medium

_CHUNK = 1 << 16
"""Rays that are traced at once."""
_PHOTONS = 32
"""Photons of a caustic map for each pixel. A finer grid of sub-pixels needs no finer map."""
_RANDOM = Effect.DIFFUSION | Effect.CAUSTICS | Effect.VOLUME | Effect.AMBIENT_OCCLUSION


def is_random(scene: Scene, effects: Effect) -> bool:
    """Return whether a matched picture under `effects` depends on `part`.

    Coverage, transmission, emission, beams, shadows, the open environment and refraction do not.
    """
    return bool(scene.effects & effects & _RANDOM)


def matched(
    scene: Scene,
    size: tuple[int, int],
    ssaa: int = 2,
    effects: Effect | None = None,
    *,
    samples: int = 1,
    part: int = 0,
    jitter: bool = False,
) -> Image:
    """Render a scene with exactly the light transport that a set of effects stands for.

    Parameters
    ----------
    scene : Scene
    size : (int, int)
        Width and height in pixels.
    ssaa : int
        Side of the sub-pixel grid.
    effects : Effect, optional
        Effects that run. Those that the scene does not request are ignored. Default: all that it
        requests. Coverage always runs.
    samples : int
        Samples of each sub-pixel, if `is_random`.
    part : int
        Number of the picture: pictures of different numbers are independent, if `is_random`.
    jitter : bool
        Whether rays pass through their sub-pixels at random, instead of where OpenGL samples them.

    Returns
    -------
    array, shape (h, w, 3), float32
        Linear Rec.709 radiance, top row first.

    Raises
    ------
    UsageError
        If a side, `ssaa` or `samples` is below one.
    CapabilityError
        If the scene cannot be path traced, or not on this machine.
    SceneError
        If the radiance of a ray is not finite.
    """
    if min(*size, ssaa, samples) < 1:
        raise UsageError(
            f"size {size[0]}x{size[1]}, ssaa {ssaa} and samples {samples} must be at least 1"
        )
    running = scene.effects if effects is None else scene.effects & effects
    random = is_random(scene, running)
    scene = scene.resolved(size[1] * ssaa).near_origin()
    mitsuba = llvm.load()
    require_wide(scene, mitsuba)
    view = View(scene.camera, size[0] * ssaa, size[1] * ssaa)
    stage = _Stage(mitsuba, scene, view, ssaa, running, random)
    total: Any = 0.0
    count = samples if random else 1
    for sample in range(count):
        image = stage.sample((part, sample), jitter)
        require_finite_rays(scene, image)
        total = total + box_downsample(image, ssaa)
    return np.asarray(total / count, dtype=np.float32)


class _Stage:
    """A scene that is ready to be traced under some effects."""

    def __init__(
        self,
        mitsuba: ModuleType,
        scene: Scene,
        view: View,
        ssaa: int,
        effects: Effect,
        random: bool,
    ) -> None:
        self._mitsuba, self._drjit = mitsuba, importlib.import_module("drjit")
        self._scene, self._view, self._ssaa = scene, view, ssaa
        self._effects, self._random = effects, random
        self._exported: ExportedScene = export(scene, view, mitsuba)
        refracts = Effect.REFRACTION in effects
        self._surfaces = Surfaces.build(mitsuba, self._drjit, view, self._exported, refracts)
        modules = mitsuba, self._drjit
        traced = TracedEnvironment.build(*modules, scene)
        self._environment = OpenEnvironment(*modules, scene.environment, traced)
        self._medium = None
        if Effect.VOLUME in effects and scene.medium is not None:
            fog = TracedMedium.build(*modules, scene.medium)
            self._medium = SingleScattering(*modules, fog, ambient_of_medium(scene))
        self._openness = None
        if Effect.AMBIENT_OCCLUSION in effects:
            radius = scene.ambient_occlusion
            self._openness = Openness(*modules, self._surfaces, traced, radius)

    def sample(self, key: tuple[int, int], jitter: bool) -> Image:
        """Return one sample of each sub-pixel, shape (h, w, 3); `key` seeds random numbers."""
        walk, view = self._walk(key), self._view
        count = view.width * view.height
        parts = []
        for first in range(0, count, _CHUNK):
            seed = (key[0], first, key[1]) if jitter else ()
            rays = view.rays(first, min(first + _CHUNK, count), seed)
            turn = Turn(
                seed_of(*key, first), seed_of(key[0]), key[1], first, view.width, self._ssaa
            )
            parts.append(trace(self._mitsuba, walk, self._exported.content, rays, turn))
        return np.concatenate(parts).reshape(view.height, view.width, 3)

    def _walk(self, key: tuple[int, int]) -> Integrator:
        modules = self._mitsuba, self._drjit
        effects, surfaces, medium = self._effects, self._surfaces, self._medium
        caustics = None
        if Effect.CAUSTICS in effects:
            photons = _PHOTONS * self._view.width * self._view.height // self._ssaa**2
            exported = self._exported
            caustics = CausticMap.build(
                *modules, exported.content, exported.scene, photons, seed_of(*key)
            )
        visibility = BeamVisibility(*modules, surfaces, effects, medium)
        shading = Shading(
            *modules, self._scene, surfaces, self._environment, visibility, self._openness, caustics
        )
        kind = BranchingWalk if BranchingWalk.needed(surfaces, effects) else StraightWalk
        return kind(*modules, surfaces, shading, self._environment, effects, medium, self._random)

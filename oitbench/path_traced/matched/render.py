"""Rendering of a matched reference."""

from __future__ import annotations

import importlib

import numpy as np

from oitbench.effects import Effect
from oitbench.image.files import Image, box_downsample
from oitbench.path_traced import llvm
from oitbench.path_traced.export.scene import export
from oitbench.path_traced.export.view import View
from oitbench.path_traced.matched.branching import BranchingWalk
from oitbench.path_traced.matched.environment import OpenEnvironment
from oitbench.path_traced.matched.shading import Shading
from oitbench.path_traced.matched.straight import StraightWalk
from oitbench.path_traced.matched.visibility import BeamVisibility
from oitbench.path_traced.trace.integrators import Integrator, trace
from oitbench.path_traced.trace.lights import TracedEnvironment
from oitbench.path_traced.trace.surfaces import Surfaces
from oitbench.scene import Scene

_CHUNK = 1 << 16
"""Rays that are traced at once."""


def matched(
    scene: Scene, size: tuple[int, int], ssaa: int = 2, effects: Effect | None = None
) -> Image:
    """Render a scene with exactly the light transport that a set of effects stands for.

    Parameters
    ----------
    scene : Scene
    size : (int, int)
        Width and height in pixels.
    ssaa : int
        Side of the sub-pixel grid; rays pass through the same points as in OpenGL.
    effects : Effect, optional
        Effects that run. Those that the scene does not request are ignored. Default: all that it
        requests.

    Returns
    -------
    array, shape (h, w, 3), float32
        Linear Rec.709 radiance, top row first.
    """
    running = scene.effects if effects is None else scene.effects & effects
    scene = scene.near_origin()
    mitsuba = llvm.load()
    drjit = importlib.import_module("drjit")
    view = View(scene.camera, size[0] * ssaa, size[1] * ssaa)
    exported = export(scene, view, mitsuba)
    surfaces = Surfaces.build(mitsuba, drjit, view, exported)
    environment = TracedEnvironment.build(mitsuba, drjit, scene)
    around = OpenEnvironment(mitsuba, drjit, scene.environment, environment)
    visibility = BeamVisibility(mitsuba, drjit, surfaces, running, caustics=False)
    shading = Shading(mitsuba, drjit, scene, surfaces, around, visibility)
    kind = BranchingWalk if BranchingWalk.needed(surfaces, running) else StraightWalk
    walk: Integrator = kind(mitsuba, drjit, surfaces, shading, environment, running)
    count = view.width * view.height
    parts = [
        trace(mitsuba, walk, exported.content, view.rays(first, min(first + _CHUNK, count)), 0)
        for first in range(0, count, _CHUNK)
    ]
    return box_downsample(np.concatenate(parts).reshape(view.height, view.width, 3), ssaa)

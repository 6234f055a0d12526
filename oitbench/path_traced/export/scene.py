"""Export of a whole scene to Mitsuba.

All films become one mesh, and their materials become attributes of its faces. One acceleration
structure thus holds all objects, and the kernel stays small.
"""

from __future__ import annotations

import importlib
from dataclasses import dataclass
from types import ModuleType
from typing import Any

from oitbench.path_traced.export.checks import require_traceable
from oitbench.path_traced.export.film import Film
from oitbench.path_traced.export.mesh import build_mesh
from oitbench.path_traced.export.shapes import layout
from oitbench.path_traced.export.texture import FilteredTextures
from oitbench.path_traced.export.touching import separated
from oitbench.path_traced.export.variation import Variation
from oitbench.path_traced.export.view import View
from oitbench.scene import BLACK, Object, Scene
from oitbench.scene.texturing import distinct_images


@dataclass(frozen=True, eq=False)
class ExportedScene:
    """A scene in Mitsuba.

    Parameters
    ----------
    content : mitsuba.Scene
        The surfaces and the background. Lights and the medium are traced from `Scene` itself.
    scene : Scene
        What was exported: refracting solids that touch have been moved (see `touching`).
    groups : dict of str to list of Object
        The objects of each shape, by the id of the shape (see `shapes.layout`).
    variation : Variation
        What varies over the surfaces.
    """

    content: Any
    scene: Scene
    groups: dict[str, list[Object]]
    variation: Variation


def export(scene: Scene, view: View, mitsuba: ModuleType) -> ExportedScene:
    """Build the Mitsuba scene that `view` sees.

    Parameters
    ----------
    scene : Scene
    view : View
        Textures are filtered for its sub-pixels.
    mitsuba : module
        With a variant set.

    Raises
    ------
    CapabilityError
        If the scene cannot be path traced.
    """
    scene = separated(scene)
    require_traceable(scene)
    drjit = importlib.import_module("drjit")
    content: dict[str, Any] = {"type": "scene"}
    images = distinct_images(item.material for item in scene.objects)
    numbers = {key: number for number, key in enumerate(images)}
    textures = None
    if images:
        textures = FilteredTextures.build(mitsuba, drjit, images.values(), view)
    variation = Variation.of(mitsuba, drjit, scene.objects, textures, numbers)
    film = Film(mitsuba, drjit, view, variation)
    groups = layout(scene)
    for name, group in groups.items():
        content[name] = build_mesh(mitsuba, film, group)
    if scene.background != BLACK:
        radiance = {"type": "rgb", "value": [float(value) for value in scene.background]}
        content["background"] = {"type": "constant", "radiance": radiance}
    return ExportedScene(mitsuba.load_dict(content), scene, groups, variation)

"""Export of a whole scene to Mitsuba.

All films become one mesh, and their materials become attributes of its faces. One acceleration
structure thus holds all objects, and the kernel stays small.
"""

from __future__ import annotations

import importlib
from collections.abc import Hashable
from dataclasses import dataclass
from types import ModuleType
from typing import Any

from oitbench.path_traced.export.checks import require_traceable
from oitbench.path_traced.export.film import Film
from oitbench.path_traced.export.mesh import build_mesh, texture_number
from oitbench.path_traced.export.shapes import layout
from oitbench.path_traced.export.texture import FilteredTextures
from oitbench.path_traced.export.touching import separated
from oitbench.path_traced.export.view import View
from oitbench.scene import BLACK, Material, Object, Scene
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
    textures : FilteredTextures or None
        None if no object has a texture.
    numbers : dict of hashable to int
        Place of each texture in `textures`, by `image_key`.
    """

    content: Any
    scene: Scene
    groups: dict[str, list[Object]]
    textures: FilteredTextures | None
    numbers: dict[Hashable, int]

    def texture_of(self, material: Material) -> int:
        """Return the number of a material's texture plus one; 0 if it has none."""
        return texture_number(material, self.numbers)


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
    film = Film(mitsuba, drjit, view, textures)
    groups = layout(scene)
    for name, group in groups.items():
        content[name] = build_mesh(mitsuba, film, group, numbers)
    if scene.background != BLACK:
        radiance = {"type": "rgb", "value": [float(value) for value in scene.background]}
        content["background"] = {"type": "constant", "radiance": radiance}
    return ExportedScene(mitsuba.load_dict(content), scene, groups, textures, numbers)

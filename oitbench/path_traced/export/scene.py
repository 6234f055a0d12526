"""Export of a whole scene to Mitsuba.

All films of one texture become one mesh, and their materials become attributes of its faces. One
acceleration structure thus holds all objects, and the kernel stays small.
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
from oitbench.path_traced.export.texture import FilteredTexture
from oitbench.path_traced.export.view import View
from oitbench.scene import BLACK, Object, Scene
from oitbench.scene.texturing import premultiplied_pyramid


@dataclass(frozen=True, eq=False)
class ExportedScene:
    """A scene in Mitsuba.

    Parameters
    ----------
    content : mitsuba.Scene
        The surfaces and the background. Lights and the medium are traced from `Scene` itself.
    groups : dict of str to list of Object
        The objects of each shape, by the id of the shape (see `shapes.layout`).
    textures : dict of str to FilteredTexture
        By the id of the shape; shapes that have no texture are absent.
    """

    content: Any
    groups: dict[str, list[Object]]
    textures: dict[str, FilteredTexture]


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
    require_traceable(scene)
    drjit = importlib.import_module("drjit")
    content: dict[str, Any] = {"type": "scene"}
    textures: dict[str, FilteredTexture] = {}
    groups = layout(scene)
    for name, group in groups.items():
        pyramid = premultiplied_pyramid(group[0].material)
        if pyramid is not None:
            textures[name] = FilteredTexture.build(mitsuba, drjit, pyramid, view)
        film = Film(mitsuba, drjit, view, textures.get(name))
        content[name] = build_mesh(mitsuba, film, group)
    if scene.background != BLACK:
        radiance = {"type": "rgb", "value": [float(value) for value in scene.background]}
        content["background"] = {"type": "constant", "radiance": radiance}
    return ExportedScene(mitsuba.load_dict(content), groups, textures)

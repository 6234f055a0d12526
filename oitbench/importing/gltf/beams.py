"""Cameras and lights of a glTF file, which look and shine along −z of their nodes."""

from __future__ import annotations

import itertools
import math
import re
from collections.abc import Iterable

import numpy as np

from oitbench.errors import SceneError
from oitbench.importing.content import Content, PointLight
from oitbench.importing.gltf.document import Document
from oitbench.importing.gltf.extensions import LIGHTS, LightOfNode, PunctualLight, PunctualLights
from oitbench.importing.gltf.schema import Camera as Described
from oitbench.importing.gltf.schema import Node
from oitbench.scene import (
    PENUMBRA,
    Camera,
    DirectionalLight,
    Floats,
    SpotLight,
    Vector,
    as_vector,
    unit,
)
from oitbench.views import EYES, MAIN, is_name

FRAME = "frame"
"""Name of the view that shows everything, in scenes whose file has cameras."""
_LONGEST = 40
_LEAST_NEAR = 1e-6
_LEAST_ANGLE = 0.02


def add_camera(document: Document, content: Content, node: Node, matrix: Floats) -> None:
    """Add the camera of a node, if it has one."""
    if node.camera is None:
        return
    described = document.part("camera", document.gltf.cameras, node.camera)
    document.budget.take("cameras", 1)
    name = _view_name(described.name or node.name, content.cameras)
    position, ahead, up = _pose(matrix, f"camera {name}")
    content.cameras[name] = _camera(described, name, position, ahead, up)


def _view_name(text: str, taken: Iterable[str]) -> str:
    """Return a free name of a view: small letters, digits and underscores."""
    plain = re.sub(r"[^a-z0-9]+", "_", text[:_LONGEST].lower()).strip("_")
    plain = plain if is_name(plain) else f"camera_{plain}".rstrip("_")
    names = {*taken, FRAME, MAIN, *EYES}
    numbers = (f"{plain}_{number}" for number in itertools.count(2))
    return plain if plain not in names else next(name for name in numbers if name not in names)


def _camera(described: Described, name: str, position: Vector, ahead: Floats, up: Vector) -> Camera:
    target = as_vector(np.asarray(position) + ahead)
    if described.perspective is not None:
        lens = described.perspective
        far = math.inf if lens.zfar is None or lens.zfar <= lens.znear else lens.zfar
        return Camera(position, target, up, lens.yfov, max(lens.znear, _LEAST_NEAR), far)
    if described.orthographic is not None:
        shape = described.orthographic
        if shape.ymag == 0 or shape.zfar <= shape.znear:
            raise SceneError(f"camera {name} shows nothing; give it a height and a depth")
        return Camera(
            position, target, up, near=max(shape.znear, _LEAST_NEAR), far=shape.zfar,
            height=2 * abs(shape.ymag),
        )  # fmt: skip
    raise SceneError(f"camera {name} is neither perspective nor orthographic")


def add_light(document: Document, content: Content, node: Node, matrix: Floats) -> None:
    """Add the light of a node, if it has one."""
    used = node.extension(LIGHTS, LightOfNode)
    if used is None:
        return
    found = document.gltf.extension(LIGHTS, PunctualLights) or PunctualLights()
    light = document.part("light", found.lights, used.light)
    red, green, blue = (light.intensity * part for part in light.color)
    strength = red, green, blue
    if not any(strength):
        return
    document.budget.take("lights", 1)
    name = light.name or node.name or f"light {used.light}"
    position, ahead, _ = _pose(matrix, f"light {name}")
    if light.range is not None:
        document.notes.add("ranges of lights are ignored; light falls with the square of distance")
    if light.type == "directional":
        content.lights.append(DirectionalLight(as_vector(ahead), strength))
    elif light.type == "point":
        content.points.append(PointLight(position, strength))
    else:
        target = as_vector(np.asarray(position) + ahead)
        content.lights.append(SpotLight(position, target, strength, _angle(document, light)))


def _angle(document: Document, light: PunctualLight) -> float:
    """Return the full angle of a spot light."""
    outer, inner = light.spot.outer_cone_angle, light.spot.inner_cone_angle
    if not math.isclose(inner, (1 - PENUMBRA) * outer, rel_tol=0.02):
        document.notes.add(f"spot lights fade over the last {PENUMBRA:.0%} of their half angle")
    return min(max(2 * outer, _LEAST_ANGLE), math.pi - 1e-3)


def _pose(matrix: Floats, owner: str) -> tuple[Vector, Floats, Vector]:
    """Return the position, the direction ahead and the direction up of a node."""
    ahead, up = -matrix[:3, 2], matrix[:3, 1]
    if not ahead.any() or not up.any():
        raise SceneError(f"{owner} has a transform without direction; give it a scale")
    return as_vector(matrix[:3, 3]), unit(ahead), as_vector(unit(up))

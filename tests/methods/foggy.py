"""Fog in front of a wall, for tests of the march through a medium."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

from oitbench.gl.device import Device
from oitbench.gl.frame import Frame
from oitbench.measure.accounting import traffic
from oitbench.modeling.mesh import quad
from oitbench.scene import (
    RGB,
    Camera,
    DirectionalLight,
    Light,
    Material,
    Medium,
    Object,
    Scene,
    SpotLight,
)
from tests.helpers import BACKGROUND, opened

SIZE = (20, 14)
STEPS = 8
CAMERA = Camera((0, 0, 0), (0, 0, -1), fov_y=math.radians(40))
FAR_CAMERA = Camera((0, 0, 0), (0, 0, -1), fov_y=math.radians(0.5))
FLOAT = f"phenomenological[precision=float,steps={STEPS}]"
LOW, HIGH = (-5.0, -5.0, -3.5), (5.0, 5.0, -0.8)
FOG = Medium(0.7, LOW, HIGH, albedo=(0.9, 0.7, 0.5), anisotropy=0.6)
AMBIENT: RGB = (0.4, 0.3, 0.2)
SUN = DirectionalLight((1.0, -1.0, 1.5), (3.0, 2.0, 1.0))
LAMP = SpotLight((0.6, 0.8, -1.6), (-0.3, -0.5, -2.6), (2.0, 3.0, 4.0), math.radians(70))


def wall(z: float = 3.0, color: RGB = BACKGROUND) -> Object:
    """Return an emissive wall across the view."""
    return Object("wall", quad((0, 0, -z), (9, 0, 0), (0, 9, 0)), Material(emission=color))


def foggy(
    medium: Medium | None = FOG,
    lights: tuple[Light, ...] = (),
    objects: tuple[Object, ...] = (),
    camera: Camera = CAMERA,
) -> Scene:
    """Return fog in front of a wall that casts no shadow."""
    objects = (replace(wall(), casts=False), *objects)
    return Scene("fog", camera, objects, lights=lights, medium=medium)


def targets(device: Device, scene: Scene, name: str = FLOAT, **options: Any) -> tuple[Any, Any]:
    """Return the gathered targets: sums, and products with variances."""
    with opened(device, scene, name, SIZE, **options) as frame:
        frame.render()
        return frame.read("accum"), frame.read("beta")


def moved_bytes(frame: Frame, name: str) -> dict[str, int]:
    """Return the bytes that one pass of a frame moves, by kind."""
    frame.render()
    measured = frame.measure()
    found: dict[str, int] = {}
    for term in traffic(frame, measured).terms:
        if term.pass_ == name:
            found[term.kind] = found.get(term.kind, 0) + term.bytes
    return found

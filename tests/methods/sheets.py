"""Sheets in front of a wall of random texels, for tests of refraction and diffusion."""

from __future__ import annotations

import math

import numpy as np

from oitbench.gl.frame import Frame, Image
from oitbench.modeling.mesh import quad
from oitbench.scene import WHITE, Camera, Material, Object, Scene, Texture

SIZE = (48, 40)
CAMERA = Camera(position=(0, 0, 0), target=(0, 0, -1), fov_y=math.radians(40))
FLOAT = "phenomenological[precision=float]"
CLEAR = Material(transmission=WHITE, specular=0.0)
FOCAL = SIZE[1] / 2 / math.tan(CAMERA.fov_y / 2)
"""Focal length in pixels."""


def with_parameter(parameter: str) -> str:
    """Return the label of the method in single precision with a further parameter."""
    return f"{FLOAT[:-1]},{parameter}]"


def wall(z: float = 4.0) -> Object:
    """Return a wall that fills the view with random texels."""
    texels = np.random.default_rng(3).random((32, 32, 3), dtype=np.float32)
    half = 1.3 * z * math.tan(CAMERA.fov_y / 2)
    emission = Material(emission=Texture(texels))
    return Object("wall", quad((0, 0, -z), (half, 0, 0), (0, half, 0)), emission)


def sheet_scene(
    material: Material, z: float = 2.0, behind: float = 4.0, tilt: float = 0.0
) -> Scene:
    """Return a sheet that fills the view in front of the wall.

    Parameters
    ----------
    material : Material
    z, behind : float
        Distances of the sheet and of the wall, meters.
    tilt : float
        Rotation of the sheet about the y axis, radians.
    """
    half = 2.0 * z
    right = (half * math.cos(tilt), 0.0, half * math.sin(tilt))
    sheet = Object("sheet", quad((0, 0, -z), right, (0, half, 0)), material)
    return Scene("sheet", CAMERA, (wall(behind), sheet))


def read(frame: Frame, name: str) -> Image:
    """Render a frame and return one of its targets."""
    frame.render()
    return frame.read(name)

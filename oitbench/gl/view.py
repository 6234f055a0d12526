"""The uniform block `View` (shaders/view.glsl): the camera's, and that of a light's map."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from oitbench.gl.program.prelude import TILE
from oitbench.scene import Camera, DirectionalLight, Object, SpotLight

Floats = npt.NDArray[np.float64]
_MARGIN = 0.02
"""Part of a map's width left free on each side, so that filters find something there."""


@dataclass(frozen=True, eq=False)
class Projection:
    """How points in the world are seen: by a camera, or by a light.

    Parameters
    ----------
    to_camera, to_clip : array, shape (4, 4)
        World to camera space, and camera space to clip space.
    near, far : float
        View distances in metres; `far` may be infinite.
    focal : float
        Half the height of the picture over its tangent: the focal length for a height of two.
    eye : array, shape (4,)
        Position and 1, or the direction to the viewer and 0 for parallel rays.
    """

    to_camera: Floats
    to_clip: Floats
    near: float
    far: float
    focal: float
    eye: Floats

    @property
    def world_to_clip(self) -> Floats:
        """World to clip space, (4, 4)."""
        return np.asarray(self.to_clip @ self.to_camera)

    @property
    def distance_row(self) -> Floats:
        """What gives the view distance of (position, 1) by a dot product."""
        return np.asarray(-self.to_camera[2])

    def block(self, size: tuple[int, int], transmittance: bool = False) -> bytes:
        """Return the bytes of the block for a picture of `size` (width, height)."""
        width, height = size
        tiles = [math.ceil(side / TILE) for side in size]
        gain = 0.0 if transmittance else 1.0
        return b"".join(
            (
                self.world_to_clip.T.astype(np.float32).tobytes(),
                self.to_camera.T.astype(np.float32).tobytes(),
                np.array(
                    [self.near, self.far, self.focal * height / 2, gain], dtype=np.float32
                ).tobytes(),
                np.array([width, height, *tiles, 0, 0, 0, 0], dtype=np.uint32).tobytes(),
                self.eye.astype(np.float32).tobytes(),
            )
        )


def camera_projection(camera: Camera, aspect: float) -> Projection:
    """Return the projection of a camera whose picture is `aspect` times as wide as high."""
    focal = 1 / math.tan(camera.fov_y / 2)
    return Projection(
        _to_camera(camera.axes, np.asarray(camera.position)),
        _perspective(focal / aspect, focal, camera.near, camera.far),
        camera.near,
        camera.far,
        focal,
        np.array([*camera.position, 1.0]),
    )


def view_block(
    camera: Camera, size: tuple[int, int], transmittance: bool, subsample: int = 1
) -> bytes:
    """Return the bytes of `View` for a frame of `size`, or for its blocks of pixels.

    Parameters
    ----------
    camera : Camera
    size : (int, int)
        Width and height of the frame in pixels.
    transmittance : bool
        Whether radiance is left out.
    subsample : int
        Pixels along each side of a block. Blocks that the frame's edge cuts are seen as a whole, so
        that each stands for as many pixels as any other.
    """
    seen = camera_projection(camera, size[0] / size[1])
    small = (math.ceil(size[0] / subsample), math.ceil(size[1] / subsample))
    across, along = (side / (subsample * count) for side, count in zip(size, small, strict=True))
    whole = np.diag([across, along, 1.0, 1.0])
    whole[:2, 3] = across - 1, along - 1
    seen = replace(seen, to_clip=whole @ seen.to_clip, focal=seen.focal * along)
    return seen.block(small, transmittance)


def light_projection(
    light: DirectionalLight | SpotLight, casters: tuple[Object, ...], all_: tuple[Object, ...]
) -> Projection | None:
    """Return how `light` sees a scene, fitted to what casts shadows; None if nothing does.

    Parameters
    ----------
    light : DirectionalLight or SpotLight
    casters : tuple of Object
        What the map must hold from side to side.
    all_ : tuple of Object
        What may receive shadows: the map reaches as deep as they do.
    """
    if not casters:
        return None
    if isinstance(light, DirectionalLight):
        return _parallel(light, casters, all_)
    return _conical(light, casters, all_)


def _parallel(
    light: DirectionalLight, casters: tuple[Object, ...], all_: tuple[Object, ...]
) -> Projection:
    back = -np.asarray(light.direction, dtype=np.float64)
    axes = _axes_along(back)
    low, high = _bounds(casters, axes)
    deepest = _bounds(all_, axes)[0][2]
    reach = float(np.linalg.norm(high - low)) / 2 + 1e-3
    center, half = (low + high) / 2, np.maximum((high - low) / 2, 1e-6) * (1 + 2 * _MARGIN)
    # The map's plane lies just before the nearest caster: variances are told apart from zero in
    # proportion to distances from it.
    before = _MARGIN * reach
    eye = np.array([center[0], center[1], high[2] + 2 * before]) @ axes
    near, far = before, float(high[2] + 2 * before - min(low[2], deepest)) * 1.01
    to_clip = np.diag([1 / half[0], 1 / half[1], -2 / (far - near), 1.0])
    to_clip[2, 3] = -(far + near) / (far - near)
    return Projection(
        _to_camera(axes, eye),
        to_clip,
        near,
        far,
        1 / float(half[:2].max()),
        np.array([*axes[2], 0.0]),
    )


def _conical(
    light: SpotLight, casters: tuple[Object, ...], all_: tuple[Object, ...]
) -> Projection | None:
    position = np.asarray(light.position, dtype=np.float64)
    axes = _axes_along(position - np.asarray(light.target))
    behind = float(position @ axes[2])
    nearest = behind - float(_bounds(casters, axes)[1][2])
    far = (behind - float(_bounds(all_, axes)[0][2])) * 1.01
    if far <= 0:
        return None
    near = max(0.9 * nearest, 1e-3 * far)
    low, high = _slopes(casters, axes, position, near, math.tan(light.angle / 2))
    if (low >= high).any():
        return None
    middle, half = (low + high) / 2, (high - low) / 2 * (1 + 2 * _MARGIN)
    to_clip = _perspective(1 / float(half[0]), 1 / float(half[1]), near, far)
    to_clip[:2, 2] = middle / half  # off center: only what casts is in the map
    return Projection(
        _to_camera(axes, position), to_clip, near, far, 1 / float(half.max()),
        np.array([*position, 1.0]),
    )  # fmt: skip


def _slopes(
    objects: tuple[Object, ...], axes: Floats, position: Floats, near: float, widest: float
) -> tuple[Floats, Floats]:
    """Return the least and greatest (x, y) over distance of what lies in a cone's square."""
    low, high = np.full(2, np.inf), np.full(2, -np.inf)
    for item in objects:
        points = (item.mesh.positions.astype(np.float64) - position) @ axes.T
        distance = -points[:, 2]
        if (distance < near).any():
            # Part of it lies behind the light: no bound can be told from its corners.
            return np.full(2, -widest), np.full(2, widest)
        slopes = points[:, :2] / distance[:, None]
        low, high = np.minimum(low, slopes.min(axis=0)), np.maximum(high, slopes.max(axis=0))
    return np.maximum(low, -widest), np.minimum(high, widest)


def _axes_along(back: Floats) -> Floats:
    """Return right, up and backward unit vectors as rows."""
    back = back / np.linalg.norm(back)
    right = np.cross(np.eye(3)[np.argmin(np.abs(back))], back)
    right /= np.linalg.norm(right)
    return np.stack([right, np.cross(back, right), back])


def _bounds(objects: tuple[Object, ...], axes: Floats) -> tuple[Floats, Floats]:
    """Return the lowest and highest coordinates along `axes`."""
    low, high = np.full(3, np.inf), np.full(3, -np.inf)
    for item in objects:
        points = item.mesh.positions.astype(np.float64) @ axes.T
        low, high = np.minimum(low, points.min(axis=0)), np.maximum(high, points.max(axis=0))
    return low, high


def _to_camera(axes: Floats, position: Floats) -> Floats:
    matrix = np.eye(4)
    matrix[:3, :3] = axes
    matrix[:3, 3] = -axes @ position.astype(np.float64)
    return matrix


def _perspective(across: float, along: float, near: float, far: float) -> Floats:
    # The limits of the usual (far + near)/(near − far) and 2·far·near/(near − far).
    ratio = 0.0 if math.isinf(far) else near / far
    matrix = np.zeros((4, 4))
    matrix[0, 0], matrix[1, 1] = across, along
    matrix[2, 2] = -(1 + ratio) / (1 - ratio)
    matrix[2, 3] = -2 * near / (1 - ratio)
    matrix[3, 2] = -1
    return matrix

"""Projections of a camera and of a light's map, as the uniform block `View` (shaders/view.glsl)."""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass, replace

import numpy as np

from oitbench.gl.tiling import TILE
from oitbench.scene import (
    Camera,
    DirectionalLight,
    Floats,
    Object,
    Scene,
    SpotLight,
    Vector,
    axes_along,
)
from oitbench.scene.checks import require, single_precision

ITERATION_OFFSET, FRAME_OFFSET = 160, 164
"""Byte offsets of `iteration` and `frame_number` in the block."""
_LEAST_NEAR = 1e-30
"""Meters; single precision holds the reciprocals of such distances."""
_MARGIN = 0.02
"""Part of a map's width that stays empty on each side, for filters."""


@dataclass(frozen=True, eq=False)
class Projection:
    """The projection of points in the world to the picture of a camera or of a light.

    Parameters
    ----------
    to_camera, to_clip : array, shape (4, 4)
        World to camera space, and camera space to clip space.
    near, far : float
        View distances in meters; `far` may be infinite.
    focal : float
        Focal length for a picture of height two; the inverse of half its height in meters if rays
        are parallel.
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
        """Row whose dot product with (position, 1) is the view distance."""
        return np.asarray(-self.to_camera[2])

    def block(
        self,
        size: tuple[int, int],
        transmittance: bool = False,
        origin: Vector = (0.0, 0.0, 0.0),
        transparent_range: tuple[float, float] = (0.0, 0.0),
    ) -> bytes:
        """Return the bytes of the block for a picture of `size` (width, height).

        Parameters
        ----------
        size : (int, int)
        transmittance : bool
            Whether all radiance is zero.
        origin : Vector
            `Geometry.origin`.
        transparent_range : (float, float)
            `transparent_range` of the scene; maps of lights have none.

        Raises
        ------
        SceneError
            If a number does not fit in single precision.
        """
        width, height = size
        tiles = [math.ceil(side / TILE) for side in size]
        gain = 0.0 if transmittance else 1.0
        infinite = math.isinf(self.far)
        numbers = [self.near, self.near if infinite else self.far, self.focal * height / 2, gain]
        to_camera = self.to_camera.copy()
        to_camera[:3, 3] -= to_camera[:3, :3] @ np.asarray(origin)
        parts = [
            single_precision("the view of the scene", part)
            for part in (
                self.world_to_clip.T,
                to_camera.T,
                numbers,
                self.eye,
                [*origin, 0.0],
                [*transparent_range, 0.0, 0.0],
            )
        ]
        near = float(parts[2][0])
        require(near >= _LEAST_NEAR, f"camera: near is {self.near} m; give a larger distance")
        if infinite:
            parts[2][1] = np.inf
        ahead = self.to_clip @ (0.0, 0.0, -1.0, 1.0)
        center = (ahead[:2] / ahead[3] + 1) / 2 * (width, height)
        sizes = np.array([width, height, *tiles, 0, 0], dtype=np.uint32)
        sizes = np.concatenate([sizes, center.astype(np.float32).view(np.uint32)])
        return b"".join(part.tobytes() for part in (*parts[:3], sizes, *parts[3:]))


def camera_projection(camera: Camera, aspect: float) -> Projection:
    """Return the projection of a camera whose picture is `aspect` times as wide as high."""
    focal = 2 / camera.span
    kind = _orthographic if camera.orthographic else _perspective
    eye = [*camera.axes[2], 0.0] if camera.orthographic else [*camera.position, 1.0]
    return Projection(
        _to_camera(camera.axes, np.asarray(camera.position)),
        kind(focal / aspect, focal, camera.near, camera.far),
        camera.near,
        camera.far,
        focal,
        np.array(eye),
    )


def bounded_camera(scene: Scene) -> Camera:
    """Return the camera of `scene`, with a finite far plane if it is orthographic.

    A linear depth has no infinite far plane. This one is just behind all that is visible.
    """
    camera, medium = scene.camera, scene.medium
    if not camera.orthographic or math.isfinite(camera.far):
        return camera
    distances = [camera.view_distance(item.mesh.used_positions) for item in scene.objects]
    if medium is not None:
        corners = itertools.product(*zip(medium.low, medium.high, strict=True))
        distances.append(camera.view_distance(list(corners)))
    if scene.lists is not None:
        distances.append(scene.lists.z.astype(np.float64))
    deepest = max(float(part.max()) for part in distances)
    return replace(camera, far=1.01 * max(deepest, 2 * camera.near))


def view_block(
    camera: Camera,
    size: tuple[int, int],
    transmittance: bool,
    subsample: int = 1,
    origin: Vector = (0.0, 0.0, 0.0),
    transparent_range: tuple[float, float] = (0.0, 0.0),
) -> bytes:
    """Return the bytes of `View` for a frame of `size`, or for a downsampled target.

    Parameters
    ----------
    camera : Camera
    size : (int, int)
        Width and height of the frame in pixels.
    transmittance : bool
        Whether all radiance is zero.
    subsample : int
        Downsampling factor per axis. The picture extends to whole blocks beyond the frame's edge,
        so that each texel covers the same number of pixels.
    origin : Vector
        `Geometry.origin`.
    transparent_range : (float, float)
        `transparent_range` of the scene.
    """
    seen = camera_projection(camera, size[0] / size[1])
    small = (math.ceil(size[0] / subsample), math.ceil(size[1] / subsample))
    across, along = (side / (subsample * count) for side, count in zip(size, small, strict=True))
    whole = np.diag([across, along, 1.0, 1.0])
    whole[:2, 3] = across - 1, along - 1
    seen = replace(seen, to_clip=whole @ seen.to_clip, focal=seen.focal * along)
    return seen.block(small, transmittance, origin, transparent_range)


def transparent_range(scene: Scene) -> tuple[float, float]:
    """Return the least and greatest view distance of all transparent geometry, in meters.

    It lies beyond the near plane, and covers geometry outside of the picture.

    Parameters
    ----------
    scene : Scene
        In meters.
    """
    near = scene.camera.near
    if scene.lists is not None:
        distances = scene.lists.z if scene.lists.z.size else np.array([near])
        low, high = float(distances.min()), float(distances.max())
    elif scene.transparent:
        lowest, highest = _bounds(scene.transparent, scene.camera.axes)
        behind = float(np.asarray(scene.camera.position) @ scene.camera.axes[2])
        low, high = behind - float(highest[2]), behind - float(lowest[2])
    else:
        low = high = near
    return max(low, near), max(high, near)


def light_projection(
    light: DirectionalLight | SpotLight, casters: tuple[Object, ...], all_: tuple[Object, ...]
) -> Projection | None:
    """Return the projection of a shadow map of `light`; None if nothing casts shadows in it.

    Parameters
    ----------
    light : DirectionalLight or SpotLight
    casters : tuple of Object
        Objects that the map covers in width and height.
    all_ : tuple of Object
        Possible receivers of shadows, which the map covers in depth.
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
    axes = axes_along(back)
    low, high = _bounds(casters, axes)
    deepest = _bounds(all_, axes)[0][2]
    reach = float(np.linalg.norm(high - low)) / 2
    center, half = (low + high) / 2, np.maximum((high - low) / 2, 1e-6 * reach) * (1 + 2 * _MARGIN)
    # The map's plane lies just before the nearest caster: the smallest variance that can be
    # distinguished from zero is proportional to the distance from it.
    before = _MARGIN * reach
    eye = np.array([center[0], center[1], high[2] + 2 * before]) @ axes
    near, far = before, float(high[2] + 2 * before - min(low[2], deepest)) * 1.01
    to_clip = _orthographic(1 / float(half[0]), 1 / float(half[1]), near, far)
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
    axes = axes_along(position - np.asarray(light.target))
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
    to_clip[:2, 2] = middle / half  # off center: the map covers casters only
    return Projection(
        _to_camera(axes, position), to_clip, near, far, 1 / float(half.max()),
        np.array([*position, 1.0]),
    )  # fmt: skip


def _slopes(
    objects: tuple[Object, ...], axes: Floats, position: Floats, near: float, widest: float
) -> tuple[Floats, Floats]:
    """Return the least and greatest (x, y) over distance of objects within a cone's square."""
    low, high = np.full(2, np.inf), np.full(2, -np.inf)
    for item in objects:
        points = (item.mesh.used_positions - position) @ axes.T
        distance = -points[:, 2]
        if (distance < near).any():
            # Part of it lies behind the light: its corners give no bound.
            return np.full(2, -widest), np.full(2, widest)
        slopes = points[:, :2] / distance[:, None]
        low, high = np.minimum(low, slopes.min(axis=0)), np.maximum(high, slopes.max(axis=0))
    return np.maximum(low, -widest), np.minimum(high, widest)


def _bounds(objects: tuple[Object, ...], axes: Floats) -> tuple[Floats, Floats]:
    """Return the lowest and highest coordinates along `axes`."""
    low, high = np.full(3, np.inf), np.full(3, -np.inf)
    for item in objects:
        points = item.mesh.used_positions @ axes.T
        low, high = np.minimum(low, points.min(axis=0)), np.maximum(high, points.max(axis=0))
    return low, high


def _to_camera(axes: Floats, position: Floats) -> Floats:
    matrix = np.eye(4)
    matrix[:3, :3] = axes
    matrix[:3, 3] = -axes @ position.astype(np.float64)
    return matrix


def _orthographic(across: float, along: float, near: float, far: float) -> Floats:
    matrix = np.diag([across, along, 1 / (far - near), 1.0])
    matrix[2, 3] = far / (far - near)
    return matrix


def _perspective(across: float, along: float, near: float, far: float) -> Floats:
    # Reversed: the depth near/z of an infinite far plane is a float of full precision everywhere.
    ratio = 0.0 if math.isinf(far) else near / far
    matrix = np.zeros((4, 4))
    matrix[0, 0], matrix[1, 1] = across, along
    matrix[2, 2] = ratio / (1 - ratio)
    matrix[2, 3] = near / (1 - ratio)
    matrix[3, 2] = -1
    return matrix

"""Meshes that depend on the view: squares and ribbons that face the camera."""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import dataclass, field, fields, replace
from functools import cached_property
from typing import ClassVar

import numpy as np
import numpy.typing as npt

from oitbench.scene.camera import Camera
from oitbench.scene.checks import require, require_finite, require_fractions, require_light
from oitbench.scene.objects import Mesh
from oitbench.scene.vectors import Array, Floats, Vector, unit

_AT_REST = Camera(position=(0.0, 0.0, 1.0), height=1.0)
_FINE = 1 << 30
"""Height of a picture whose pixels are smaller than any strand."""
_LEAST = 1e-12
"""Length of a segment in the picture, relative to the distance, below which it has no direction."""
_CORNERS = np.array([(-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0), (1.0, 1.0)])


@dataclass(frozen=True, eq=False)
class ViewMesh(Mesh):
    """A mesh that is made anew for each view; see `Scene.resolved`.

    Its own arrays are those of a view along −z, made when they are first asked for. They serve for
    bounds and counts, and are drawn by no renderer.
    """

    by_pixel: ClassVar[bool] = False
    """Whether it depends on the height of the picture in pixels."""

    positions: Floats = field(init=False, repr=False)
    triangles: npt.NDArray[np.uint32] = field(init=False, repr=False)
    uvs: Array | None = field(init=False, repr=False)
    radiance: Array | None = field(init=False, repr=False)
    normals: Array | None = field(init=False, repr=False)
    albedo: Array | None = field(init=False, repr=False)
    transmission: Array | None = field(init=False, repr=False)
    coverage: Array | None = field(init=False, repr=False)

    def __post_init__(self) -> None:
        """Check nothing: there are no arrays yet."""

    @cached_property
    def _at_rest(self) -> Mesh:
        return self.for_view(_AT_REST, _FINE)

    @abstractmethod
    def for_view(self, camera: Camera, pixel_height: int) -> Mesh:
        """Return the mesh as a camera sees it.

        Parameters
        ----------
        camera : Camera
        pixel_height : int
            Height of its picture in pixels, sub-pixels included.
        """

    @abstractmethod
    def relocated(self, origin: Vector, scale: float) -> ViewMesh:
        """Return the mesh relative to `origin`, in units that are `scale` times smaller."""


def _array_at_rest(name: str) -> cached_property[object]:
    """Return the attribute `name` of a mesh at rest."""
    made = cached_property[object](lambda mesh: getattr(mesh._at_rest, name))
    made.__set_name__(ViewMesh, name)
    return made


for _item in fields(Mesh):
    setattr(ViewMesh, _item.name, _array_at_rest(_item.name))


@dataclass(frozen=True, eq=False)
class Sprites(ViewMesh):
    """Squares that face the camera, or halfway between the camera and a light.

    Parameters
    ----------
    centers : array, shape (n, 3)
        World positions in the scene's unit.
    radii : array, shape (n,), or float
        Half the edge length of each square.
    turns : array, shape (n,), or float
        Angle by which each square is turned in its plane, radians.
    toward_light : Vector, optional
        Direction to a light. Squares are then perpendicular to the vector halfway between it and
        the direction to the camera, so that neither sees them edge-on. Squares that face the camera
        alone cast almost no shadow from above.
    albedos : array, shape (n, 3), optional
        Factor on the material's albedo for each square, in [0, 1]. Default: one.

    Raises
    ------
    SceneError
        If a value is not finite, a radius is not above 0, or an array has a wrong shape.

    References
    ----------
    Ikits et al. 2004, "Volume rendering techniques" (GPU Gems 39): half-angle slicing.
    """

    centers: npt.ArrayLike
    radii: npt.ArrayLike
    turns: npt.ArrayLike = 0.0
    toward_light: Vector | None = None
    albedos: npt.ArrayLike | None = None

    def __post_init__(self) -> None:
        centers = np.asarray(self.centers, dtype=np.float64)
        count = len(centers)
        require(count > 0 and centers.shape == (count, 3), "sprites: centers must be (n, 3)")
        object.__setattr__(self, "centers", centers)
        for name in ("radii", "turns"):
            values = np.asarray(getattr(self, name), dtype=np.float64)
            require(values.shape in ((), (count,)), f"sprites: {name} must be ({count},) or one")
            object.__setattr__(self, name, np.broadcast_to(values, count))
        require_finite("sprites", centers=centers, radii=self.radii, turns=self.turns)
        require(bool((np.asarray(self.radii) > 0).all()), "sprites: radii must be above 0")
        if self.toward_light is not None:
            require_finite("sprites", toward_light=self.toward_light)
            require(any(self.toward_light), "sprites: toward_light has no length")
        if self.albedos is not None:
            found = np.asarray(self.albedos, dtype=np.float32)
            require(found.shape == (count, 3), f"sprites: albedos must be ({count}, 3)")
            require_fractions("sprites", albedos=found)
            object.__setattr__(self, "albedos", found)

    def for_view(self, camera: Camera, pixel_height: int) -> Mesh:
        """Return the squares as a camera sees them; see `ViewMesh.for_view`."""
        count = len(np.asarray(self.centers))
        size, turn = np.asarray(self.radii)[:, None], np.asarray(self.turns)[:, None]
        right, up = self._plane(camera)
        rights = size * (np.cos(turn) * right + np.sin(turn) * up)
        ups = size * (np.cos(turn) * up - np.sin(turn) * right)
        x, y = _CORNERS[:, :1], _CORNERS[:, 1:]
        positions = x * rights[:, None] + y * ups[:, None] + np.asarray(self.centers)[:, None]
        triangles = np.array([(0, 1, 3), (0, 3, 2)]) + 4 * np.arange(count)[:, None, None]
        return Mesh.from_arrays(
            positions.reshape(-1, 3),
            triangles.reshape(-1, 3),
            uvs=np.tile((_CORNERS + 1) / 2, (count, 1)),
            normals=np.repeat(unit(np.cross(rights, ups)), 4, axis=0),
            albedo=None if self.albedos is None else np.repeat(self.albedos, 4, axis=0),
        )

    def relocated(self, origin: Vector, scale: float) -> Sprites:
        """Return the squares relative to `origin`; see `ViewMesh.relocated`."""
        centers = (np.asarray(self.centers) - np.asarray(origin)) * scale
        return replace(self, centers=centers, radii=np.asarray(self.radii) * scale)

    def _plane(self, camera: Camera) -> tuple[Floats, Floats]:
        """Return two perpendicular unit vectors that span the plane of the squares."""
        right, upward, back = camera.axes
        if self.toward_light is None:
            return right, upward
        light = np.asarray(self.toward_light, dtype=np.float64)
        light = light / np.linalg.norm(light)
        # Both sides of a square look the same, so a light behind the square may be mirrored.
        half = back + light if back @ light >= 0 else back - light
        up = np.cross(half, right)
        up /= np.linalg.norm(up)
        across = np.cross(up, half)
        return across / np.linalg.norm(across), up


@dataclass(frozen=True, eq=False)
class Strands(ViewMesh):
    """Ribbons along curves that face the camera and are at least one pixel wide.

    A strand that is thinner than a pixel is drawn one pixel wide, and its coverage times its own
    width over that of the pixel. A ribbon is one strip of triangles with mitered joints, so that no
    joint has a gap or is covered twice, unless the curve turns back in the picture within its own
    width. Lights see the ribbons that the camera sees.

    Parameters
    ----------
    points : array, shape (n, k, 3)
        Curves of k points, 2 or more, in the scene's unit.
    width : array, shape (n, k), (n, 1), or float
        Full width of the strands.
    radiances : array, shape (n, k, 3), optional
        Factor on the material's emission at each point. Default: one.

    Raises
    ------
    SceneError
        If a value is not finite, a width is not above 0, or an array has a wrong shape.

    Notes
    -----
    Normals are perpendicular to the curves and face the camera, as in the middle of a round strand.
    Texture coordinate u runs across the ribbon, and v along it from 0 to 1.
    """

    by_pixel = True

    points: npt.ArrayLike
    width: npt.ArrayLike
    radiances: npt.ArrayLike | None = None

    def __post_init__(self) -> None:
        points = np.asarray(self.points, dtype=np.float64)
        shaped = points.ndim == 3 and points.shape[1] >= 2 and points.shape[2] == 3
        require(shaped and len(points) > 0, "strands: points must be (n, k, 3) with k above 1")
        object.__setattr__(self, "points", points)
        width = np.asarray(self.width, dtype=np.float64)
        n, k = points.shape[:2]
        require(width.shape in ((), (n, 1), (n, k)), f"strands: width must be ({n}, {k}) or one")
        object.__setattr__(self, "width", width if width.ndim else float(width))
        require_finite("strands", points=points, width=width)
        require(bool((width > 0).all()), "strands: width must be above 0")
        if self.radiances is not None:
            found = np.asarray(self.radiances, dtype=np.float32)
            require(found.shape == (n, k, 3), f"strands: radiances must be ({n}, {k}, 3)")
            require_light("strands", radiances=found)
            object.__setattr__(self, "radiances", found)

    def for_view(self, camera: Camera, pixel_height: int) -> Mesh:
        """Return the ribbons as a camera sees them; see `ViewMesh.for_view`."""
        if pixel_height < 1:
            raise ValueError("strands depend on the height of the picture in pixels; give it")
        points = np.asarray(self.points)
        n, k = points.shape[:2]
        pixel = camera.pixel_size(points, pixel_height)
        width = np.broadcast_to(np.asarray(self.width), (n, k))
        half = np.maximum(width, pixel)[..., None] / 2 * self._across(camera)
        positions = np.stack([points - half, points + half], axis=2)
        corner = 2 * np.arange(k - 1)[:, None, None]
        strip = (corner + np.array([(0, 1, 3), (0, 3, 2)])).reshape(-1, 3)
        triangles = strip[None] + 2 * k * np.arange(n)[:, None, None]
        along = np.repeat(np.linspace(0, 1, k), 2)
        radiances = self.radiances
        return Mesh.from_arrays(
            positions.reshape(-1, 3),
            triangles.reshape(-1, 3),
            uvs=np.tile(np.stack([np.tile((0.0, 1.0), k), along], axis=1), (n, 1)),
            radiance=None if radiances is None else _doubled(np.asarray(radiances)),
            normals=_doubled(self._normals(camera)),
            coverage=_doubled(np.minimum(width / pixel, 1.0)[..., None]).ravel(),
        )

    def relocated(self, origin: Vector, scale: float) -> Strands:
        """Return the strands relative to `origin`; see `ViewMesh.relocated`."""
        points = (np.asarray(self.points) - np.asarray(origin)) * scale
        return replace(self, points=points, width=np.asarray(self.width) * scale)

    def _across(self, camera: Camera) -> Floats:
        """Return vectors across the ribbons, for a ribbon of half width one, shape (n, k, 3)."""
        points = np.asarray(self.points)
        place = (points - np.asarray(camera.position)) @ camera.axes[:2].T
        if not camera.orthographic:
            place /= np.maximum(camera.view_distance(points), camera.near)[..., None]
        steps = np.diff(place, axis=1)
        length = np.linalg.norm(steps, axis=2, keepdims=True)
        # A segment along the line of sight has no direction in the picture; any will do.
        steps = np.where(length > _LEAST, steps / np.maximum(length, _LEAST), (0.0, 1.0))
        sides = np.stack([steps[..., 1], -steps[..., 0]], axis=2)
        joints = np.concatenate([sides[:, :1], sides], axis=1)
        joints += np.concatenate([sides, sides[:, -1:]], axis=1)
        size = np.linalg.norm(joints, axis=2, keepdims=True)
        # A miter of two unit normals m is 2m/|m|². It is at most twice as long as they are.
        miters = 2 * joints / np.maximum(np.maximum(size, size**2), _LEAST)
        return np.asarray(miters @ camera.axes[:2])

    def _normals(self, camera: Camera) -> Floats:
        """Return unit vectors toward the camera and perpendicular to the curves, (n, k, 3)."""
        points = np.asarray(self.points)
        toward = np.broadcast_to(camera.axes[2], points.shape)
        if not camera.orthographic:
            toward = _directions(np.asarray(camera.position) - points, camera.axes[2])
        along = _directions(np.gradient(points, axis=1), camera.axes[1])
        facing = toward - (toward * along).sum(axis=2, keepdims=True) * along
        return _directions(facing, camera.axes[2])


def _directions(vectors: Floats, instead: Floats) -> Floats:
    """Return unit vectors in the directions of `vectors`, and `instead` for those of no length."""
    length = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return np.asarray(np.where(length > _LEAST, vectors / np.maximum(length, _LEAST), instead))


def _doubled(values: npt.NDArray[np.floating]) -> npt.NDArray[np.floating]:
    """Return values of points, shape (n, k, c), for both edges of each ribbon, (2 n k, c)."""
    return np.repeat(values.reshape(-1, values.shape[-1]), 2, axis=0)

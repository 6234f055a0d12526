"""Content of scenes: meshes, objects of one material, and lists of fragments without geometry."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from functools import cached_property

import numpy as np
import numpy.typing as npt

from oitbench.scene.checks import require, require_finite, require_fractions, require_light
from oitbench.scene.material import TEXTURED, Material, Texture
from oitbench.scene.vectors import BLACK, Array, Floats, Vector

_NEAR_ONE = 0.02
"""Error of a normal's length that is allowed; normals of 8 bits are off by less."""


@dataclass(frozen=True, eq=False)
class Mesh:
    """Indexed triangles.

    Parameters
    ----------
    positions : array, shape (n, 3), float64
        World positions in the scene's unit. Any numbers are converted.
    triangles : array, shape (m, 3), uint32
        Vertex indices; counterclockwise seen from the front.
    uvs : array, shape (n, 2), float32, optional
        Texture coordinates.
    radiance : array, shape (n, 3), float32, optional
        Factor on the material's emission at each vertex, for baked shading. Default: one.
    normals : array, shape (n, 3), float32, optional
        Unit normals. Default: flat shading.
    albedo, transmission : array, shape (n, 3), float32, optional
        Factors on the material's albedo and transmission at each vertex, in [0, 1]. Default: one.
    coverage : array, shape (n,), float32, optional
        Factor on the material's coverage at each vertex, in [0, 1]. Default: one.

    Raises
    ------
    SceneError
        If an array has a wrong shape, a value is not finite or out of range, a normal is not of
        length one, there is no triangle, or an index is out of range.
    """

    positions: Floats
    triangles: npt.NDArray[np.uint32]
    uvs: Array | None = None
    radiance: Array | None = None
    normals: Array | None = None
    albedo: Array | None = None
    transmission: Array | None = None
    coverage: Array | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "positions", np.asarray(self.positions, dtype=np.float64))
        count = len(self.positions)
        require(self.positions.shape == (count, 3), "mesh: positions must be (n, 3)")
        require(self.triangles.shape[1:] == (3,), "mesh: triangles must be (m, 3)")
        require(len(self.triangles) > 0, "mesh: it has no triangle; leave the object out")
        last = int(self.triangles.max())
        require(last < count, f"mesh: a triangle uses vertex {last} of {count}; count from 0")
        for name, values, width in (
            ("uvs", self.uvs, 2),
            ("radiance", self.radiance, 3),
            ("normals", self.normals, 3),
            ("albedo", self.albedo, 3),
            ("transmission", self.transmission, 3),
            ("coverage", self.coverage, 0),
        ):
            shape = (count, width) if width else (count,)
            require(values is None or values.shape == shape, f"mesh: {name} must be {shape}")
        require_finite("mesh", positions=self.positions, uvs=self.uvs, normals=self.normals)
        require_light("mesh", radiance=self.radiance)
        require_fractions("mesh", **self.factors)
        if self.normals is not None:
            lengths = np.linalg.norm(self.normals, axis=1)
            unit = bool((np.abs(lengths - 1) <= _NEAR_ONE).all())
            require(unit, "mesh: normals must have length one; divide them by their lengths")

    @classmethod
    def from_arrays(
        cls,
        positions: npt.ArrayLike,
        triangles: npt.ArrayLike,
        **vertices: npt.ArrayLike | None,
    ) -> Mesh:
        """Return a mesh of arrays of any numeric type, rounded to the types that a mesh stores.

        Parameters
        ----------
        positions, triangles : array_like
            As in `Mesh`.
        **vertices : array_like, optional
            The other arrays of `Mesh` by name.
        """
        return cls(
            np.asarray(positions, dtype=np.float64),
            np.asarray(triangles).astype(np.uint32),
            **{
                name: None if values is None else np.asarray(values, dtype=np.float32)
                for name, values in vertices.items()
            },
        )

    @property
    def factors(self) -> dict[str, Array]:
        """The factors on properties of the material that vertices have, except on emission."""
        named = ("albedo", "transmission", "coverage")
        return {name: values for name, values in self.vertices.items() if name in named}

    @property
    def vertices(self) -> dict[str, Array]:
        """All arrays of vertices that the mesh has beside positions, by name."""
        names = {field.name for field in fields(Mesh)} - {"positions", "triangles"}
        found = {name: getattr(self, name) for name in sorted(names)}
        return {name: values for name, values in found.items() if values is not None}

    @cached_property
    def used_positions(self) -> Floats:
        """Positions of the vertices that triangles use, shape (k, 3): only they have a place."""
        used = np.zeros(len(self.positions), dtype=bool)
        used[self.triangles] = True
        return self.positions if used.all() else self.positions[used]

    def with_separate_corners(self) -> Mesh:
        """Return the mesh with three vertices of its own for each triangle."""
        corners = self.triangles.ravel()
        return replace(
            self,
            positions=self.positions[corners],
            triangles=np.arange(len(corners), dtype=np.uint32).reshape(-1, 3),
            **{name: values[corners] for name, values in self.vertices.items()},
        )

    def relocated(self, origin: Vector, scale: float) -> Mesh:
        """Return the mesh relative to `origin`, in units that are `scale` times smaller."""
        return replace(self, positions=(self.positions - np.asarray(origin)) * scale)


@dataclass(frozen=True, eq=False)
class Object:
    """A mesh of one material: the unit that is drawn, and that methods sort by object.

    Parameters
    ----------
    name : str
        Unique within the scene.
    mesh : Mesh
        Needs uvs if the material has a texture.
    material : Material
    casts : bool
        False for floors and walls that throw no shadow on any other object. Shadow maps are then
        fitted to the remaining objects. The object still receives shadows.
    particles : bool
        True for sprites without fine detail, which may be accumulated at a lower resolution.
    decal_of : str, optional
        Name of the object in whose planes this one lies. Surfaces that lie exactly in one plane
        are found without it.
    receives_shadows : bool
        False for an object that all beams reach, whatever lies between. It still casts shadows.
    priority : int
        Where refracting solids touch or overlap, the one of the highest priority fills the space,
        and of equal priorities the one that comes first in the scene. Give glass a higher one than
        the water that it holds, and let the water touch the glass or reach into it.

    Raises
    ------
    SceneError
        If the material has a texture and the mesh has no uvs, or it is a decal of itself.
    """

    name: str
    mesh: Mesh
    material: Material
    casts: bool = True
    particles: bool = False
    decal_of: str = ""
    receives_shadows: bool = True
    priority: int = 0

    def __post_init__(self) -> None:
        require(self.decal_of != self.name, f"object {self.name}: it is a decal of itself")
        material, mesh = self.material, self.mesh
        textured = any(isinstance(getattr(material, name), Texture) for name in TEXTURED)
        require(
            not textured or mesh.uvs is not None,
            f"object {self.name}: its material has a texture but its mesh has no uvs; add uvs",
        )
        if self.refracts:
            material.require_even(f"object {self.name}")
            require(
                mesh.albedo is None and mesh.transmission is None,
                f"object {self.name}: a refracting solid is even; leave albedo and transmission out"
                " of its mesh",
            )

    @property
    def opaque(self) -> bool:
        """Whether no light passes the surface where it is; see `Material.opaque`."""
        # Asked last, a mesh that depends on the view is not made for an answer that is known.
        return self.material.opaque and (
            self.mesh.coverage is None or self.material.cutoff is not None
        )

    @property
    def refracts(self) -> bool:
        """Whether light that passes changes its direction; see `Material.refracts`."""
        return self.material.refracts and not self.opaque

    @cached_property
    def tints(self) -> bool:
        """Whether the transmitted fraction may differ between channels."""
        if self.material.transmission == BLACK:
            return False
        factors = self.mesh.albedo, self.mesh.transmission
        gray = all(one is None or bool((one == one[:, :1]).all()) for one in factors)
        return not gray or self.material.tints


@dataclass(frozen=True, eq=False)
class FragmentLists:
    """Fragments without geometry, layer by layer. Texel (y, x) is pixel (y, x), top row first.

    All of them are composited as transparent, even where α = 1 and t = 0. They cannot be path
    traced.

    Parameters
    ----------
    z : array, shape (n, h, w), float32
        Linear view distance in the scene's unit, between the camera's near and far plane.
    coverage : array, shape (n, h, w), float32
        α in [0, 1].
    radiance : array, shape (n, h, w, 3), float32
        L, linear Rec.709, not premultiplied.
    transmission : array, shape (n, h, w, 3), float32
        t in [0, 1].

    Raises
    ------
    SceneError
        If an array has a wrong shape, or a value is not finite or out of range.
    """

    z: Array
    coverage: Array
    radiance: Array
    transmission: Array

    def __post_init__(self) -> None:
        shape = self.z.shape
        require(len(shape) == 3, "fragment lists: z must be (layers, h, w)")
        require(self.coverage.shape == shape, f"fragment lists: coverage must be {shape}")
        for name, values in (("radiance", self.radiance), ("transmission", self.transmission)):
            require(values.shape == (*shape, 3), f"fragment lists: {name} must be {(*shape, 3)}")
        require_finite("fragment lists", z=self.z)
        require_light("fragment lists", radiance=self.radiance)
        require_fractions("fragment lists", coverage=self.coverage, transmission=self.transmission)

    def scaled(self, scale: float) -> FragmentLists:
        """Return the lists in units of length that are `scale` times smaller."""
        z = self.z if scale == 1 else (self.z.astype(np.float64) * scale).astype(np.float32)
        return replace(self, z=z)

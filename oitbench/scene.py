"""The scene model: frozen descriptions that never mention a renderer.

Metres, radians, right-handed, y up, the camera looks down its −z; radiance, transmission and albedo
are linear Rec.709 and unpremultiplied.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from oitbench.effects import Effect
from oitbench.errors import SceneError

RGB = tuple[float, float, float]
Array = npt.NDArray[np.float32]
BLACK: RGB = (0.0, 0.0, 0.0)
WHITE: RGB = (1.0, 1.0, 1.0)


def _require(condition: bool, message: str) -> None:
    if not condition:
        raise SceneError(message)


def _finite(owner: str, **arrays: npt.ArrayLike | None) -> None:
    for name, values in arrays.items():
        if values is not None and not np.isfinite(np.asarray(values, dtype=np.float64)).all():
            raise SceneError(f"{owner}: {name} holds NaN or infinity; every value must be finite")


def is_grey(color: RGB) -> bool:
    """Tell whether the three channels of `color` are equal."""
    return color[0] == color[1] == color[2]


@dataclass(frozen=True, eq=False)
class Texture:
    """A picture wrapped round uv ∈ [0, 1]², clamped at its edges.

    Parameters
    ----------
    texels : array, shape (h, w) or (h, w, 3), float32
        One channel for coverage, three for radiance; the first row is at v = 1 (top). Both sides
        must be powers of two, so that every mip level halves exactly.
    """

    texels: Array

    def __post_init__(self) -> None:
        shape = self.texels.shape
        _require(
            len(shape) == 2 or (len(shape) == 3 and shape[2] == 3),
            f"texture: texels are {shape}; give (h, w) for coverage or (h, w, 3) for radiance",
        )
        for side in shape[:2]:
            _require(
                side > 0 and side & (side - 1) == 0, f"texture: side {side} is no power of two"
            )
        _finite("texture", texels=self.texels)


@dataclass(frozen=True, eq=False)
class Material:
    """How a surface covers, transmits, emits and reflects light.

    Parameters
    ----------
    coverage : float or Texture
        Fraction α of the surface that is there at all, in [0, 1].
    transmission : RGB
        Fraction t of the light that passes where the surface is, per channel in [0, 1].
    emission : RGB or Texture
        Radiance L that leaves the covered surface, W·sr⁻¹·m⁻² on an arbitrary scale.
    albedo : RGB
        Diffuse reflectance under the scene's lights.
    roughness : float
        Width of the specular lobe, in [0, 1].
    index : float
        Refractive index N of the inside, 1 for none.
    collimation : float
        c in [0, 1]: 1 passes light in a beam, 0 spreads it all.
    solid : bool
        True for the boundary of a closed solid, False for a thin sheet.
    binary_coverage : bool
        True for foliage whose unfiltered coverage is 0 or 1 and that transmits nothing.
    """

    coverage: float | Texture = 1.0
    transmission: RGB = BLACK
    emission: RGB | Texture = BLACK
    albedo: RGB = BLACK
    roughness: float = 1.0
    index: float = 1.0
    collimation: float = 1.0
    solid: bool = False
    binary_coverage: bool = False

    def __post_init__(self) -> None:
        coverage = self.coverage.texels if isinstance(self.coverage, Texture) else self.coverage
        emission = self.emission.texels if isinstance(self.emission, Texture) else self.emission
        _finite("material", coverage=coverage, emission=emission, transmission=self.transmission)
        _finite("material", albedo=self.albedo, roughness=self.roughness, index=self.index)
        unit = {
            "coverage": coverage,
            "transmission": self.transmission,
            "albedo": self.albedo,
            "roughness": self.roughness,
            "collimation": self.collimation,
        }
        for name, value in unit.items():
            values = np.asarray(value)
            _require(bool(((values >= 0) & (values <= 1)).all()), f"material: {name} leaves [0, 1]")
        _require(bool((np.asarray(emission) >= 0).all()), "material: emission is negative")
        _require(self.index >= 1, f"material: index {self.index} is below 1 (that of vacuum)")

    @property
    def opaque(self) -> bool:
        """Whether nothing passes: coverage is one everywhere and transmission zero."""
        return self.coverage == 1.0 and self.transmission == BLACK


@dataclass(frozen=True, eq=False)
class Mesh:
    """Indexed triangles.

    Parameters
    ----------
    positions : array, shape (n, 3), float32
        World positions in metres.
    triangles : array, shape (m, 3), uint32
        Vertex indices; counter-clockwise seen from the front.
    uvs : array, shape (n, 2), float32, optional
        Texture coordinates.
    radiance : array, shape (n, 3), float32, optional
        Factor on the material's emission at each vertex, for shading baked into the scene.
    normals : array, shape (n, 3), float32, optional
        Unit normals; triangles are flat without.
    """

    positions: Array
    triangles: npt.NDArray[np.uint32]
    uvs: Array | None = None
    radiance: Array | None = None
    normals: Array | None = None

    def __post_init__(self) -> None:
        count = len(self.positions)
        _require(self.positions.shape == (count, 3), "mesh: positions must be (n, 3)")
        _require(self.triangles.shape[1:] == (3,), "mesh: triangles must be (m, 3)")
        _require(len(self.triangles) > 0, "mesh: there is no triangle")
        _require(
            int(self.triangles.max()) < count, "mesh: a triangle names a vertex beyond the last"
        )
        for name, values, width in (
            ("uvs", self.uvs, 2),
            ("radiance", self.radiance, 3),
            ("normals", self.normals, 3),
        ):
            _require(
                values is None or values.shape == (count, width),
                f"mesh: {name} must be ({count}, {width})",
            )
        _finite("mesh", positions=self.positions, uvs=self.uvs)
        _finite("mesh", radiance=self.radiance, normals=self.normals)


@dataclass(frozen=True, eq=False)
class Object:
    """A mesh of one material: the unit that is drawn, and sorted by object."""

    name: str
    mesh: Mesh
    material: Material

    def __post_init__(self) -> None:
        textured = isinstance(self.material.coverage, Texture) or isinstance(
            self.material.emission, Texture
        )
        _require(
            not textured or self.mesh.uvs is not None,
            f"object {self.name}: its material has a texture but its mesh has no uvs",
        )


@dataclass(frozen=True, eq=False)
class FragmentLists:
    """Fragments given outright, layer by layer: texel (y, x) is pixel (y, x), top row first.

    They are always composited as transparent, also where α = 1 and t = 0, and have no geometry that
    a path tracer could meet.

    Parameters
    ----------
    z : array, shape (n, h, w), float32
        Linear view distance in metres, beyond the camera's near plane.
    coverage : array, shape (n, h, w), float32
    radiance, transmission : array, shape (n, h, w, 3), float32
    """

    z: Array
    coverage: Array
    radiance: Array
    transmission: Array

    def __post_init__(self) -> None:
        shape = self.z.shape
        _require(len(shape) == 3, "fragment lists: z must be (layers, h, w)")
        _require(self.coverage.shape == shape, f"fragment lists: coverage must be {shape}")
        for name, values in (("radiance", self.radiance), ("transmission", self.transmission)):
            _require(values.shape == (*shape, 3), f"fragment lists: {name} must be {(*shape, 3)}")
        _finite("fragment lists", z=self.z, coverage=self.coverage)
        _finite("fragment lists", radiance=self.radiance, transmission=self.transmission)


@dataclass(frozen=True)
class Camera:
    """A pinhole camera.

    Parameters
    ----------
    position, target, up : RGB
        Metres in world space.
    fov_y : float
        Full vertical opening angle, radians.
    near, far : float
        Clip distances in metres; an infinite far plane gives window depth d = 1 − near/z.
    """

    position: RGB
    target: RGB = (0.0, 0.0, 0.0)
    up: RGB = (0.0, 1.0, 0.0)
    fov_y: float = math.radians(45)
    near: float = 0.1
    far: float = math.inf

    def __post_init__(self) -> None:
        _finite("camera", position=self.position, target=self.target, up=self.up, near=self.near)
        _require(0 < self.fov_y < math.pi, "camera: fov_y must lie between 0 and π radians")
        _require(0 < self.near < self.far, "camera: near must be above 0 and below far")
        _require(self.position != self.target, "camera: position and target coincide")

    @property
    def axes(self) -> npt.NDArray[np.float64]:
        """Unit right, up and backward vectors as the rows of a (3, 3) array."""
        back = np.subtract(self.position, self.target).astype(np.float64)
        back /= np.linalg.norm(back)
        right = np.cross(np.asarray(self.up, dtype=np.float64), back)
        right /= np.linalg.norm(right)
        return np.stack([right, np.cross(back, right), back])

    def view_distance(self, points: npt.ArrayLike) -> npt.NDArray[np.float64]:
        """Return the distance of `points`, shape (..., 3), along the view axis, in metres."""
        offset = np.asarray(points, dtype=np.float64) - np.asarray(self.position)
        return np.asarray(-(offset @ self.axes[2]))


@dataclass(frozen=True)
class DirectionalLight:
    """Light from infinity: the direction it travels, and its irradiance on a facing surface."""

    direction: RGB
    irradiance: RGB = WHITE


@dataclass(frozen=True)
class SpotLight:
    """A point that shines into a cone; `intensity` in W·sr⁻¹, `angle` the full cone in radians."""

    position: RGB
    target: RGB
    intensity: RGB = WHITE
    angle: float = math.radians(40)


@dataclass(frozen=True, eq=False)
class EnvironmentLight:
    """Radiance from all directions: one value, or a latitude-longitude map (h, w, 3), y up."""

    radiance: RGB | Texture = WHITE


Light = DirectionalLight | SpotLight | EnvironmentLight


@dataclass(frozen=True)
class Medium:
    """A homogeneous participating medium: extinction in m⁻¹, single-scattering albedo, and g."""

    extinction: float
    albedo: RGB = WHITE
    anisotropy: float = 0.0


@dataclass(frozen=True, eq=False)
class Scene:
    """All that both renderers need to know.

    Parameters
    ----------
    name : str
        The scene's name with its parameters, for messages.
    camera : Camera
    objects : tuple of Object
        In submission order.
    lists : FragmentLists, optional
        Fragments without geometry, for oracle tests.
    lights : tuple of Light
        None for a scene that is lit by emission alone.
    medium : Medium, optional
    background : RGB
        Radiance where no surface is.
    exposure : float
        Exposure value (stops) for display and every LDR metric: radiance × 2^exposure.
    ambient_occlusion : bool
        Whether opaque surfaces receive ambient occlusion.
    """

    name: str
    camera: Camera
    objects: tuple[Object, ...] = ()
    lists: FragmentLists | None = None
    lights: tuple[Light, ...] = ()
    medium: Medium | None = None
    background: RGB = BLACK
    exposure: float = 0.0
    ambient_occlusion: bool = False
    effects: Effect = field(init=False)

    def __post_init__(self) -> None:
        _finite(f"scene {self.name}", background=self.background, exposure=self.exposure)
        names = [item.name for item in self.objects]
        doubled = {name for name in names if names.count(name) > 1}
        _require(not doubled, f"scene {self.name}: two objects are named {sorted(doubled)}")
        _require(
            bool(self.objects) or self.lists is not None,
            f"scene {self.name}: there is nothing in it",
        )
        object.__setattr__(self, "effects", _derive_effects(self))

    @property
    def opaque(self) -> tuple[Object, ...]:
        """Objects that hide all behind them."""
        return tuple(item for item in self.objects if item.material.opaque)

    @property
    def transparent(self) -> tuple[Object, ...]:
        """Objects that let light through, in submission order."""
        return tuple(item for item in self.objects if not item.material.opaque)


def _derive_effects(scene: Scene) -> Effect:
    """Return what the materials, lights and media of `scene` call for."""
    transparent = [item.material for item in scene.transparent]
    colored = any(not is_grey(m.transmission) for m in transparent)
    lists = scene.lists
    if lists is not None:
        colored = colored or bool((lists.transmission != lists.transmission[..., :1]).any())
    refracting = any(m.index != 1 for m in transparent)
    found = {
        Effect.COVERAGE: bool(transparent) or lists is not None,
        Effect.COLORED_TRANSMISSION: colored,
        Effect.REFRACTION: refracting,
        Effect.DIFFUSION: any(m.collimation < 1 for m in transparent),
        Effect.VOLUME: scene.medium is not None,
        Effect.INFERRED_AO: scene.ambient_occlusion and any(m.binary_coverage for m in transparent),
    }
    if any(not isinstance(light, EnvironmentLight) for light in scene.lights):
        found[Effect.SHADOWS] = bool(scene.opaque)
        found[Effect.TRANSLUCENT_SHADOWS] = bool(transparent)
        found[Effect.COLORED_SHADOWS] = colored
        found[Effect.CAUSTICS] = refracting
    effects = Effect.NONE
    for effect, called in found.items():
        if called:
            effects |= effect
    return effects

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
from oitbench.scene.checks import require as _require
from oitbench.scene.checks import require_finite as _finite
from oitbench.scene.lights import DirectionalLight, EnvironmentLight, Light, Medium, SpotLight
from oitbench.scene.material import BLACK, RGB, Array, Material, Texture


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
    """A mesh of one material: the unit that is drawn, and sorted by object.

    Parameters
    ----------
    name : str
    mesh : Mesh
    material : Material
    casts : bool
        False for floors and walls that throw no shadow on anything else: the lights' shadow maps
        then spend no texel beyond the other objects. They still receive shadows.
    particles : bool
        True for sprites without fine detail, which may be accumulated at a lower resolution.
    """

    name: str
    mesh: Mesh
    material: Material
    casts: bool = True
    particles: bool = False

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
        Radiance where no surface is; with an environment light that is what is seen there.
    exposure : float
        Exposure value (stops) for display and every LDR metric: radiance × 2^exposure.
    ambient_occlusion : float
        Metres up to which surfaces hide the environment light from each other; 0 for not at all.
    """

    name: str
    camera: Camera
    objects: tuple[Object, ...] = ()
    lists: FragmentLists | None = None
    lights: tuple[Light, ...] = ()
    medium: Medium | None = None
    background: RGB = BLACK
    exposure: float = 0.0
    ambient_occlusion: float = 0.0
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
        around = [light for light in self.lights if isinstance(light, EnvironmentLight)]
        _require(len(around) <= 1, f"scene {self.name}: it has more than one environment light")
        _require(
            not around or self.background == BLACK,
            f"scene {self.name}: an environment light is its background; leave background black",
        )
        _require(
            math.isfinite(self.ambient_occlusion) and self.ambient_occlusion >= 0,
            f"scene {self.name}: ambient_occlusion is no distance",
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

    @property
    def environment(self) -> EnvironmentLight | None:
        """The light from all around, if there is one."""
        return next((item for item in self.lights if isinstance(item, EnvironmentLight)), None)

    @property
    def beams(self) -> tuple[DirectionalLight | SpotLight, ...]:
        """The lights that throw shadows."""
        return tuple(item for item in self.lights if not isinstance(item, EnvironmentLight))


def _derive_effects(scene: Scene) -> Effect:
    """Return what the materials, lights and media of `scene` call for."""
    transparent = [item.material for item in scene.transparent]
    colored = any(m.tints for m in transparent)
    lists, medium = scene.lists, scene.medium
    if lists is not None:
        colored = colored or bool((lists.transmission != lists.transmission[..., :1]).any())
    refracting = any(m.refracts for m in transparent)
    diffusing = any(m.collimation < 1 for m in transparent)
    occluded = scene.ambient_occlusion > 0
    lit = bool(scene.beams)
    found = {
        Effect.COVERAGE: bool(transparent) or lists is not None,
        Effect.COLORED_TRANSMISSION: colored,
        Effect.REFRACTION: refracting,
        Effect.DIFFUSION: diffusing or (medium is not None and medium.collimation < 1),
        Effect.VOLUME: medium is not None,
        Effect.AMBIENT_OCCLUSION: occluded,
        Effect.INFERRED_AO: occluded and any(m.binary_coverage for m in transparent),
        Effect.SHADOWS: lit and bool(scene.opaque),
        Effect.TRANSLUCENT_SHADOWS: lit and bool(transparent),
        Effect.COLORED_SHADOWS: lit and colored,
        Effect.CAUSTICS: lit and refracting,
    }
    effects = Effect.NONE
    for effect, called in found.items():
        if called:
            effects |= effect
    return effects

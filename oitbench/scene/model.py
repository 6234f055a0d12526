"""The scene: all that both renderers need to know, and the effects that follow from it."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property

from oitbench.effects import Effect
from oitbench.errors import unknown
from oitbench.scene.camera import Camera
from oitbench.scene.checks import require, require_light
from oitbench.scene.coincidence import Coincidence, find_coincidence, origin_of_planes
from oitbench.scene.lights import DirectionalLight, EnvironmentLight, Light, SpotLight
from oitbench.scene.medium import Medium
from oitbench.scene.objects import FragmentLists, Object
from oitbench.scene.paths import stereo
from oitbench.scene.vectors import BLACK, RGB, Vector
from oitbench.scene.view_meshes import ViewMesh
from oitbench.views import EYES, MAIN, is_name

FAR = 100
"""Distance of the camera from the origin beside that to its target; see `Scene.near_origin`."""
MOST_STOPS = 120
"""Largest exposure: 2^exposure and the exposures of HDR-FLIP beside it are single floats."""


@dataclass(frozen=True, eq=False)
class Scene:
    """Everything that both renderers need to know.

    Parameters
    ----------
    name : str
        The scene's name with its parameters, for messages.
    camera : Camera
    objects : tuple of Object
        In submission order.
    lists : FragmentLists, optional
        Fragments without geometry.
    lights : tuple of Light
        At most one `EnvironmentLight`. Default: no lights; the scene is lit by emission alone.
    medium : Medium, optional
        Default: a vacuum.
    background : RGB
        Radiance where no surface is. Must be black if there is an environment light, which is then
        the background.
    exposure : float
        Exposure value in stops, for display and for every metric of the displayed image: radiance
        is multiplied by 2^exposure.
    ambient_occlusion : float
        Largest distance at which surfaces hide the environment light from each other. Default: 0,
        no occlusion.
    meters_per_unit : float
        Length of the scene's unit in meters: 0.001 if it is written in millimeters. It applies to
        all lengths of camera, meshes, lights, medium and `ambient_occlusion`, and to the medium's
        extinction (an inverse length). Radiance, irradiance and intensity do not depend on it.
    views : mapping of str to Camera
        Further cameras by name; see `from_view`. Names have small letters, digits and underscores.
    path : tuple of Camera
        The frames of a moving camera.
    full_samples : int
        Samples for each sub-pixel of a full reference of 256 × 256, 1 or more: enough for a noise
        floor of 0.02. Default: 0, a number that suits the scene's materials and medium.

    Attributes
    ----------
    effects : Effect
        The effects that the scene requests, derived from its materials, lights and medium.

    Raises
    ------
    SceneError
        If the scene is empty, two objects share a name, there are two environment lights or a
        second background, or a value is out of range.
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
    meters_per_unit: float = 1.0
    full_samples: int = 0
    views: Mapping[str, Camera] = field(default_factory=dict)
    path: tuple[Camera, ...] = ()
    effects: Effect = field(init=False)

    def __post_init__(self) -> None:
        owner = f"scene {self.name}"
        require_light(owner, background=self.background)
        require(
            abs(self.exposure) <= MOST_STOPS,
            f"{owner}: exposure is {self.exposure:g} stops; keep it within ±{MOST_STOPS}",
        )
        counts = Counter(item.name for item in self.objects)
        doubled = sorted(name for name, count in counts.items() if count > 1)
        require(not doubled, f"{owner}: two objects are named {doubled}; rename one")
        for item in self.objects:
            known = not item.decal_of or item.decal_of in counts
            require(known, f"{owner}: {item.name} is a decal of {item.decal_of}, which is missing")
        require(bool(self.objects) or self.lists is not None, f"{owner}: it has no object")
        around = [light for light in self.lights if isinstance(light, EnvironmentLight)]
        require(len(around) <= 1, f"{owner}: it has {len(around)} environment lights; keep one")
        require(
            not around or self.background == BLACK,
            f"{owner}: its environment light is its background; leave background black",
        )
        require(
            math.isfinite(self.ambient_occlusion) and self.ambient_occlusion >= 0,
            f"{owner}: ambient_occlusion is {self.ambient_occlusion}; give 0 or more",
        )
        require(
            math.isfinite(self.meters_per_unit) and self.meters_per_unit > 0,
            f"{owner}: meters_per_unit is {self.meters_per_unit}; give a length above 0",
        )
        require(self.full_samples >= 0, f"{owner}: full_samples is negative; give 1 or more")
        for name in self.views:
            usable = is_name(name) and name != MAIN
            message = "use small letters, digits and underscores, and not main"
            require(usable, f"{owner}: no view can be named '{name}'; {message}")
        if self.lists is not None:
            require(not self.views, f"{owner}: fragment lists have one view; leave views out")
            near, far = self.camera.near, self.camera.far
            seen = bool(((self.lists.z > near) & (self.lists.z <= far)).all())
            require(seen, f"{owner}: z of its fragment lists must lie between {near} and {far}")
        object.__setattr__(self, "effects", _requested_effects(self))

    @property
    def view_names(self) -> tuple[str, ...]:
        """The names of all views, the main one first."""
        named = (MAIN, *self.views)
        if self.lists is not None or self.camera.orthographic:
            return named
        return (*named, *(eye for eye in EYES if eye not in self.views))

    def from_view(self, name: str) -> Scene:
        """Return the scene as seen from one of its views.

        Parameters
        ----------
        name : str
            "main" for `camera`, a name of `views`, or, if `camera` is not orthographic, "left" and
            "right" for its stereo pair (see `oitbench.scene.paths.stereo`).

        Raises
        ------
        UsageError
            If there is no such view.
        """
        if name == MAIN:
            return self
        if name not in self.view_names:
            raise unknown(f"view of {self.name}", name, self.view_names)
        if name in self.views:
            return replace(self, camera=self.views[name])
        return replace(self, camera=stereo(self.camera)[EYES.index(name)])

    @property
    def by_pixel(self) -> bool:
        """Whether its meshes depend on the height of the picture in pixels."""
        found = [item.mesh for item in self.objects]
        return any(isinstance(mesh, ViewMesh) and mesh.by_pixel for mesh in found)

    def resolved(self, pixel_height: int) -> Scene:
        """Return the scene with all meshes that depend on the view as its camera sees them.

        Parameters
        ----------
        pixel_height : int
            Height of the picture in pixels, sub-pixels included.
        """
        if not any(isinstance(item.mesh, ViewMesh) for item in self.objects):
            return self
        return replace(
            self,
            objects=tuple(
                replace(item, mesh=item.mesh.for_view(self.camera, pixel_height))
                if isinstance(item.mesh, ViewMesh)
                else item
                for item in self.objects
            ),
        )

    def in_meters(self) -> Scene:
        """Return the same scene with all lengths in meters."""
        return self if self.meters_per_unit == 1 else self._relocated((0.0, 0.0, 0.0))

    def seen_from_camera(self) -> Scene:
        """Return the same scene in meters, with the camera at the origin.

        Renderers compute in single precision, which is fine near the camera alone.
        """
        return self._relocated(self.camera.position)

    def near_origin(self) -> Scene:
        """Return the same scene in meters, with the camera at the origin if it was far from there.

        Far means `FAR` times the distance to its target. Nearer, the scene's own origin resolves
        its surfaces better.
        """
        camera = self.camera
        far = math.hypot(*camera.position) > FAR * math.dist(camera.position, camera.target)
        return self.seen_from_camera() if far else self.in_meters()

    def _relocated(self, origin: Vector) -> Scene:
        scale = self.meters_per_unit
        return replace(
            self,
            camera=self.camera.relocated(origin, scale),
            views={name: camera.relocated(origin, scale) for name, camera in self.views.items()},
            path=tuple(camera.relocated(origin, scale) for camera in self.path),
            objects=tuple(
                replace(item, mesh=item.mesh.relocated(origin, scale)) for item in self.objects
            ),
            lists=None if self.lists is None else self.lists.scaled(scale),
            lights=tuple(
                light.relocated(origin, scale) if isinstance(light, SpotLight) else light
                for light in self.lights
            ),
            medium=None if self.medium is None else self.medium.relocated(origin, scale),
            ambient_occlusion=self.ambient_occlusion * scale,
            meters_per_unit=1.0,
        )

    @cached_property
    def coincidence(self) -> Coincidence | None:
        """Where surfaces coincide, relative to the camera and in meters; None for nowhere."""
        seen = self.seen_from_camera()
        return find_coincidence(seen.objects, origin_of_planes(seen.camera))

    @property
    def opaque(self) -> tuple[Object, ...]:
        """Objects through which no light passes, in submission order."""
        return tuple(item for item in self.objects if item.opaque)

    @property
    def transparent(self) -> tuple[Object, ...]:
        """Objects through which light passes, in submission order."""
        return tuple(item for item in self.objects if not item.opaque)

    @property
    def environment(self) -> EnvironmentLight | None:
        """The environment light, or None."""
        return next((item for item in self.lights if isinstance(item, EnvironmentLight)), None)

    @property
    def beams(self) -> tuple[DirectionalLight | SpotLight, ...]:
        """The directional and spot lights, which cast shadows."""
        return tuple(item for item in self.lights if not isinstance(item, EnvironmentLight))


def _requested_effects(scene: Scene) -> Effect:
    """Return the effects that the materials, lights and medium of `scene` request."""
    transparent = [item.material for item in scene.transparent]
    colored = any(item.tints for item in scene.transparent)
    lists, medium = scene.lists, scene.medium
    if lists is not None:
        colored = colored or bool((lists.transmission != lists.transmission[..., :1]).any())
    refracting = any(item.refracts for item in scene.transparent)
    diffusing = any(m.collimation < 1 for m in transparent)
    occluded = scene.ambient_occlusion > 0
    lit = bool(scene.beams)
    requested = {
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
    for effect, present in requested.items():
        if present:
            effects |= effect
    return effects

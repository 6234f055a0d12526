"""The lights of a scene for drjit arrays: beams (directional and spot lights), and the environment.

Photons leave beams by `photons.emission`; a new kind of light needs both.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from oitbench.scene import PENUMBRA, RGB, Array, DirectionalLight, Scene, SpotLight, Texture, unit
from oitbench.scene.environment import bilinear, mean_radiance

LEAST_SIDE = 4
"""Least number of texels along a side of the map by which directions are sampled."""
LEAST_FALLOFF = 0.01
"""Least change of the logarithm of an exponential density over a line. Below it, rounding would
spoil the normalization."""


@dataclass(frozen=True, eq=False)
class TracedBeam:
    """A directional or spot light."""

    mitsuba: Any
    drjit: Any
    light: DirectionalLight | SpotLight

    def toward(self, p: Any) -> tuple[Any, Any, Any]:
        """Return the unit vector from `p` to the light, its distance in meters, and E at `p`.

        E is the irradiance on a surface at `p` that faces the light, without shadows.
        """
        mitsuba, drjit, light = self.mitsuba, self.drjit, self.light
        if isinstance(light, DirectionalLight):
            back = -unit(np.asarray(light.direction, dtype=np.float64))
            toward = drjit.opaque(mitsuba.Vector3f, back.tolist())
            return toward, mitsuba.Float(drjit.inf), self._color(light.irradiance)
        axis = unit(np.subtract(light.target, light.position, dtype=np.float64))
        offset = drjit.opaque(mitsuba.Point3f, list(map(float, light.position))) - p
        squared = drjit.maximum(drjit.squared_norm(offset), 1e-8)
        toward = offset * drjit.rsqrt(squared)
        cosine = -drjit.dot(toward, drjit.opaque(mitsuba.Vector3f, axis.tolist()))
        half = drjit.opaque(mitsuba.Float, light.angle / 2)
        falloff = drjit.clip((half - drjit.safe_acos(cosine)) / (PENUMBRA * half), 0, 1)
        return toward, drjit.sqrt(squared), self._color(light.intensity) * (falloff / squared)

    def sample_distance(
        self, o: Any, d: Any, near: Any, far: Any, falloff: Any, one: Any
    ) -> tuple[Any, Any]:
        """Sample a point of a line at which a medium may scatter this light.

        For a spot light, equal angles seen from the light are equally probable (Kulla & Fajardo
        2012, "Importance sampling techniques for path tracing in participating media"). For a
        directional light, the density falls off exponentially.

        Parameters
        ----------
        o, d : Point3f, Vector3f
            Origin and direction of the line.
        near, far : Float
            Ends of the line, in meters along it.
        falloff : Float
            Rate of the exponential density, m⁻¹.
        one : Float
            Random number in [0, 1).

        Returns
        -------
        at : Float
            Meters along the line.
        density : Float
            Probability density, m⁻¹.
        """
        mitsuba, drjit, light = self.mitsuba, self.drjit, self.light
        if isinstance(light, DirectionalLight):
            rate = drjit.maximum(falloff, LEAST_FALLOFF / drjit.maximum(far - near, 1e-6))
            whole = 1 - drjit.exp(-rate * (far - near))
            past = -drjit.log(1 - one * whole) / rate
            return near + past, rate * drjit.exp(-rate * past) / whole
        offset = drjit.opaque(mitsuba.Point3f, list(map(float, light.position))) - o
        middle = drjit.dot(offset, d)
        height = drjit.maximum(drjit.norm(offset - d * middle), 1e-4)
        low, high = drjit.atan((near - middle) / height), drjit.atan((far - middle) / height)
        past = height * drjit.tan(low + one * (high - low))
        return middle + past, height / ((high - low) * (height * height + past * past))

    def _color(self, values: Any) -> Any:
        return self.mitsuba.Color3f(
            self.drjit.opaque(self.mitsuba.Vector3f, [float(v) for v in values])
        )


@dataclass(frozen=True, eq=False)
class TracedEnvironment:
    """The radiance seen where no surface is: that of an environment light, or a mere background.

    Parameters
    ----------
    mitsuba, drjit : module
    lights : bool
        Whether it lights the scene; False for a background, and for a black environment.
    mean : tuple of float
        Mean radiance over all directions.
    constant : Color3f or None
        The radiance, if it is equal in all directions.
    texture : Texture2f or None
        The map of the radiance otherwise.
    emitter : mitsuba.Emitter or None
        Samples directions in proportion to the radiance of the map.
    """

    mitsuba: Any
    drjit: Any
    lights: bool
    mean: tuple[float, ...]
    constant: Any
    texture: Any = None
    emitter: Any = None

    @classmethod
    def build(cls, mitsuba: Any, drjit: Any, scene: Scene) -> TracedEnvironment:
        """Upload the environment light of `scene`, or its background."""
        light = scene.environment
        if light is None:
            return cls._of_color(mitsuba, drjit, scene.background, False)
        if not isinstance(light.radiance, Texture):
            return cls._of_color(mitsuba, drjit, light.radiance, any(light.radiance))
        texels = light.texels.astype(np.float32)
        # Longitude wraps: each edge gets a column of the opposite edge.
        wide = np.concatenate([texels[:, -1:], texels, texels[:, :1]], axis=1)
        texture = mitsuba.Texture2f(
            mitsuba.TensorXf(wide),
            filter_mode=drjit.FilterMode.Linear,
            wrap_mode=drjit.WrapMode.Clamp,
            use_accel=False,
        )
        mean = mean_radiance(light.texels)
        emitter = _direction_sampler(mitsuba, texels) if texels.any() else None
        lights = emitter is not None
        return cls(mitsuba, drjit, lights, tuple(mean.tolist()), None, texture, emitter)

    @classmethod
    def _of_color(cls, mitsuba: Any, drjit: Any, color: RGB, lights: bool) -> TracedEnvironment:
        value = [float(part) for part in color]
        constant = mitsuba.Color3f(drjit.opaque(mitsuba.Vector3f, value))
        return cls(mitsuba, drjit, lights, tuple(value), constant)

    def radiance(self, d: Any) -> Any:
        """Return the radiance from the unit direction `d`, Color3f; bilinear in the map."""
        if self.constant is not None:
            return self.constant
        drjit, mitsuba = self.drjit, self.mitsuba
        rows, columns = self.texture.shape[0], self.texture.shape[1] - 2
        across = 0.5 + drjit.atan2(d.x, -d.z) / (2 * math.pi)
        u = (across * columns + 1) / (columns + 2)
        v = drjit.safe_acos(d.y) / math.pi
        v = drjit.clip(v, 0.5 / rows, 1 - 0.5 / rows)
        return mitsuba.Color3f(*self.texture.eval(mitsuba.Point2f(u, v))[:3])

    def sample_direction(
        self, si: Any, own: Any, density: Callable[[Any], Any], one: Any, two: Any
    ) -> tuple[Any, Any]:
        """Sample a direction in which to look for light.

        Half of the directions are sampled by radiance if that varies. The others are `own`.

        Parameters
        ----------
        si : SurfaceInteraction3f
            Where light is looked for.
        own : Vector3f
            A direction that the caller sampled by the material.
        density : callable
            Probability density, sr⁻¹, with which the caller samples a direction.
        one, two : Float, Point2f
            Random numbers in [0, 1).

        Returns
        -------
        direction : Vector3f
        density : Float
            Probability density of the direction, sr⁻¹.
        """
        if self.emitter is None:
            return own, density(own)
        drjit = self.drjit
        sample, _ = self.emitter.sample_direction(si, two)
        d = drjit.select(one < 0.5, own, sample.d)
        sample.d = d
        return d, 0.5 * (density(d) + self.emitter.pdf_direction(si, sample))


def _direction_sampler(mitsuba: Any, texels: Array) -> Any:
    """Return a Mitsuba emitter that samples directions in proportion to the radiance of a map.

    Mitsuba's maps have rows at equal steps from straight up to straight down, both included. Their
    columns are as wide as those of a scene, but begin at −z, which is the middle of the maps of a
    scene. With 2H + 1 rows for H, and an odd multiple of the columns, the emitter's map has all
    middles of texels and all places between two of them. It is thus the same bilinear function.
    The emitter only gives probabilities; `TracedEnvironment.radiance` gives the radiance.
    """
    height, width = texels.shape[:2]
    rows = max(2 * height, LEAST_SIDE)
    columns = width * (LEAST_SIDE // width + 1 if width < LEAST_SIDE else 1)
    nodes = bilinear(
        np.asarray(texels, dtype=np.float64),
        np.arange(rows + 1) / rows,
        ((np.arange(columns) + 0.5) / columns + 0.5) % 1,
    )
    bitmap = mitsuba.Bitmap(np.ascontiguousarray(nodes, dtype=np.float32))
    return mitsuba.load_dict({"type": "envmap", "bitmap": bitmap})

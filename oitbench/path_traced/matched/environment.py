"""Light of the environment that nothing hides: irradiance, mean radiance and mirrored radiance."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from oitbench.path_traced.optics.reflection import schlick
from oitbench.path_traced.trace.hits import Hit
from oitbench.path_traced.trace.lights import TracedEnvironment
from oitbench.scene import EnvironmentLight
from oitbench.scene.environment import cosine_weight, even_points, mean_radiance, weighted_means

LOBE_SAMPLES = 512
"""Directions by which the integral over a microfacet lobe is computed."""


class OpenEnvironment:
    """The integrals of the environment light of a scene, without occlusion and random numbers.

    Parameters
    ----------
    mitsuba, drjit : module
    light : EnvironmentLight or None
    traced : TracedEnvironment
        The same light.

    Attributes
    ----------
    lights : bool
        Whether there is any light.
    mean : Color3f
        Mean radiance over all directions; zero without light.
    radiance : callable
        Maps a unit direction to the radiance that is seen in it, or to that of the background.

    Notes
    -----
    The irradiance is interpolated in the table that OpenGL has, too; its error is below 0.1 % for
    maps whose features span some degrees. The lobe is sampled by its visible normals, at
    `LOBE_SAMPLES` points that are the same everywhere. Where the map has a bright patch of ten
    degrees, its error stays below 3 %.
    """

    def __init__(
        self, mitsuba: Any, drjit: Any, light: EnvironmentLight | None, traced: TracedEnvironment
    ) -> None:
        self._mitsuba, self._drjit = mitsuba, drjit
        self.radiance = traced.radiance
        self.lights = light is not None and traced.lights
        self.mean = mitsuba.Color3f(0)
        if not self.lights or light is None:
            return
        mean = mean_radiance(light.texels).tolist()
        self.mean = mitsuba.Color3f(drjit.opaque(mitsuba.Vector3f, mean))
        table = (math.pi * weighted_means(light.texels, cosine_weight)).astype(np.float32)
        # Longitude wraps: the first column repeats behind the last one.
        wide = np.concatenate([table, table[:, :1]], axis=1)
        self._table = mitsuba.Texture2f(
            mitsuba.TensorXf(np.ascontiguousarray(wide)),
            filter_mode=drjit.FilterMode.Linear,
            wrap_mode=drjit.WrapMode.Clamp,
            use_accel=False,
        )
        points = even_points(LOBE_SAMPLES).T.astype(np.float32)
        self._points = [mitsuba.Float(np.ascontiguousarray(axis)) for axis in points]

    def irradiance(self, n: Any) -> Any:
        """Return the irradiance of a surface with the unit normal `n`, Color3f."""
        drjit, mitsuba = self._drjit, self._mitsuba
        rows, columns = self._table.shape[:2]
        across = drjit.atan2(n.x, -n.z) / (2 * math.pi)
        across = across - drjit.floor(across)
        u = (across * (columns - 1) + 0.5) / columns
        v = (drjit.safe_acos(n.y) / math.pi * (rows - 1) + 0.5) / rows
        return mitsuba.Color3f(*self._table.eval(mitsuba.Point2f(u, v))[:3])

    def mirrored(self, hit: Hit, active: Any) -> Any:
        """Return the radiance that the microfacet lobe at `hit` reflects to the eye, Color3f.

        It is ∫ f(l, v) L(l) (n·l) dl with the lobe of `optics.reflection.microfacets`, and F times
        the radiance from the mirror direction at roughness 0. Sampled by the visible normals h
        (Heitz 2018), the integral is the mean of F(h·v) G₂/G₁ L(l).
        """
        drjit, mitsuba, layer = self._drjit, self._mitsuba, hit.layer
        v, frame = hit.si.wi, mitsuba.Frame3f(hit.n)
        local = frame.to_local(v)
        local.z = drjit.maximum(local.z, 1e-4)
        local = drjit.normalize(local)
        a = drjit.square(layer.roughness)
        kind = mitsuba.MicrofacetType.GGX
        facets = mitsuba.MicrofacetDistribution(kind, drjit.maximum(a, 1e-4), True)
        a2, nv = a * a, local.z
        sv = drjit.sqrt(nv * nv * (1 - a2) + a2)
        glossy = active & (layer.reflectance > 0) & (a > 0)

        def step(index: Any, total: Any, active: Any) -> tuple[Any, Any, Any]:
            two = (drjit.gather(mitsuba.Float, points, index, active) for points in self._points)
            h, _ = facets.sample(local, mitsuba.Point2f(*two))
            h = mitsuba.Vector3f(h)
            cosine = drjit.dot(local, h)
            out = 2 * cosine * h - local
            nl = drjit.maximum(out.z, 0)
            sl = drjit.sqrt(nl * nl * (1 - a2) + a2)
            masking = nl * (nv + sv) / drjit.maximum(nl * sv + nv * sl, 1e-8)
            weight = masking * schlick(drjit, layer.reflectance, cosine)
            light = self.radiance(drjit.normalize(frame.to_world(out)))
            total = total + drjit.select(out.z > 0, weight * light, 0)
            return index + 1, total, active & (index + 1 < LOBE_SAMPLES)

        state = mitsuba.UInt32(0), mitsuba.Color3f(0), glossy
        rough = drjit.while_loop(state, lambda *v: v[2], step)[1] / LOBE_SAMPLES
        mirror = 2 * drjit.dot(hit.n, v) * hit.n - v
        sharp = layer.fresnel * self.radiance(mirror)
        return drjit.select(a > 0, drjit.select(glossy, rough, 0), sharp)

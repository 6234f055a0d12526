# mypy: allow-subclassing-any
"""A film: the surface that covers, transmits and glows, as plugins for Mitsuba.

A film of coverage α and transmission t passes τ = 1 − α + αt straight on and adds α·L, seen from
either side. Mitsuba's own `mask` knows no colored transmission, its `area` light only one side and
no opacity, so a BSDF and an emitter written here stand for one film. Neither draws a random
number: layer upon layer, the path tracer's answer is free of noise.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from oitbench.path_traced.export.view import View
from oitbench.path_traced.trace.reflection import schlick
from oitbench.scene import Array

LIGHT = "vertex_light"
"""Mesh attribute: α·L, or the factor on it where a texture gives α·L."""
ABSORPTION = "face_absorption"
"""Mesh attribute: α(1 − T(1 − albedo)), or without α where a texture gives it.

Constant on each triangle: interpolated between equal vertices, 1 would come out as 0.99999998, and
what is very bright would shine through what is opaque.
"""
COVERAGE = "face_coverage"
"""Mesh attribute: α, or 1 where a texture gives it."""
REFLECTANCE = "face_reflectance"
"""Mesh attribute: F₀."""


@dataclass(frozen=True)
class FilteredTexture:
    """A mip pyramid as one Mitsuba texture, looked up by the rule of `oitbench.texturing`.

    The levels lie below one another. Clamping to the outermost texel centers keeps the bilinear
    lookup inside its level, so no border is needed.

    Parameters
    ----------
    mitsuba, drjit : module
        With a variant set.
    pyramid : sequence of array, shape (h, w, 4)
        From `premultiplied_pyramid`; both sides are powers of two.
    view : View
        Whose sub-pixels are projected onto the surface: rays that went through a film carry no
        differentials, but as they are straight, the camera gives them.
    """

    mitsuba: Any
    drjit: Any
    atlas: Any
    size: tuple[int, int]
    levels: int
    view: View

    @classmethod
    def build(
        cls, mitsuba: Any, drjit: Any, pyramid: Sequence[Array], view: View
    ) -> FilteredTexture:
        """Upload `pyramid`."""
        height, width = pyramid[0].shape[:2]
        rows = sum(len(level) for level in pyramid)
        texels = np.zeros((rows, width, 4), dtype=np.float32)
        row = 0
        for level in pyramid:
            texels[row : row + len(level), : level.shape[1]] = level
            row += len(level)
        atlas = mitsuba.Texture2f(
            mitsuba.TensorXf(texels),
            filter_mode=drjit.FilterMode.Linear,
            wrap_mode=drjit.WrapMode.Clamp,
            use_accel=False,
        )
        return cls(mitsuba, drjit, atlas, (width, height), len(pyramid), view)

    def __call__(self, si: Any) -> Any:
        """Return [α·L red, green, blue, α] at the interaction `si`."""
        drjit = self.drjit
        lod = self.level_of_detail(si)
        lower = drjit.floor(lod)
        fine = self._level(si.uv, lower)
        coarse = self._level(si.uv, drjit.minimum(lower + 1, self.levels - 1))
        part = lod - lower
        return [a + part * (b - a) for a, b in zip(fine, coarse, strict=True)]

    def level_of_detail(self, si: Any) -> Any:
        """Return the mip level at which a sub-pixel covers one texel."""
        drjit, mitsuba = self.drjit, self.mitsuba
        camera = self.view.camera
        right, up, back = (mitsuba.Vector3f(*map(float, axis)) for axis in camera.axes)
        offset = si.p - mitsuba.Point3f(*map(float, camera.position))
        distance = -drjit.dot(offset, back)
        # At unit distance along the view axis; its derivative by the film position is right or up.
        forward = offset / distance
        facing = drjit.dot(si.n, forward)
        facing = drjit.select(drjit.abs(facing) < 1e-6, 1e-6, facing)
        squared = []
        for axis, step in zip((right, up), self.view.step, strict=True):
            on_plane = axis - forward * (drjit.dot(si.n, axis) / facing)
            squared.append(self._texels_squared(si, on_plane * (distance * step)))
        widest = drjit.maximum(drjit.maximum(squared[0], squared[1]), 1e-20)
        return drjit.clip(0.5 * drjit.log2(widest), 0.0, float(self.levels - 1))

    def _texels_squared(self, si: Any, step: Any) -> Any:
        """Return the squared length in texels of `step`, a vector in the triangle's plane."""
        drjit = self.drjit
        uu, vv = drjit.dot(si.dp_du, si.dp_du), drjit.dot(si.dp_dv, si.dp_dv)
        uv = drjit.dot(si.dp_du, si.dp_dv)
        u, v = drjit.dot(si.dp_du, step), drjit.dot(si.dp_dv, step)
        determinant = uu * vv - uv * uv
        scale = drjit.select(determinant > 0, 1 / drjit.maximum(determinant, 1e-30), 0.0)
        du = (vv * u - uv * v) * scale * self.size[0]
        dv = (uu * v - uv * u) * scale * self.size[1]
        return du * du + dv * dv

    def _level(self, uv: Any, level: Any) -> Any:
        drjit = self.drjit
        width, height = self.size
        shrink = drjit.exp2(-level)
        wide = drjit.maximum(width * shrink, 1.0)
        tall = drjit.maximum(height * shrink, 1.0)
        # Rows above: a geometric sum while the height halves, then one row for each level.
        above = 2 * (height - tall) + drjit.maximum(level - math.log2(height), 0.0)
        x = drjit.clip(uv.x * wide, 0.5, wide - 0.5)
        y = above + drjit.clip((1 - uv.y) * tall, 0.5, tall - 0.5)
        rows, columns = self.atlas.shape[:2]
        return self.atlas.eval(self.mitsuba.Point2f(x / columns, y / rows))


@dataclass(frozen=True)
class Film:
    """What a BSDF and an emitter of one film share.

    Parameters
    ----------
    mitsuba, drjit : module
        With a variant set.
    view : View
        For the far plane, beyond which nothing is drawn.
    texture : FilteredTexture, optional
    """

    mitsuba: Any
    drjit: Any
    view: View
    texture: FilteredTexture | None = None

    def transmittance(self, si: Any, active: Any) -> Any:
        """Return τ = 1 − α + αt, with t = T (1 − F)(1 − albedo)."""
        color = self.mitsuba.Color3f
        absorption = color(si.shape.eval_attribute_3(ABSORPTION, si, active))
        coverage = si.shape.eval_attribute_1(COVERAGE, si, active)
        reflectance = si.shape.eval_attribute_1(REFLECTANCE, si, active)
        absorption += schlick(self.drjit, reflectance, abs(si.wi.z)) * (coverage - absorption)
        if self.texture is not None:
            absorption = absorption * self.texture(si)[3]
        return self._within(si, 1 - absorption, color(1))

    def light(self, si: Any, active: Any) -> Any:
        """Return α·L."""
        color = self.mitsuba.Color3f
        light = color(si.shape.eval_attribute_3(LIGHT, si, active))
        if self.texture is not None:
            light = light * color(*self.texture(si)[:3])
        return self._within(si, light, color(0))

    def _within(self, si: Any, value: Any, beyond: Any) -> Any:
        camera = self.view.camera
        if math.isinf(camera.far):
            return value
        back = self.mitsuba.Vector3f(*map(float, camera.axes[2]))
        offset = si.p - self.mitsuba.Point3f(*map(float, camera.position))
        return self.drjit.select(-self.drjit.dot(offset, back) <= camera.far, value, beyond)


def make_bsdf(film: Film) -> Any:
    """Return a Mitsuba BSDF that always goes straight on with weight τ."""
    mitsuba, drjit = film.mitsuba, film.drjit

    base: Any = mitsuba.BSDF

    class Straight(base):
        def __init__(self) -> None:
            super().__init__(mitsuba.Properties("film"))
            sides = mitsuba.BSDFFlags.FrontSide | mitsuba.BSDFFlags.BackSide
            self.m_components = [mitsuba.BSDFFlags.Null | sides]
            self.m_flags = self.m_components[0]

        def sample(self, ctx: Any, si: Any, sample1: Any, sample2: Any, active: Any) -> Any:
            sample = drjit.zeros(mitsuba.BSDFSample3f)
            sample.wo = -si.wi
            sample.pdf = 1
            sample.eta = 1
            sample.sampled_type = mitsuba.UInt32(+mitsuba.BSDFFlags.Null)
            return sample, film.transmittance(si, active)

        def eval(self, ctx: Any, si: Any, wo: Any, active: Any) -> Any:
            return mitsuba.Color3f(0)

        def pdf(self, ctx: Any, si: Any, wo: Any, active: Any) -> Any:
            return mitsuba.Float(0)

        def eval_pdf(self, ctx: Any, si: Any, wo: Any, active: Any) -> Any:
            return mitsuba.Color3f(0), mitsuba.Float(0)

        def eval_null_transmission(self, si: Any, active: Any) -> Any:
            return film.transmittance(si, active)

        def to_string(self) -> str:
            return "Film"

    return Straight()


def make_emitter(film: Film) -> Any:
    """Return a Mitsuba emitter that shows α·L on both sides of its surface.

    It is met by rays and never sampled: films scatter nothing. drjit still records every virtual
    call once, so what is not used returns zeros rather than raising.
    """
    mitsuba, drjit = film.mitsuba, film.drjit

    base: Any = mitsuba.Emitter

    class Glow(base):
        def __init__(self) -> None:
            super().__init__(mitsuba.Properties("glow"))
            self.m_flags = mitsuba.EmitterFlags.Surface

        def eval(self, si: Any, active: Any) -> Any:
            return film.light(si, active)

        def sample_direction(self, it: Any, sample: Any, active: Any) -> Any:
            return drjit.zeros(mitsuba.DirectionSample3f), mitsuba.Color3f(0)

        def pdf_direction(self, it: Any, ds: Any, active: Any) -> Any:
            return mitsuba.Float(0)

        def eval_direction(self, it: Any, ds: Any, active: Any) -> Any:
            return mitsuba.Color3f(0)

        def sample_ray(self, time: Any, s1: Any, s2: Any, s3: Any, active: Any) -> Any:
            return drjit.zeros(mitsuba.Ray3f), mitsuba.Color3f(0)

        def sample_position(self, time: Any, sample: Any, active: Any) -> Any:
            return drjit.zeros(mitsuba.PositionSample3f), mitsuba.Float(0)

        def pdf_position(self, ps: Any, active: Any) -> Any:
            return mitsuba.Float(0)

        def to_string(self) -> str:
            return "Glow"

    return Glow()

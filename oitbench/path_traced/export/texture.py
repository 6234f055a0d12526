"""Filtered textures for drjit arrays, by the rule that OpenGL follows, too."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from oitbench.path_traced.export.view import View
from oitbench.scene import Array


@dataclass(frozen=True)
class FilteredTexture:
    """A mip pyramid in one Mitsuba texture, filtered by the rule of `oitbench.scene.texturing`.

    The levels are stacked below one another. Lookups are clamped to the outermost texel centers of
    a level. Bilinear interpolation thus never reads another level, and no border is needed.

    Parameters
    ----------
    mitsuba, drjit : module
        With a variant set.
    atlas : mitsuba.Texture2f
        All levels, four channels.
    size : (int, int)
        Width and height of level 0 in texels.
    levels : int
    view : View
        Gives the footprint of a sub-pixel on the surface. Rays that have passed a film carry no
        differentials, but all rays here are straight, so the camera determines the footprint.
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
        """Upload a pyramid.

        Parameters
        ----------
        mitsuba, drjit : module
            With a variant set.
        pyramid : sequence of array, shape (h, w, 4)
            From `premultiplied_pyramid`; both sides are powers of two.
        view : View
        """
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
        """Return the mip level at which one texel is as large as a sub-pixel."""
        drjit, mitsuba = self.drjit, self.mitsuba
        camera = self.view.camera
        right, up, back = (mitsuba.Vector3f(*map(float, axis)) for axis in camera.axes)
        offset = si.p - mitsuba.Point3f(*map(float, camera.position))
        distance = -drjit.dot(offset, back)
        # At unit distance along the view axis. Its derivative by the film position is right or up.
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

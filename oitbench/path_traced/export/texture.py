"""Filtered textures for drjit arrays, by the rule that OpenGL follows, too."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from oitbench.path_traced.export.view import View
from oitbench.scene import Array


@dataclass(frozen=True)
class FilteredTextures:
    """Mip pyramids in one list of texels, filtered by the rule of `oitbench.scene.texturing`.

    A list serves any number of textures of any size, where a Mitsuba texture for each of them would
    make the kernel longer.

    Parameters
    ----------
    mitsuba, drjit : module
        With a variant set.
    texels : Float or array
        Four channels of each texel; texture by texture, level by level, row by row. In scalar
        variants, an array of shape (n, 4).
    tables : dict of str to UInt32 or array
        By the number of a texture: `width` and `height` of its level 0, and `levels`. `first`, the
        first texel, has `most_levels` entries for each texture.
    most_levels : int
    view : View
        Gives the footprint of a sub-pixel on the surface. Rays that have passed a film carry no
        differentials, but all rays here are straight, so the camera determines the footprint.
    """

    mitsuba: Any
    drjit: Any
    texels: Any
    tables: dict[str, Any]
    most_levels: int
    view: View

    @classmethod
    def build(
        cls, mitsuba: Any, drjit: Any, pyramids: Sequence[Sequence[Array]], view: View
    ) -> FilteredTextures:
        """Upload pyramids.

        Parameters
        ----------
        mitsuba, drjit : module
            With a variant set.
        pyramids : sequence of sequence of array, shape (h, w, 4)
            From `premultiplied_pyramid`; all sides are powers of two.
        view : View
        """
        levels = np.array([len(pyramid) for pyramid in pyramids])
        counts = np.zeros((len(pyramids), levels.max()), dtype=np.int64)
        for number, pyramid in enumerate(pyramids):
            counts[number, : len(pyramid)] = [image.size // 4 for image in pyramid]
        first = np.cumsum(counts) - counts.ravel()
        sizes = np.array([pyramid[0].shape[:2] for pyramid in pyramids])
        tables: dict[str, Any] = {
            "width": sizes[:, 1], "height": sizes[:, 0], "levels": levels, "first": first
        }  # fmt: skip
        texels = np.concatenate([image.reshape(-1, 4) for one in pyramids for image in one])
        found: Any = texels
        if not mitsuba.variant().startswith("scalar"):
            found = mitsuba.Float(texels.ravel())
            tables = {
                name: mitsuba.UInt32(values.astype(np.uint32)) for name, values in tables.items()
            }
        return cls(mitsuba, drjit, found, tables, int(levels.max()), view)

    def __call__(self, si: Any, number: Any, active: Any) -> Any:
        """Return [α·L red, green, blue, α] of a texture at the interaction `si`.

        Parameters
        ----------
        si : SurfaceInteraction3f
        number : UInt32
            Number of the texture in `build`.
        active : Bool
        """
        drjit, mitsuba = self.drjit, self.mitsuba
        last = self._entry("levels", number, active) - 1
        lod = drjit.minimum(self.level_of_detail(si, number, active), mitsuba.Float(last))
        lower = drjit.floor(lod)
        fine = self._level(si.uv, number, mitsuba.UInt32(lower), active)
        upper = drjit.minimum(mitsuba.UInt32(lower) + 1, last)
        coarse = self._level(si.uv, number, upper, active)
        part = lod - lower
        return [a + part * (b - a) for a, b in zip(fine, coarse, strict=True)]

    def factors(self, si: Any, number: Any, active: Any) -> list[Any]:
        """Return the factors on α·L (three) and α of the texture `number` − 1; one for number 0."""
        has = active & (number > 0)
        if isinstance(self.texels, np.ndarray) and not has:
            return [1.0] * 4
        select = self.drjit.select
        found = self(si, select(has, number - 1, self.mitsuba.UInt32(0)), has)
        return [select(has, part, self.mitsuba.Float(1)) for part in found]

    def level_of_detail(self, si: Any, number: Any, active: Any) -> Any:
        """Return the mip level at which one texel is as large as a sub-pixel, at least 0."""
        drjit, mitsuba = self.drjit, self.mitsuba
        camera = self.view.camera
        right, up, back = (mitsuba.Vector3f(*map(float, axis)) for axis in camera.axes)
        offset = si.p - mitsuba.Point3f(*map(float, camera.position))
        distance = -drjit.dot(offset, back)
        # At unit distance along the view axis. Its derivative by the film position is right or up.
        forward = -back if camera.orthographic else offset / distance
        facing = drjit.dot(si.n, forward)
        facing = drjit.select(drjit.abs(facing) < 1e-6, 1e-6, facing)
        shown = 1.0 if camera.orthographic else distance
        size = [mitsuba.Float(self._entry(name, number, active)) for name in ("width", "height")]
        squared = []
        for axis, step in zip((right, up), self.view.step, strict=True):
            on_plane = axis - forward * (drjit.dot(si.n, axis) / facing)
            squared.append(self._texels_squared(si, size, on_plane * (shown * step)))
        widest = drjit.maximum(drjit.maximum(squared[0], squared[1]), 1e-20)
        return drjit.maximum(0.5 * drjit.log2(widest), 0.0)

    def _texels_squared(self, si: Any, size: Sequence[Any], step: Any) -> Any:
        """Return the squared length in texels of `step`, a vector in the triangle's plane."""
        drjit = self.drjit
        uu, vv = drjit.dot(si.dp_du, si.dp_du), drjit.dot(si.dp_dv, si.dp_dv)
        uv = drjit.dot(si.dp_du, si.dp_dv)
        u, v = drjit.dot(si.dp_du, step), drjit.dot(si.dp_dv, step)
        determinant = uu * vv - uv * uv
        scale = drjit.select(determinant > 0, 1 / drjit.maximum(determinant, 1e-30), 0.0)
        du = (vv * u - uv * v) * scale * size[0]
        dv = (uu * v - uv * u) * scale * size[1]
        return du * du + dv * dv

    def _level(self, uv: Any, number: Any, level: Any, active: Any) -> list[Any]:
        """Interpolate between the four nearest texels of a level; edges repeat."""
        drjit, mitsuba = self.drjit, self.mitsuba
        first = self._entry("first", number * self.most_levels + level, active)
        wide, tall = (
            drjit.maximum(self._entry(name, number, active) >> level, mitsuba.UInt32(1))
            for name in ("width", "height")
        )
        x = drjit.clip(uv.x * wide, 0.5, mitsuba.Float(wide) - 0.5) - 0.5
        y = drjit.clip((1 - uv.y) * tall, 0.5, mitsuba.Float(tall) - 0.5) - 0.5
        left, top = mitsuba.UInt32(x), mitsuba.UInt32(y)
        right, bottom = drjit.minimum(left + 1, wide - 1), drjit.minimum(top + 1, tall - 1)
        across, down = x - left, y - top

        def row(number: Any) -> list[Any]:
            start = first + number * wide
            pair = (self._texel(start + left, active), self._texel(start + right, active))
            return [a + across * (b - a) for a, b in zip(*pair, strict=True)]

        return [a + down * (b - a) for a, b in zip(row(top), row(bottom), strict=True)]

    def _texel(self, index: Any, active: Any) -> list[Any]:
        if isinstance(self.texels, np.ndarray):
            return [float(part) for part in self.texels[index]]
        return list(self.drjit.gather(self.mitsuba.Vector4f, self.texels, index, active))

    def _entry(self, name: str, index: Any, active: Any) -> Any:
        table = self.tables[name]
        if isinstance(table, np.ndarray):
            return int(table[index])
        return self.drjit.gather(self.mitsuba.UInt32, table, index, active)

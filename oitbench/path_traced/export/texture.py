"""Filtered textures for drjit arrays, by the rule that OpenGL follows, too."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from oitbench.path_traced.export.view import View
from oitbench.scene import WRAPS, Wrap
from oitbench.scene.texturing import Images, premultiplied_pyramid


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
        first texel, has `most_levels` entries for each texture. `wrap_u` and `wrap_v`, places in
        `WRAPS`, are there only if a texture is not clamped.
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
        cls, mitsuba: Any, drjit: Any, images: Iterable[Images], view: View
    ) -> FilteredTextures:
        """Upload the pyramids of `images`, which are numbered from 0."""
        images = list(images)
        pyramids = [premultiplied_pyramid(one) for one in images]
        levels = np.array([len(pyramid) for pyramid in pyramids])
        counts = np.zeros((len(pyramids), levels.max()), dtype=np.int64)
        for number, pyramid in enumerate(pyramids):
            counts[number, : len(pyramid)] = [image.size // 4 for image in pyramid]
        first = np.cumsum(counts) - counts.ravel()
        sizes = np.array([pyramid[0].shape[:2] for pyramid in pyramids])
        tables: dict[str, Any] = {
            "width": sizes[:, 1], "height": sizes[:, 0], "levels": levels, "first": first
        }  # fmt: skip
        if any(one.wrap != (Wrap.CLAMP, Wrap.CLAMP) for one in images):
            wraps = np.array([[WRAPS.index(wrap) for wrap in one.wrap] for one in images])
            tables |= {"wrap_u": wraps[:, 0], "wrap_v": wraps[:, 1]}
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
        """Interpolate between the four nearest texels of a level."""
        drjit, mitsuba = self.drjit, self.mitsuba
        first = self._entry("first", number * self.most_levels + level, active)
        wide, tall = (
            drjit.maximum(self._entry(name, number, active) >> level, mitsuba.UInt32(1))
            for name in ("width", "height")
        )
        u, v = uv.x, uv.y
        around = [mitsuba.Bool(False)] * 2
        if "wrap_u" in self.tables:
            u, around[0] = self._folded(u, self._entry("wrap_u", number, active))
            v, around[1] = self._folded(v, self._entry("wrap_v", number, active))
        left, right, across = self._neighbors(u, wide, around[0])
        top, bottom, down = self._neighbors(1 - v, tall, around[1])

        def row(number: Any) -> list[Any]:
            start = first + number * wide
            pair = (self._texel(start + left, active), self._texel(start + right, active))
            return [a + across * (b - a) for a, b in zip(*pair, strict=True)]

        return [a + down * (b - a) for a, b in zip(row(top), row(bottom), strict=True)]

    def _folded(self, place: Any, wrap: Any) -> tuple[Any, Any]:
        """Return a coordinate within [0, 1] unless it is clamped, and whether it wraps around."""
        drjit, select = self.drjit, self.drjit.select
        around = wrap == WRAPS.index(Wrap.REPEAT)
        mirrored = drjit.abs(place - 2 * drjit.round(place / 2))
        place = select(wrap == WRAPS.index(Wrap.MIRROR), mirrored, place)
        return select(around, place - drjit.floor(place), place), around

    def _neighbors(self, place: Any, count: Any, around: Any) -> tuple[Any, Any, Any]:
        """Return the two texels around a place on an axis, and the part of the second one."""
        drjit, mitsuba = self.drjit, self.mitsuba
        at = drjit.clip(place * count, 0.5, mitsuba.Float(count) - 0.5) - 0.5
        low = mitsuba.UInt32(at)
        high = drjit.minimum(low + 1, count - 1)
        if "wrap_u" not in self.tables:
            return low, high, at - low
        select = drjit.select
        free = place * count - 0.5
        start = drjit.floor(free)
        first = mitsuba.UInt32(select(start < 0, start + count, start))
        after = (first + 1) % count
        return (
            select(around, first, low), select(around, after, high),
            select(around, free - start, at - low),
        )  # fmt: skip

    def _texel(self, index: Any, active: Any) -> list[Any]:
        if isinstance(self.texels, np.ndarray):
            return [float(part) for part in self.texels[index]]
        return list(self.drjit.gather(self.mitsuba.Vector4f, self.texels, index, active))

    def _entry(self, name: str, index: Any, active: Any) -> Any:
        table = self.tables[name]
        if isinstance(table, np.ndarray):
            return int(table[index])
        return self.drjit.gather(self.mitsuba.UInt32, table, index, active)

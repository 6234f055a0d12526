"""All surfaces of an exported scene as tables, so that a ray's hit looks its material up.

Whatever the number of shapes, each face has a number of its own: its place in the list of all faces
in the order of `exporter.layout`.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from oitbench.path_traced.export.film import LIGHT, FilteredTexture
from oitbench.path_traced.export.view import View
from oitbench.path_traced.photons.map import absorption
from oitbench.path_traced.trace.reflection import interface_roughness, schlick, spread
from oitbench.scene import BLACK, Object, Texture

STEP = 6e-7
"""Advance beyond a hit, relative to the magnitudes added up there: five float32 roundings."""


NOWHERE = 0xFFFFFFFF
"""The number of no face."""


@dataclass
class Line:
    """A straight part of a path: where it starts, its direction, and how far it is explored.

    Parameters
    ----------
    o : Point3f
    d : Vector3f
    along : Float
        Metres that lie behind.
    known : UInt32
        Face that was met last and is not met again.
    """

    o: Any
    d: Any
    along: Any
    known: Any

    def where(self, drjit: Any, mask: Any, other: Line) -> Line:
        """Return this line where `mask` is set, `other` elsewhere."""
        return Line(
            drjit.select(mask, self.o, other.o),
            drjit.select(mask, self.d, other.d),
            drjit.select(mask, self.along, other.along),
            drjit.select(mask, self.known, other.known),
        )


@dataclass
class Hit:
    """What a line meets next.

    Parameters
    ----------
    valid : Bool
    fresh : Bool
        Whether it is a surface that counts: drawn, and not met before.
    at : Float
        Distance along the line; infinite where nothing is.
    beyond : Float
        From where to go on.
    face : UInt32
    si : SurfaceInteraction3f
    n : Vector3f
        Shading normal, on the side that the line comes from.
    outside : Bool
        Whether that is the front.
    layer : Layer
    """

    valid: Any
    fresh: Any
    at: Any
    beyond: Any
    face: Any
    si: Any
    n: Any
    outside: Any
    layer: Layer


@dataclass
class Layer:
    """The material at a hit; `light` is α·L, `fresnel` F(cos) and `spread` the radius of slopes."""

    coverage: Any
    light: Any
    transmission: Any
    albedo: Any
    fresnel: Any
    reflectance: Any
    roughness: Any
    isotropic: Any
    refracts: Any
    index: Any
    facets: Any
    absorption: Any
    spread: Any

    @property
    def passing(self) -> Any:
        """T (1 − F)(1 − albedo): what passes where the surface is."""
        return self.transmission * (1 - self.albedo) * (1 - self.fresnel)


@dataclass(frozen=True, eq=False)
class Surfaces:
    """Tables by object, and which object each face belongs to.

    Parameters
    ----------
    mitsuba, drjit : module
        With an LLVM or CUDA variant set.
    exported : mitsuba.Scene
    view : View
        For the far plane, beyond which nothing is drawn.
    offsets : UInt32
        Number of the first face of each shape, by Mitsuba's number of the shape.
    rows : UInt32
        Number of the object of each face.
    tables : mapping
        Values by object.
    textures : list of (int, FilteredTexture)
        By the number of the shape in the layout.
    has : frozenset of str
        Columns that are not zero everywhere; the others cost nothing.
    """

    mitsuba: Any
    drjit: Any
    exported: Any
    view: View
    offsets: Any
    rows: Any
    tables: dict[str, Any]
    textures: list[tuple[int, FilteredTexture]]
    has: frozenset[str]

    @classmethod
    def build(
        cls,
        mitsuba: Any,
        drjit: Any,
        view: View,
        exported: Any,
        layout: Mapping[str, Sequence[Object]],
        textures: Mapping[str, FilteredTexture],
    ) -> Surfaces:
        """Upload the objects of `layout`, which are listed by the id of their shape."""
        numbers = {
            shape.id(): int(
                drjit.reinterpret_array(mitsuba.UInt32, mitsuba.ShapePtr(shape)).numpy()[0]
            )
            for shape in exported.shapes()
        }
        offsets = np.zeros(max(numbers.values()) + 1, dtype=np.uint32)
        faces: list[int] = []
        columns: list[dict[str, npt.NDArray[np.float32]]] = []
        for place, (name, group) in enumerate(layout.items()):
            offsets[numbers[name]] = sum(faces)
            for item in group:
                faces.append(len(item.mesh.triangles))
                columns.append(_column(item, place if name in textures else -1))
        tables = {name: np.stack([column[name] for column in columns]) for name in columns[0]}
        return cls(
            mitsuba,
            drjit,
            exported,
            view,
            mitsuba.UInt32(offsets),
            mitsuba.UInt32(np.repeat(np.arange(len(faces), dtype=np.uint32), faces)),
            {name: mitsuba.Float(values.ravel()) for name, values in tables.items()},
            [(place, textures[name]) for place, name in enumerate(layout) if name in textures],
            frozenset(name for name, values in tables.items() if values.any()),
        )

    def meet(self, line: Line, active: Any, limit: Any = math.inf) -> Hit:
        """Return what `line` meets next, before `limit` metres along it."""
        mitsuba, drjit = self.mitsuba, self.drjit
        start = mitsuba.Ray3f(line.o + line.d * line.along, line.d)
        start.maxt = drjit.maximum(limit - line.along, 0)
        ahead = self.exported.ray_intersect_preliminary(start, False, active)
        valid = active & ahead.is_valid()
        si = ahead.compute_surface_interaction(start, active=valid)
        si.wi = -line.d
        shape = drjit.reinterpret_array(mitsuba.UInt32, ahead.shape)
        face = drjit.gather(mitsuba.UInt32, self.offsets, shape, valid) + ahead.prim_index
        reach = line.along + si.t
        beyond = reach + STEP * (reach + drjit.max(drjit.abs(si.p)))
        outside = drjit.dot(si.n, line.d) < 0
        n = mitsuba.Vector3f(si.sh_frame.n)
        n = drjit.select(drjit.dot(n, line.d) < 0, n, -n)
        # A line crosses a triangle once; a second hit is the first one's rounding error.
        fresh = valid & (face != line.known) & self._drawn(si)
        layer = self._layer(si, face, -drjit.dot(n, line.d), fresh)
        at = drjit.select(valid, reach, drjit.inf)
        return Hit(valid, fresh, at, beyond, face, si, n, outside, layer)

    def onward(self, line: Line, hit: Hit, active: Any) -> Line:
        """Return `line` explored up to beyond `hit`, where `active`."""
        drjit = self.drjit
        return Line(line.o, line.d, hit.beyond, hit.face).where(drjit, active, line)

    def turned(self, line: Line, hit: Hit, d: Any, active: Any) -> Line:
        """Return the line from `hit` in the direction `d` where `active`, `line` elsewhere."""
        drjit = self.drjit
        start = STEP * drjit.max(drjit.abs(hit.si.p))
        return Line(hit.si.p, d, start, hit.face).where(drjit, active, line)

    def _drawn(self, si: Any) -> Any:
        camera = self.view.camera
        if math.isinf(camera.far):
            return self.mitsuba.Bool(True)
        back = self.mitsuba.Vector3f(*map(float, camera.axes[2]))
        offset = si.p - self.mitsuba.Point3f(*map(float, camera.position))
        return -self.drjit.dot(offset, back) <= camera.far

    def _layer(self, si: Any, face: Any, cosine: Any, active: Any) -> Layer:
        row = self.drjit.gather(self.mitsuba.UInt32, self.rows, face, active)
        color, number = self._color, self._number
        coverage, light = self._picture(si, row, active)
        reflectance = number("reflectance", row, active)
        fresnel = self.mitsuba.Float(0)
        if "reflectance" in self.has:
            fresnel = schlick(self.drjit, reflectance, cosine)
        return Layer(
            coverage=coverage,
            light=light,
            transmission=color("transmission", row, active),
            albedo=color("albedo", row, active),
            fresnel=fresnel,
            reflectance=reflectance,
            roughness=number("roughness", row, active),
            isotropic=number("isotropic", row, active) > 0,
            refracts=number("refracts", row, active) > 0,
            index=number("index", row, active),
            facets=number("facets", row, active),
            absorption=color("absorption", row, active),
            spread=number("spread", row, active),
        )

    def _picture(self, si: Any, row: Any, active: Any) -> tuple[Any, Any]:
        """Return coverage and α·L."""
        drjit, mitsuba = self.drjit, self.mitsuba
        coverage = self._number("coverage", row, active)
        light = mitsuba.Color3f(0)
        if "glows" in self.has:
            light = mitsuba.Color3f(si.shape.eval_attribute_3(LIGHT, si, active))
        for place, texture in self.textures:
            here = active & (self._number("texture", row, active) == place)
            found = texture(si)
            coverage = drjit.select(here, found[3], coverage)
            light = drjit.select(here, light * mitsuba.Color3f(*found[:3]), light)
        return coverage, light

    def _number(self, name: str, row: Any, active: Any) -> Any:
        if name not in self.has:
            return self.mitsuba.Float(0)
        return self.drjit.gather(self.mitsuba.Float, self.tables[name], row, active)

    def _color(self, name: str, row: Any, active: Any) -> Any:
        if name not in self.has:
            return self.mitsuba.Color3f(0)
        return self.drjit.gather(self.mitsuba.Color3f, self.tables[name], row, active)


def _column(item: Object, texture: int) -> dict[str, npt.NDArray[np.float32]]:
    """Return all values of an object; what does not apply to it is zero."""
    material = item.material
    refracts = material.refracts and not material.opaque
    sheet = not refracts and not material.opaque
    values: dict[str, Any] = {
        "coverage": 0 if isinstance(material.coverage, Texture) else material.coverage,
        "glows": isinstance(material.emission, Texture) or material.emission != BLACK,
        "transmission": material.transmission,
        "albedo": material.albedo,
        "reflectance": 0 if material.isotropic else material.reflectance,
        "roughness": material.roughness,
        "isotropic": material.isotropic,
        "refracts": refracts,
        "index": material.index,
        "facets": interface_roughness(material) if refracts else 0,
        "absorption": absorption(item) if refracts else BLACK,
        "spread": spread(material.collimation) if sheet else 0,
        "texture": texture,
    }
    return {name: np.asarray(value, dtype=np.float32) for name, value in values.items()}

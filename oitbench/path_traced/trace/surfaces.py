"""All surfaces of an exported scene as tables, in which a hit looks up its material.

Each face has a number, whatever shape it belongs to: its place in the list of all faces, in the
order of `export.shapes.layout`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from oitbench.path_traced.export.film import LIGHT
from oitbench.path_traced.export.scene import ExportedScene
from oitbench.path_traced.export.variation import Variation
from oitbench.path_traced.export.view import View
from oitbench.path_traced.optics.advance import NO_FACE, STEP
from oitbench.path_traced.optics.materials import interface_roughness, spread
from oitbench.path_traced.optics.reflection import schlick
from oitbench.path_traced.optics.solids import Solids
from oitbench.path_traced.trace.hits import Hit, Layer, Line
from oitbench.scene import BLACK, Object, Texture
from oitbench.scene.texturing import constant, constants_of

VARIED = "varied "
"""Prefix of the columns of `Variation` among those of `Surfaces`."""


@dataclass(frozen=True, eq=False)
class Surfaces:
    """Tables of materials by object, and the object of each face.

    Parameters
    ----------
    mitsuba, drjit : module
        With an LLVM or CUDA variant set.
    content : mitsuba.Scene
    view : View
        For the far plane, beyond which nothing is drawn.
    offsets : UInt32
        Number of the first face of each shape, by Mitsuba's number of the shape.
    rows : UInt32
        Number of the object of each face.
    tables : dict of str to Float
        One column of values for each property, by object.
    variation : Variation
        What varies over surfaces.
    solids : Solids or None
        None if solids are sheets to the lines.
    has : frozenset of str
        Columns that are not zero everywhere. The others are not looked up and cost nothing.
    """

    mitsuba: Any
    drjit: Any
    content: Any
    view: View
    offsets: Any
    rows: Any
    tables: dict[str, Any]
    variation: Variation
    solids: Solids | None
    has: frozenset[str]

    @classmethod
    def build(
        cls, mitsuba: Any, drjit: Any, view: View, exported: ExportedScene, refracts: bool = True
    ) -> Surfaces:
        """Upload the materials of all objects.

        `refracts` says whether lines keep account of the solids that they run inside of.
        """
        numbers = {
            shape.id(): int(
                drjit.reinterpret_array(mitsuba.UInt32, mitsuba.ShapePtr(shape)).numpy()[0]
            )
            for shape in exported.content.shapes()
        }
        offsets = np.zeros(max(numbers.values()) + 1, dtype=np.uint32)
        faces: list[int] = []
        columns: list[dict[str, npt.NDArray[np.float32]]] = []
        first = 0
        for name, group in exported.groups.items():
            offsets[numbers[name]] = first
            for item in group:
                faces.append(len(item.mesh.triangles))
                columns.append(_values(item, exported.variation))
                first += faces[-1]
        tables = {name: np.stack([column[name] for column in columns]) for name in columns[0]}
        solids = None
        if refracts and tables["refracts"].any():
            eye = np.asarray(view.camera.position, dtype=np.float64)
            solids, ranks = Solids.build(mitsuba, drjit, exported.scene, eye)
            items = [item for group in exported.groups.values() for item in group]
            tables["rank"] = np.asarray([ranks.get(item.name, 0) for item in items], np.float32)
        return cls(
            mitsuba,
            drjit,
            exported.content,
            view,
            mitsuba.UInt32(offsets),
            mitsuba.UInt32(np.repeat(np.arange(len(faces), dtype=np.uint32), faces)),
            {name: mitsuba.Float(values.ravel()) for name, values in tables.items()},
            exported.variation,
            solids,
            frozenset(name for name, values in tables.items() if values.any()),
        )

    def intersect(
        self, line: Line, active: Any, limit: Any = math.inf, to_light: bool = False
    ) -> Hit:
        """Return the next hit of `line`, before `limit` meters along it.

        `to_light` says that light comes along the line, from its end: it passes culled surfaces at
        whose backs it arrives, not those whose backs the line meets.
        """
        mitsuba, drjit = self.mitsuba, self.drjit
        start = mitsuba.Ray3f(line.o + line.d * line.along, line.d)
        start.maxt = drjit.maximum(limit - line.along, 0)
        ahead = self.content.ray_intersect_preliminary(start, False, active)
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
        # A line crosses a triangle once. A second hit is a rounding error of the first one.
        fresh = valid & (face != line.known) & self.view.before_far_plane(mitsuba, drjit, si.p)
        row = drjit.gather(mitsuba.UInt32, self.rows, face, fresh)
        inner, before, behind, index = mitsuba.Bool(False), line.nest, line.nest, None
        if self.solids is not None:
            rank = mitsuba.UInt32(self._number("rank", row, fresh))
            met = self.solids.meet(line.nest, rank, outside, fresh & (rank > 0))
            inner, before, behind, index = met.inner, met.before, met.behind, met.index
            fresh = fresh & ~met.hidden
        front = outside ^ to_light
        layer = self._layer(si, row, -drjit.dot(n, line.d), front, inner & outside, index, fresh)
        if self.has & {VARIED + "threshold", VARIED + "culled"}:
            # Where a surface is not drawn, there is none.
            fresh = fresh & (layer.coverage > 0)
        at = drjit.select(valid, reach, drjit.inf)
        return Hit(valid, fresh, at, beyond, face, si, n, outside, inner, before, behind, layer)

    def eye_line(self, o: Any, d: Any) -> Line:
        """Return the line from `o`, which is at the camera, in the unit direction `d`."""
        mitsuba = self.mitsuba
        o, d = mitsuba.Point3f(o), mitsuba.Vector3f(d)
        nest = () if self.solids is None else self.solids.start()
        return Line(o, d, mitsuba.Float(0), mitsuba.UInt32(NO_FACE), nest)

    def passing(self, line: Line, end: Any, active: Any) -> Any:
        """Return the part of light that solids leave on `line` up to `end` meters along it.

        Color3f; one where `end` is infinite, and outside of solids.
        """
        if self.solids is None:
            return self.mitsuba.Color3f(1)
        there = active & (end < self.drjit.inf)
        return self.solids.passing(line.nest, end - line.along, there)

    def _layer(
        self,
        si: Any,
        row: Any,
        cosine: Any,
        front: Any,
        nested: Any,
        relative: Any,
        active: Any,
    ) -> Layer:
        """Return the material of object `row`, which sight or light meets from its `front`.

        Where `nested`, the surface lies inside of a solid, and F₀ follows from the index
        `relative`.
        """
        drjit = self.drjit
        color, number = self._color, self._number
        columns = self.variation.columns
        numbers = {name: number(VARIED + name, row, active) for name in columns}
        factors = self.variation.at(si, numbers, front, active)
        coverage, light = number("coverage", row, active), self._light(si, active)
        transmission, albedo = (color(one, row, active) for one in ("transmission", "albedo"))
        roughness = number("roughness", row, active)
        reflectance = number("reflectance", row, active)
        refracts = number("refracts", row, active) > 0
        index = number("index", row, active)
        if relative is not None:
            index = drjit.select(refracts, relative, index)
            within = drjit.square((index - 1) / (index + 1))
            reflectance = drjit.select(refracts & nested, within, reflectance)
        fresnel = self.mitsuba.Float(0)
        if "reflectance" in self.has:
            fresnel = schlick(self.drjit, reflectance, cosine)
        return Layer(
            coverage=_times(coverage, factors.coverage),
            light=_times(light, factors.light),
            transmission=_times(transmission, factors.transmission),
            albedo=_times(albedo, factors.albedo),
            fresnel=fresnel,
            reflectance=reflectance,
            roughness=_times(roughness, factors.roughness),
            opaque=number("opaque", row, active) > 0,
            isotropic=number("isotropic", row, active) > 0,
            unshadowed=number("unshadowed", row, active) > 0,
            refracts=refracts,
            index=index,
            facets=number("facets", row, active),
            spread=number("spread", row, active),
        )

    def _light(self, si: Any, active: Any) -> Any:
        """Return α·L without factors."""
        if "glows" not in self.has:
            return self.mitsuba.Color3f(0)
        return self.mitsuba.Color3f(si.shape.eval_attribute_3(LIGHT, si, active))

    def _number(self, name: str, row: Any, active: Any) -> Any:
        if name not in self.has:
            return self.mitsuba.Float(0)
        return self.drjit.gather(self.mitsuba.Float, self.tables[name], row, active)

    def _color(self, name: str, row: Any, active: Any) -> Any:
        if name not in self.has:
            return self.mitsuba.Color3f(0)
        return self.drjit.gather(self.mitsuba.Color3f, self.tables[name], row, active)


def _times(value: Any, factor: Any) -> Any:
    return value if factor is None else value * factor


def _values(item: Object, variation: Variation) -> dict[str, npt.NDArray[np.float32]]:
    """Return the properties of an object by column; properties that do not apply are zero."""
    material = item.material
    refracts = item.refracts
    values: dict[str, Any] = {
        "coverage": constants_of(material)[1],
        "glows": isinstance(material.emission, Texture) or material.emission != BLACK,
        "transmission": constant(material.transmission),
        "albedo": constant(material.albedo),
        "reflectance": 0 if material.isotropic else material.reflectance,
        "roughness": 1 if isinstance(material.roughness, Texture) else material.roughness,
        "opaque": item.opaque,
        "isotropic": material.isotropic,
        "unshadowed": not item.receives_shadows,
        "refracts": refracts,
        "index": material.index,
        "facets": interface_roughness(material) if refracts else 0,
        "spread": 0 if item.opaque else spread(material.collimation),
    }
    values |= {VARIED + name: number for name, number in variation.row(material).items()}
    return {name: np.asarray(value, dtype=np.float32) for name, value in values.items()}

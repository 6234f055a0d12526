"""What textures and vertices multiply the properties of a surface by; for drjit arrays."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

from oitbench.path_traced.export.texture import FilteredTextures
from oitbench.scene import Material, Object
from oitbench.scene.texturing import SLOTS, image_key, images_of, threshold_of

VERTEX = "vertex_"
"""Prefix of the mesh attributes that hold factors of vertices."""
ALMOST_ONE = 1 - 1e-6
"""Larger factors of vertices are one: interpolation between equal vertices rounds."""


@dataclass
class Factors:
    """Factors at a hit; None where a property of the whole scene has none.

    Parameters
    ----------
    light : Color3f or None
        On α·L.
    coverage, roughness : Float or None
        That of coverage is 0 or 1 where there is a cutoff, and 0 on the backs of culled surfaces.
    albedo, transmission : Color3f or None
    """

    light: Any = None
    coverage: Any = None
    albedo: Any = None
    transmission: Any = None
    roughness: Any = None


@dataclass(frozen=True)
class Variation:
    """What varies over the surfaces of a scene.

    Parameters
    ----------
    mitsuba, drjit : module
        With a variant set.
    textures : FilteredTextures or None
        None if no object has a texture.
    numbers : mapping of hashable to int
        Place of each texture in `textures`, by `image_key`.
    columns : tuple of str
        Names of the numbers that `row` gives for a material: places of textures plus one for each
        slot of `oitbench.scene.texturing.SLOTS` that occurs, `threshold` and `culled`.
    vertex : frozenset of str
        Properties with factors of vertices: see `oitbench.scene.Mesh.factors`.
    """

    mitsuba: Any
    drjit: Any
    textures: FilteredTextures | None
    numbers: Mapping[Any, int]
    columns: tuple[str, ...]
    vertex: frozenset[str]

    @classmethod
    def of(
        cls,
        mitsuba: Any,
        drjit: Any,
        objects: Iterable[Object],
        textures: FilteredTextures | None,
        numbers: Mapping[Any, int],
    ) -> Variation:
        """Return what varies in a scene of these objects."""
        objects = list(objects)
        materials = [item.material for item in objects]
        slots = {slot for material in materials for slot in images_of(material)}
        columns = [slot for slot in SLOTS if slot in slots]
        columns += ["threshold"] if any(one.cutoff is not None for one in materials) else []
        columns += ["culled"] if any(one.culled for one in materials) else []
        vertex = frozenset(name for item in objects for name in item.mesh.factors)
        return cls(mitsuba, drjit, textures, numbers, tuple(columns), vertex)

    def row(self, material: Material) -> dict[str, float]:
        """Return the numbers of a material by column."""
        images = images_of(material)
        found = {slot: 1.0 + self.numbers[image_key(one)] for slot, one in images.items()}
        found |= {"threshold": threshold_of(material), "culled": float(material.culled)}
        return {column: found.get(column, 0.0) for column in self.columns}

    @property
    def inner(self) -> bool:
        """Whether albedo or transmission vary."""
        names = {"albedo", "transmission"}
        return not names.isdisjoint(self.columns) or not names.isdisjoint(self.vertex)

    def at(self, si: Any, numbers: Mapping[str, Any], front: Any, active: Any) -> Factors:
        """Return the factors at `si`.

        Parameters
        ----------
        si : SurfaceInteraction3f
        numbers : mapping of str to Float
            Of the material, by column.
        front : Bool
            Whether sight, or light on its way from its source, meets the front.
        active : Bool
        """
        mitsuba, drjit, select = self.mitsuba, self.drjit, self.drjit.select
        color, found = mitsuba.Color3f, Factors()
        for slot in SLOTS:
            if slot not in self.columns:
                continue
            assert self.textures is not None
            *three, alpha = self.textures.factors(si, mitsuba.UInt32(numbers[slot]), active)
            if slot == "emission":
                found.light, found.coverage = color(*three), alpha
                continue
            value = color(*three) / drjit.maximum(alpha, 1e-30)
            setattr(found, slot, value[0] if slot == "roughness" else value)
        for name in ("albedo", "transmission"):
            if name in self.vertex:
                value = color(si.shape.eval_attribute_3(VERTEX + name, si, active))
                value = select(value > ALMOST_ONE, 1, value)
                setattr(found, name, _product(getattr(found, name), value))
        if "coverage" in self.vertex:
            part = si.shape.eval_attribute_1(VERTEX + "coverage", si, active)
            part = select(part > ALMOST_ONE, 1, part)
            found.coverage, found.light = (
                _product(found.coverage, part),
                _product(found.light, part),
            )
        if "threshold" in self.columns:
            alpha = mitsuba.Float(1) if found.coverage is None else found.coverage
            threshold = numbers["threshold"]
            kept, cut = alpha >= threshold, threshold > 0
            whole = select(kept, 1 / drjit.maximum(alpha, 1e-30), 0)
            found.light = _product(found.light, select(cut, whole, 1))
            found.coverage = select(cut, select(kept, mitsuba.Float(1), 0), alpha)
        if "culled" in self.columns:
            seen = select((numbers["culled"] > 0) & (front ^ True), mitsuba.Float(0), 1)
            found.coverage, found.light = (
                _product(found.coverage, seen),
                _product(found.light, seen),
            )
        return found


def _product(one: Any, other: Any) -> Any:
    return other if one is None else one * other

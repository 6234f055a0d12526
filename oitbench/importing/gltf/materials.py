"""Materials of a glTF file; CONVENTIONS.md has the table of what becomes of each property."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from oitbench.importing.gltf import extensions as known
from oitbench.importing.gltf.document import Document
from oitbench.importing.gltf.primitives import Geometry
from oitbench.importing.gltf.schema import Material as Described
from oitbench.importing.gltf.schema import TextureInfo
from oitbench.importing.gltf.textures import Placement, Textures
from oitbench.importing.limits import short
from oitbench.importing.looks import (
    METAL,
    VERTICES,
    collimation_of,
    color,
    divided,
    transmission_of,
)
from oitbench.importing.pictures import Bytes, fractions, linear
from oitbench.importing.shapes import encloses
from oitbench.importing.values import Canvas, Values, same_size
from oitbench.modeling.glass import transmission as through_solid
from oitbench.scene import BLACK, RGB, Floats, Material, Mesh, Object, Texture

_COLOR, _RED, _GREEN, _BLUE, _ALPHA = (
    slice(0, 3), slice(0, 1), slice(1, 2), slice(2, 3), slice(3, 4),
)  # fmt: skip
_EVEN = "solids have the mean of their textures and of their colors at vertices"
_OPEN = (
    "a volume is a thin sheet if it has a cutoff, or if no closed mesh with normals outwards"
    " bounds it"
)
_MEANS = "textures that lie otherwise than the base color, or reflectance, are replaced by means"


@dataclass(frozen=True, eq=False)
class Look:
    """A material before the mesh is known.

    Parameters
    ----------
    material : Material
        As a thin sheet.
    placement : Placement, optional
        Of its textures.
    unlit : bool
        Vertex colors are then factors on its emission, else on albedo and transmission.
    alpha : bool
        Whether alpha of vertices counts.
    inside : Volume, optional
        If light passes a surface that may bound a solid.
    base_albedo, base_transmission : RGB
        Means over the surface, before attenuation: those of a solid.
    hidden : bool
        Whether nothing is seen of it on any mesh.
    """

    material: Material
    placement: Placement | None
    unlit: bool
    alpha: bool
    inside: known.Volume | None
    base_albedo: RGB = BLACK
    base_transmission: RGB = BLACK
    hidden: bool = False

    @property
    def passes(self) -> bool:
        """Whether light passes the covered part."""
        return self.material.transmission != BLACK


class Materials:
    """The looks of a document's materials, each read once."""

    def __init__(self, document: Document) -> None:
        self._document, self._textures = document, Textures(document)
        self._looks: dict[tuple[int | None, Geometry | None], Look] = {}

    def look(self, index: int | None, geometry: Geometry | None) -> Look:
        """Return the look of a material, None for the default one, on a geometry.

        Only metals depend on the geometry: on the colors of its vertices.
        """
        described = Described()
        if index is not None:
            described = self._document.part("material", self._document.gltf.materials, index)
        colors = None if geometry is None else geometry.colors
        metallic = described.pbr_metallic_roughness.metallic_factor > 0
        if not metallic or known.UNLIT in described.extensions:
            colors = None
        key = index, None if colors is None else geometry
        if key not in self._looks:
            name = described.name or ("the default" if index is None else f"material {index}")
            reader = _Reader(self._document, self._textures, described, name)
            self._looks[key] = reader.look(None if colors is None else colors[:, :3])
        return self._looks[key]

    def fitted(self, look: Look, mesh: Mesh, name: str, scale: float) -> Object | None:
        """Return the object of a look and a mesh; None if nothing of it can be seen.

        It is a solid if the look has an inside and the mesh is closed. The mesh is `scale` times as
        large as in the file.
        """
        if look.hidden:
            return None
        material = look.material
        if look.inside is not None:
            if material.cutoff is None and encloses(mesh):
                return self._solid(look, look.inside, mesh, name)
            self._document.notes.add(_OPEN, name)
            material, mesh = _sheet(material, look.inside, mesh, scale)
        coverage = material.coverage
        if mesh.coverage is None and not isinstance(coverage, Texture):
            if material.cutoff is not None:
                coverage = float(coverage >= material.cutoff)
                material = replace(material, coverage=coverage, cutoff=None, binary_coverage=False)
            if coverage <= 0:
                return None
        return Object(name, mesh, material)

    def _solid(self, look: Look, inside: known.Volume, mesh: Mesh, name: str) -> Object:
        """Return a solid, which has one tint."""
        material = look.material
        albedo, tint = look.base_albedo, look.base_transmission
        if mesh.albedo is not None or mesh.transmission is not None:
            mean = np.asarray(mesh.albedo).mean(axis=0)
            albedo, tint = color(np.multiply(albedo, mean)), color(np.multiply(tint, mean))
            mesh = replace(mesh, albedo=None, transmission=None)
            self._document.notes.add(_EVEN, name)
        if isinstance(material.albedo, Texture) or isinstance(material.transmission, Texture):
            self._document.notes.add(_EVEN, name)
        if inside.attenuation_distance is not None:
            passed = through_solid(inside.attenuation_color, inside.attenuation_distance, mesh)
            tint = color(np.multiply(tint, passed))
        solid = replace(material, albedo=albedo, transmission=tint, solid=True, culled=False)
        return Object(name, mesh, solid)


class _Reader:
    """Reads one material."""

    def __init__(
        self, document: Document, textures: Textures, described: Described, name: str
    ) -> None:
        self._notes, self._budget = document.notes, document.budget
        self._textures, self._described, self._name = textures, described, name
        self._placement: Placement | None = None
        for unknown in sorted(described.extensions.keys() - known.KNOWN):
            self._notes.add(f"{short(unknown)} is ignored")
        if described.normal_texture is not None:
            self._notes.add("normal maps are ignored", name)
        if described.occlusion_texture is not None:
            self._notes.add("baked occlusion is ignored; oitbench has effects for it", name)

    def look(self, colors: Floats | None) -> Look:
        """Return the look of the material; `colors` are those of vertices, shape (n, 3)."""
        described, pbr = self._described, self._described.pbr_metallic_roughness
        factor = np.array(pbr.base_color_factor, dtype=np.float32)
        base = factor[:3] * self._texels(pbr.base_color_texture, _COLOR, linear)
        alpha = factor[3:] * self._texels(pbr.base_color_texture, _ALPHA, fractions)
        material = Material(
            coverage=1.0 if self._mode == "OPAQUE" else self._canvas().scalar(alpha),
            cutoff=min(described.alpha_cutoff, 1.0) if self._mode == "MASK" else None,
            culled=not described.double_sided,
        )
        if known.UNLIT in described.extensions:
            material = replace(
                material, emission=self._canvas().color(base), specular=0.0, roughness=1.0
            )
            return self._finished(material, None, unlit=True)
        return self._lit(material, base, colors)

    def _lit(self, material: Material, base: Values, colors: Floats | None) -> Look:
        described, pbr = self._described, self._described.pbr_metallic_roughness
        map_ = pbr.metallic_roughness_texture
        metallic = np.float32(pbr.metallic_factor) * self._texels(map_, _BLUE, fractions)
        roughness = np.float32(pbr.roughness_factor) * self._texels(map_, _GREEN, fractions)
        passing = self._passing()
        base, metallic, passing = same_size(base, metallic, passing)
        found = divided(base, metallic, passing, colors)
        passes = bool((passing * (1 - metallic)).any())
        index = self._index()
        specular = self._specular(index, metallic, found.mirrored)
        if colors is not None and metallic.any() and (colors != colors[0]).any():
            self._notes.add(VERTICES, self._name)
        if found.colored_metal:
            self._notes.add(METAL, self._name)
        mean = float(roughness.mean())
        material = replace(
            material,
            albedo=self._canvas().color(found.albedo),
            emission=self._emission(),
            roughness=self._canvas().scalar(roughness),
            index=index,
            specular=specular,
            binary_coverage=material.cutoff is not None and not passes,
        )
        if not passes:
            return self._finished(material, None)
        if roughness.size > 1 and index > 1:
            self._notes.add("the blur of glass follows its mean roughness", self._name)
        tint = transmission_of(found.passed, found.albedo)
        glass = replace(
            material,
            transmission=self._canvas().color(tint),
            collimation=collimation_of(mean, index),
        )
        return self._finished(glass, described.extension(known.VOLUME, known.Volume))

    def _finished(
        self, material: Material, volume: known.Volume | None, unlit: bool = False
    ) -> Look:
        inside = volume if volume is not None and volume.thickness_factor > 0 else None
        albedo, tint = _mean(material.albedo), _mean(material.transmission)
        if inside is not None and inside.thickness_texture is not None:
            self._notes.add("maps of thickness are ignored; the factor counts", self._name)
        hidden = self._mode == "MASK" and self._described.alpha_cutoff > 1
        alpha = self._mode != "OPAQUE"
        return Look(material, self._placement, unlit, alpha, inside, albedo, tint, hidden)

    @property
    def _mode(self) -> str:
        """The mode of alpha; every coverage reaches a cutoff of 0."""
        reached = self._described.alpha_mode == "MASK" and self._described.alpha_cutoff == 0
        return "OPAQUE" if reached else self._described.alpha_mode

    def _index(self) -> float:
        found = self._described.extension(known.IOR, known.Ior)
        index = 1.5 if found is None else found.ior
        if 0 < index < 1:
            self._notes.add("refractive indices below 1 count as 1", self._name)
        return max(index, 1.0)

    def _specular(self, index: float, metallic: Values, mirrored: float) -> float | None:
        """Return F₀, or None if it is that of the index."""
        ior = self._described.extension(known.IOR, known.Ior)
        everything = ior is not None and ior.ior == 0
        found = self._described.extension(known.SPECULAR, known.Specular)
        if found is None and not metallic.any() and not everything:
            return None
        reflectance = 1.0 if everything else Material(index=index).reflectance
        if found is not None:
            strength = found.specular_factor
            tint = np.array(found.specular_color_factor)
            alpha = self._textures.layer(found.specular_texture)
            colors = self._textures.layer(found.specular_color_texture)
            if alpha is not None:
                strength *= float(fractions(alpha.pixels[..., 3]).mean())
            if colors is not None:
                tint = tint * linear(colors.pixels[..., :3]).mean(axis=(0, 1))
            if alpha is not None or colors is not None:
                self._notes.add(_MEANS, self._name)
            if tint.min() < tint.max():
                self._notes.add("colored reflectance is gray: the mean of its channels", self._name)
            reflectance = strength * min(reflectance * float(tint.mean()), 1.0)
        if metallic.min() < metallic.max():
            self._notes.add(_MEANS, self._name)
        part = float(metallic.mean())
        return float(np.clip((1 - part) * reflectance + part * mirrored, 0, 1))

    def _passing(self) -> Values:
        """Return the part of the light that passes, before metallic parts are taken off."""
        found = self._described.extension(known.TRANSMISSION, known.Transmission)
        if found is None:
            return np.zeros(1, dtype=np.float32)
        texels = self._texels(found.transmission_texture, _RED, fractions)
        return np.asarray(np.float32(found.transmission_factor) * texels)

    def _emission(self) -> tuple[float, float, float] | Texture:
        described = self._described
        strength = described.extension(known.EMISSIVE_STRENGTH, known.EmissiveStrength)
        factor = np.array(described.emissive_factor, dtype=np.float32)
        if strength is not None:
            factor = factor * np.float32(strength.emissive_strength)
        if factor.any():
            factor = factor * self._texels(described.emissive_texture, _COLOR, linear)
        return self._canvas().color(factor)

    def _texels(
        self, info: TextureInfo | None, channels: slice, decode: Callable[[Bytes], Values]
    ) -> Values:
        """Return linear values of a texture that lies as the others of the material.

        They are ones if there is no texture, and means if it lies otherwise.
        """
        layer = self._textures.layer(info)
        if layer is None:
            return np.ones(1, dtype=np.float32)
        if self._placement is None:
            self._placement = layer.placement
        values = decode(layer.pixels[..., channels])
        if layer.placement == self._placement:
            return values
        self._notes.add(_MEANS, self._name)
        return np.asarray(values.mean(axis=(0, 1), dtype=np.float64), dtype=np.float32)

    def _canvas(self) -> Canvas:
        return Canvas(self._budget, None if self._placement is None else self._placement.wrap)


def _sheet(
    material: Material, inside: known.Volume, mesh: Mesh, scale: float
) -> tuple[Material, Mesh]:
    """Return a thin sheet that absorbs as much as a volume of its thickness."""
    if inside.attenuation_distance is None:
        return material, mesh
    with np.errstate(all="ignore"):
        depth = np.float64(inside.thickness_factor * scale) / inside.attenuation_distance
        passed = np.nan_to_num(np.array(inside.attenuation_color, dtype=np.float64) ** depth)
    if not isinstance(material.transmission, Texture):
        return replace(material, transmission=color(material.transmission * passed)), mesh
    # A factor of the vertices, as every sheet may have another one.
    before = 1.0 if mesh.transmission is None else mesh.transmission
    factors = np.broadcast_to(before * passed, (len(mesh.positions), 3))
    return material, replace(mesh, transmission=factors.astype(np.float32))


def _mean(value: RGB | Texture) -> RGB:
    if not isinstance(value, Texture):
        return value
    return color(value.texels.reshape(-1, value.texels.shape[-1]).mean(axis=0))

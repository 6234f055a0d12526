"""What is read of extensions of glTF, and which of them are known.

References
----------
Khronos Group, "glTF Extension Registry".
"""

from __future__ import annotations

from typing import Annotated, Literal

from msgspec import Meta, Struct

from oitbench.importing.gltf.schema import (
    Color,
    Extended,
    Fraction,
    Index,
    Light,
    NotNegative,
    Pair,
    Positive,
    TextureInfo,
)

TRANSMISSION = "KHR_materials_transmission"
IOR = "KHR_materials_ior"
VOLUME = "KHR_materials_volume"
SPECULAR = "KHR_materials_specular"
EMISSIVE_STRENGTH = "KHR_materials_emissive_strength"
UNLIT = "KHR_materials_unlit"
TEXTURE_TRANSFORM = "KHR_texture_transform"
LIGHTS = "KHR_lights_punctual"
INSTANCING = "EXT_mesh_gpu_instancing"
QUANTIZATION = "KHR_mesh_quantization"
WEBP = "EXT_texture_webp"
KNOWN = frozenset(
    {
        TRANSMISSION, IOR, VOLUME, SPECULAR, EMISSIVE_STRENGTH, UNLIT, TEXTURE_TRANSFORM, LIGHTS,
        INSTANCING, QUANTIZATION, WEBP,
    }
)  # fmt: skip
"""Extensions that are imported."""
PACKED = frozenset(
    {"KHR_draco_mesh_compression", "EXT_meshopt_compression", "KHR_meshopt_compression"}
)
"""Extensions that compress geometry."""


class Transmission(Struct, rename="camel", frozen=True):
    """The part of the light that passes a surface instead of being scattered by it."""

    transmission_factor: Fraction = 0.0
    transmission_texture: TextureInfo | None = None


class Ior(Struct, rename="camel", frozen=True):
    """The refractive index; 0 reflects everything."""

    ior: NotNegative = 1.5


class Volume(Struct, rename="camel", frozen=True):
    """The inside of a closed mesh, or the thickness of an open one."""

    thickness_factor: NotNegative = 0.0
    thickness_texture: TextureInfo | None = None
    attenuation_distance: Positive | None = None
    attenuation_color: Color = (1.0, 1.0, 1.0)


class Specular(Struct, rename="camel", frozen=True):
    """The strength and color of dielectric reflection."""

    specular_factor: Fraction = 1.0
    specular_texture: TextureInfo | None = None
    specular_color_factor: Light = (1.0, 1.0, 1.0)
    specular_color_texture: TextureInfo | None = None


class EmissiveStrength(Struct, rename="camel", frozen=True):
    """A factor on the emission."""

    emissive_strength: NotNegative = 1.0


class TextureTransform(Struct, rename="camel", frozen=True):
    """An affine map of texture coordinates, in the order scale, rotation, offset."""

    offset: Pair = (0.0, 0.0)
    rotation: float = 0.0
    scale: Pair = (1.0, 1.0)
    tex_coord: Annotated[int, Meta(ge=0, lt=64)] | None = None


class Spot(Struct, rename="camel", frozen=True):
    """The half angles of a spot light, radians."""

    inner_cone_angle: Annotated[float, Meta(ge=0, le=1.5708)] = 0.0
    outer_cone_angle: Annotated[float, Meta(gt=0, le=1.5708)] = 0.7853981633974483


class PunctualLight(Extended, frozen=True, kw_only=True):
    """A light that shines along −z of its node; candela, or lux if directional."""

    type: Literal["directional", "point", "spot"]
    color: Light = (1.0, 1.0, 1.0)
    intensity: NotNegative = 1.0
    range: Positive | None = None
    spot: Spot = Spot()


class PunctualLights(Struct, rename="camel", frozen=True):
    """The lights of a file."""

    lights: list[PunctualLight] = []


class LightOfNode(Struct, rename="camel", frozen=True):
    """The light at a node."""

    light: Index


class Instancing(Struct, rename="camel", frozen=True):
    """Accessors of the translation, rotation and scale of each copy of a node's mesh."""

    attributes: dict[str, Index]


class Webp(Struct, rename="camel", frozen=True):
    """An image in the format WebP."""

    source: Index

"""What is read of a glTF 2.0 document, with types and ranges that decoding checks.

Members that are not named here, such as `extras` and animations, are skipped. Extensions stay text
until they are asked for.

References
----------
Khronos Group 2021, "glTF 2.0 Specification" (version 2.0.1).
"""

from __future__ import annotations

from typing import Annotated, Any, Literal, TypeVar

import msgspec
from msgspec import Meta, Raw, Struct

from oitbench.errors import SceneError

Index = Annotated[int, Meta(ge=0, lt=2**31)]
Size = Annotated[int, Meta(ge=0, lt=2**40)]
Count = Annotated[int, Meta(ge=1, lt=2**40)]
Fraction = Annotated[float, Meta(ge=0, le=1)]
Positive = Annotated[float, Meta(gt=0)]
NotNegative = Annotated[float, Meta(ge=0)]
Pair = tuple[float, float]
Triple = tuple[float, float, float]
Color = tuple[Fraction, Fraction, Fraction]
Light = tuple[NotNegative, NotNegative, NotNegative]
Quad = tuple[float, float, float, float]
Found = TypeVar("Found", bound=Struct)


class Extended(Struct, rename="camel", frozen=True, kw_only=True):
    """A part of the document that may have a name and extensions."""

    name: str = ""
    extensions: dict[str, Raw] = {}

    def extension(self, name: str, kind: type[Found]) -> Found | None:
        """Return an extension, or None if the part does not have it."""
        raw = self.extensions.get(name)
        if raw is None:
            return None
        try:
            return msgspec.json.decode(raw, type=kind)
        except (msgspec.MsgspecError, RecursionError, UnicodeDecodeError) as error:
            raise SceneError(f"{name}: {error}") from error


class Asset(Extended, frozen=True, kw_only=True):
    """The version that the file needs."""

    version: str = ""
    min_version: str = ""


class Buffer(Extended, frozen=True, kw_only=True):
    """Bytes of a file, a data URI, or the binary chunk of a .glb."""

    byte_length: Size
    uri: str | None = None


class BufferView(Extended, frozen=True, kw_only=True):
    """A part of a buffer."""

    buffer: Index
    byte_length: Size
    byte_offset: Size = 0
    byte_stride: Annotated[int, Meta(ge=4, le=252)] | None = None


ComponentType = Literal[5120, 5121, 5122, 5123, 5125, 5126]


class SparseIndices(Extended, frozen=True, kw_only=True):
    """Which elements of an accessor differ."""

    buffer_view: Index
    component_type: Literal[5121, 5123, 5125]
    byte_offset: Size = 0


class SparseValues(Extended, frozen=True, kw_only=True):
    """The values of those elements."""

    buffer_view: Index
    byte_offset: Size = 0


class Sparse(Extended, frozen=True, kw_only=True):
    """Elements of an accessor that differ from its buffer view, or from zero."""

    count: Count
    indices: SparseIndices
    values: SparseValues


class Accessor(Extended, frozen=True, kw_only=True):
    """An array of numbers or vectors in a buffer view; zeros if it has none."""

    component_type: ComponentType
    count: Count
    type: Literal["SCALAR", "VEC2", "VEC3", "VEC4", "MAT2", "MAT3", "MAT4"]
    buffer_view: Index | None = None
    byte_offset: Size = 0
    normalized: bool = False
    sparse: Sparse | None = None


class Primitive(Extended, frozen=True, kw_only=True):
    """Geometry of one material; `attributes` and `indices` are accessors."""

    attributes: dict[str, Index]
    indices: Index | None = None
    material: Index | None = None
    mode: Annotated[int, Meta(ge=0, le=6)] = 4
    targets: list[Any] = []


class Mesh(Extended, frozen=True, kw_only=True):
    """Primitives that are placed together."""

    primitives: list[Primitive]


class Perspective(Extended, frozen=True, kw_only=True):
    """A pinhole camera; `yfov` is the full vertical angle, radians."""

    yfov: Annotated[float, Meta(gt=0, lt=3.14159)]
    znear: Positive
    zfar: Positive | None = None


class Orthographic(Extended, frozen=True, kw_only=True):
    """A parallel projection; `ymag` is half the height of the picture."""

    ymag: float
    znear: NotNegative
    zfar: Positive


class Camera(Extended, frozen=True, kw_only=True):
    """A camera that looks along −z of its node."""

    perspective: Perspective | None = None
    orthographic: Orthographic | None = None


class Node(Extended, frozen=True, kw_only=True):
    """A place in the hierarchy: a matrix, or translation, rotation and scale."""

    children: list[Index] = []
    matrix: Annotated[list[float], Meta(min_length=16, max_length=16)] | None = None
    translation: Triple = (0.0, 0.0, 0.0)
    rotation: Quad = (0.0, 0.0, 0.0, 1.0)
    scale: Triple = (1.0, 1.0, 1.0)
    mesh: Index | None = None
    camera: Index | None = None


class Scene(Extended, frozen=True, kw_only=True):
    """The roots of a hierarchy of nodes."""

    nodes: list[Index] = []


class Image(Extended, frozen=True, kw_only=True):
    """A PNG or JPEG, in a file, a data URI or a buffer view."""

    uri: str | None = None
    buffer_view: Index | None = None


class Sampler(Extended, frozen=True, kw_only=True):
    """How a texture is filtered and continued beyond its edges."""

    mag_filter: int | None = None
    min_filter: int | None = None
    wrap_s: Literal[33071, 33648, 10497] = 10497
    wrap_t: Literal[33071, 33648, 10497] = 10497


class Texture(Extended, frozen=True, kw_only=True):
    """An image with a sampler."""

    source: Index | None = None
    sampler: Index | None = None


class TextureInfo(Extended, frozen=True, kw_only=True):
    """The use of a texture by a material."""

    index: Index
    tex_coord: Annotated[int, Meta(ge=0, lt=64)] = 0


class MetallicRoughness(Extended, frozen=True, kw_only=True):
    """Base color, and how metallic and rough a surface is."""

    base_color_factor: tuple[Fraction, Fraction, Fraction, Fraction] = (1.0, 1.0, 1.0, 1.0)
    base_color_texture: TextureInfo | None = None
    metallic_factor: Fraction = 1.0
    roughness_factor: Fraction = 1.0
    metallic_roughness_texture: TextureInfo | None = None


class Material(Extended, frozen=True, kw_only=True):
    """A material of the core specification."""

    pbr_metallic_roughness: MetallicRoughness = MetallicRoughness()
    normal_texture: TextureInfo | None = None
    occlusion_texture: TextureInfo | None = None
    emissive_texture: TextureInfo | None = None
    emissive_factor: Light = (0.0, 0.0, 0.0)
    alpha_mode: Literal["OPAQUE", "MASK", "BLEND"] = "OPAQUE"
    alpha_cutoff: NotNegative = 0.5
    double_sided: bool = False


class Gltf(Extended, frozen=True, kw_only=True):
    """The whole document."""

    asset: Asset = Asset()
    extensions_used: list[str] = []
    extensions_required: list[str] = []
    scene: Index | None = None
    scenes: list[Scene] = []
    nodes: list[Node] = []
    cameras: list[Camera] = []
    meshes: list[Mesh] = []
    materials: list[Material] = []
    textures: list[Texture] = []
    images: list[Image] = []
    samplers: list[Sampler] = []
    accessors: list[Accessor] = []
    buffer_views: list[BufferView] = []
    buffers: list[Buffer] = []
    animations: list[Any] = []
    skins: list[Any] = []

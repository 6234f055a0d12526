"""Textures of a glTF file: decoded pictures, how they continue, and where they lie on a mesh."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from oitbench.importing.gltf.document import Document
from oitbench.importing.gltf.extensions import (
    TEXTURE_TRANSFORM,
    WEBP,
    TextureTransform,
    Webp,
)
from oitbench.importing.gltf.schema import Sampler, TextureInfo
from oitbench.importing.limits import short
from oitbench.importing.pictures import Bytes, read_picture
from oitbench.scene import Floats, Wrap

_NEAREST = (9728, 9984, 9986)
_WRAPS = {33071: Wrap.CLAMP, 33648: Wrap.MIRROR, 10497: Wrap.REPEAT}


@dataclass(frozen=True)
class Placement:
    """Where a texture lies on a mesh, and how it continues.

    Parameters
    ----------
    set : int
        Number of the set of texture coordinates.
    transform : TextureTransform
    wrap : (Wrap, Wrap)
        Along u and v.
    """

    set: int
    transform: TextureTransform
    wrap: tuple[Wrap, Wrap]

    def uvs(self, coordinates: Floats) -> Floats:
        """Return texture coordinates with v upwards, from those of a file, shape (n, 2)."""
        offset, scale = self.transform.offset, self.transform.scale
        cosine, sine = math.cos(self.transform.rotation), math.sin(self.transform.rotation)
        u, v = coordinates[:, 0] * scale[0], coordinates[:, 1] * scale[1]
        across = cosine * u + sine * v + offset[0]
        down = cosine * v - sine * u + offset[1]
        return np.stack([across, 1 - down], axis=1)


@dataclass(frozen=True, eq=False)
class Layer:
    """A picture on a surface; `pixels` has shape (h, w, 4)."""

    pixels: Bytes
    placement: Placement


class Textures:
    """Reads the textures of a document, each picture once."""

    def __init__(self, document: Document) -> None:
        self._document = document
        self._pictures: dict[int, Bytes] = {}

    def layer(self, info: TextureInfo | None) -> Layer | None:
        """Return a texture; None if there is none, or if its format is not known."""
        if info is None:
            return None
        document = self._document
        gltf = document.gltf
        texture = document.part("texture", gltf.textures, info.index)
        webp = texture.extension(WEBP, Webp)
        source = texture.source if webp is None else webp.source
        if source is None:
            document.notes.add(
                "textures in an unknown format are left out", f"texture {info.index}"
            )
            return None
        if source not in self._pictures:
            self._pictures[source] = self._read(source)
        sampler = Sampler()
        if texture.sampler is not None:
            sampler = document.part("sampler", gltf.samplers, texture.sampler)
        if sampler.mag_filter in _NEAREST or sampler.min_filter in _NEAREST:
            document.notes.add("textures are filtered linearly, not by the nearest texel")
        transform = info.extension(TEXTURE_TRANSFORM, TextureTransform) or TextureTransform()
        chosen = info.tex_coord if transform.tex_coord is None else transform.tex_coord
        wrap = _WRAPS[sampler.wrap_s], _WRAPS[sampler.wrap_t]
        return Layer(self._pictures[source], Placement(chosen, transform, wrap))

    def _read(self, index: int) -> Bytes:
        document = self._document
        image = document.part("image", document.gltf.images, index)
        name = image.name or f"image {index}"
        if image.buffer_view is not None:
            content: bytes | memoryview = document.view(image.buffer_view)[1]
        elif image.uri is not None:
            content = document.folder.read_uri(image.uri)
            name = name if image.uri.startswith("data:") else image.uri
        else:
            document.notes.add("images without data are white", f"image {index}")
            return np.full((1, 1, 4), 255, dtype=np.uint8)
        return read_picture(content, short(name), document.budget)

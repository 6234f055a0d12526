"""Small files that tests write."""

from __future__ import annotations

import io
import json
import struct
import zlib
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from oitbench.importing import Imported, read_scene
from oitbench.scene import Floats, Object

TYPES = {"int8": 5120, "uint8": 5121, "int16": 5122, "uint16": 5123, "uint32": 5125,
         "float32": 5126}  # fmt: skip
SHAPES = {1: "SCALAR", 2: "VEC2", 3: "VEC3", 4: "VEC4", 16: "MAT4"}
CUBE_QUADS = ((0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5))
SIMPLE: dict[str, Any] = {"light": "sun", "environment": "none", "ground": "no"}


def cube() -> tuple[Floats, npt.NDArray[np.int64]]:
    """Return the corners of the cube [−½, ½]³ and its triangles, with normals outwards."""
    corners = np.array([[x, y, z] for z in (0, 1) for y in (0, 1) for x in (0, 1)]) - 0.5
    quads = np.array(CUBE_QUADS)
    return corners, np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])


def png(pixels: npt.ArrayLike) -> bytes:
    """Return the file of a picture, shape (h, w, 3 or 4) or (h, w)."""
    from PIL import Image

    buffer = io.BytesIO()
    Image.fromarray(np.asarray(pixels, dtype=np.uint8)).save(buffer, "PNG")
    return buffer.getvalue()


def picture(width: int, height: int, data: bytes) -> bytes:
    """Return a gray PNG of any stated size."""

    def chunk(kind: bytes, content: bytes) -> bytes:
        sum_ = struct.pack(">I", zlib.crc32(kind + content))
        return struct.pack(">I", len(content)) + kind + content + sum_

    header = struct.pack(">IIBBBBB", width, height, 8, 0, 0, 0, 0)
    return (
        b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(data))
        + chunk(b"IEND", b"")
    )  # fmt: skip


class Gltf:
    """A glTF file that is written part by part."""

    def __init__(self) -> None:
        self.document: dict[str, Any] = {
            "asset": {"version": "2.0"}, "accessors": [], "bufferViews": [], "meshes": [],
            "nodes": [], "materials": [], "textures": [], "images": [], "samplers": [],
        }  # fmt: skip
        self.content = b""

    def view(self, content: bytes, **members: Any) -> int:
        """Append bytes to the buffer; return the number of their view."""
        self.content += b"\0" * (-len(self.content) % 4)
        view = {"buffer": 0, "byteOffset": len(self.content), "byteLength": len(content)}
        self.content += content
        return self.add("bufferViews", {**view, **members})

    def add(self, kind: str, part: dict[str, Any]) -> int:
        self.document.setdefault(kind, []).append(part)
        return len(self.document[kind]) - 1

    def array(self, values: npt.ArrayLike, kind: str = "float32", **members: Any) -> int:
        """Append an array; return the number of its accessor."""
        table = np.asarray(values).astype(kind)
        table = table.reshape(len(table), -1)
        return self.add(
            "accessors",
            {
                "bufferView": self.view(table.tobytes()), "componentType": TYPES[kind],
                "count": len(table), "type": SHAPES[table.shape[1]], **members,
            },
        )  # fmt: skip

    def picture(self, pixels: npt.ArrayLike, **sampler: Any) -> int:
        """Append a texture; return its number."""
        view = self.view(png(pixels))
        image = self.add("images", {"bufferView": view, "mimeType": "image/png"})
        return self.add("textures", {"source": image, "sampler": self.add("samplers", sampler)})

    def mesh(self, attributes: dict[str, int], indices: int | None = None, **members: Any) -> int:
        primitive: dict[str, Any] = {"attributes": attributes, **members}
        if indices is not None:
            primitive["indices"] = indices
        return self.add("meshes", {"primitives": [primitive]})

    def triangle(self, material: dict[str, Any] | None = None, **attributes: int) -> int:
        """Append a node with the triangle (0, 0, 0), (1, 0, 0), (0, 1, 0); return its number."""
        found = {"POSITION": self.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]]), **attributes}
        members = {} if material is None else {"material": self.add("materials", material)}
        return self.add("nodes", {"mesh": self.mesh(found, **members)})

    def solid(self, material: dict[str, Any], closed: bool = True) -> int:
        """Append a node with a cube; return its number."""
        corners, triangles = cube()
        indices = self.array((triangles if closed else triangles[1:]).ravel(), "uint8")
        mesh = self.mesh(
            {"POSITION": self.array(corners)}, indices, material=self.add("materials", material)
        )
        return self.add("nodes", {"mesh": mesh})

    def glb(self) -> bytes:
        """Return the bytes of a .glb file."""
        document = {key: value for key, value in self.document.items() if value != []}
        if self.content:
            document.setdefault("buffers", [{"byteLength": len(self.content)}])
        text = json.dumps(document).encode()
        text += b" " * (-len(text) % 4)
        binary = self.content + b"\0" * (-len(self.content) % 4)
        body = struct.pack("<II", len(text), 0x4E4F534A) + text
        if binary:
            body += struct.pack("<II", len(binary), 0x004E4942) + binary
        return b"glTF" + struct.pack("<II", 2, 12 + len(body)) + body

    def write(self, folder: Path, name: str = "model.glb") -> Path:
        path = folder / name
        path.write_bytes(self.glb())
        return path

    def read(self, folder: Path, **values: Any) -> Imported:
        """Import the file, without surroundings unless asked for."""
        return read_scene(self.write(folder), **{**SIMPLE, **values})

    def one(self, folder: Path, **values: Any) -> Object:
        """Import the file, and return its only object."""
        (item,) = self.read(folder, **values).scene.objects
        return item


def close(found: Any, expected: Any, atol: float = 1e-6) -> None:
    """Assert that two arrays, or what holds one, are equal within rounding."""
    np.testing.assert_allclose(found, expected, rtol=1e-6, atol=atol)


def write(folder: Path, name: str, text: str) -> Path:
    path = folder / name
    path.write_text(text, encoding="utf-8")
    return path

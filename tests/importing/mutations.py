"""Small files of every format, and damaged copies of them."""

from __future__ import annotations

import json
import random
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from tests.importing.files import Gltf, cube, png
from tests.importing.test_polygons import ply

_SPECIAL = (b"\0", b"\xff", b"\x7f", b"\x80", b"-1", b"0", b"1e999", b"nan", b"99999999999", b"/",
            b"..", b"[", b"{", b"null", b'"', b"\n", b" ")  # fmt: skip
_VALUES: tuple[Any, ...] = (
    -1, 0, 1, 2, 7, 255, 65536, 2**31, 2**32, 2**40, 2**63, 1e30, -1e30, 0.5, "x", "", None, True,
    [], {}, [0], [[]], "../x", "data:,", "http://x.org/y",
)  # fmt: skip


def rich_gltf() -> Gltf:
    """Return a file with a bit of everything that is imported."""
    gltf = Gltf()
    corners, triangles = cube()
    image = gltf.picture([[[255, 0, 0, 255], [0, 255, 0, 128]], [[1, 2, 3, 4], [9, 9, 9, 0]]])
    texture = {"index": image, "extensions": {"KHR_texture_transform": {"scale": [2, 2]}}}
    glass: dict[str, Any] = {
        "pbrMetallicRoughness": {"roughnessFactor": 0.2, "metallicFactor": 0},
        "extensions": {
            "KHR_materials_transmission": {"transmissionFactor": 0.9},
            "KHR_materials_volume": {"thicknessFactor": 1, "attenuationDistance": 2},
            "KHR_materials_ior": {"ior": 1.3},
            "KHR_materials_specular": {"specularFactor": 0.5},
        },
    }
    leaf: dict[str, Any] = {
        "pbrMetallicRoughness": {"baseColorTexture": texture, "baseColorFactor": [1, 1, 1, 0.5]},
        "alphaMode": "MASK", "alphaCutoff": 0.3, "emissiveFactor": [1, 1, 1],
        "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": 2}},
    }  # fmt: skip
    blend: dict[str, Any] = {
        "alphaMode": "BLEND",
        "pbrMetallicRoughness": {"baseColorFactor": [1, 0, 0, 0.5]},
    }
    indices = gltf.array(triangles.ravel(), "uint16")
    uvs = gltf.array(corners[:, :2])
    colors = gltf.array(np.full((8, 4), 200), "uint8", normalized=True)
    attributes = {"POSITION": gltf.array(corners), "TEXCOORD_0": uvs, "COLOR_0": colors}
    for number, described in enumerate((glass, leaf, blend)):
        material = gltf.add("materials", described)
        mesh = gltf.mesh(attributes, indices, material=material)
        gltf.add("nodes", {"mesh": mesh, "translation": [2 * number, 0, 0]})
    moved = gltf.array([[0, 2, 0], [0, 4, 0]])
    instancing = {"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": moved}}}
    gltf.document["nodes"][2]["extensions"] = instancing
    sparse = {
        "count": 1,
        "indices": {"bufferView": gltf.view(b"\1"), "componentType": 5121},
        "values": {"bufferView": gltf.view(np.ones(3, "<f4").tobytes())},
    }
    gltf.document["accessors"][attributes["POSITION"]]["sparse"] = sparse
    lens = gltf.add("cameras", {"type": "perspective", "perspective": {"yfov": 1, "znear": 0.1}})
    lamps = {"lights": [{"type": "point", "intensity": 9}, {"type": "spot"}]}
    gltf.document["extensions"] = {"KHR_lights_punctual": lamps}
    for light in (0, 1):
        extension = {"KHR_lights_punctual": {"light": light}}
        gltf.add("nodes", {"camera": lens, "extensions": extension, "translation": [0, 0, 9]})
    gltf.add("nodes", {"children": [0, 1], "rotation": [0, 0, 1, 0], "scale": [-1, 1, 1]})
    gltf.document["scenes"] = [{"nodes": [5, 2, 3, 4]}]
    return gltf


OBJ = """mtllib m.mtl
o thing
v 0 0 0 1 0 0\nv 1 0 0 0 1 0\nv 1 1 0 0 0 1\nv 0 1 0 1 1 1
vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nvn 0 0 1
s 1
usemtl a
f 1/1/1 2/2/1 3/3/1 4/4/1
usemtl b
f -4//1 -3//1 -2//1
f 1 2 3
"""
MTL = """newmtl a\nKd 1 0.5 0\nd 0.5\nmap_Kd -s 2 2 2 -clamp on t.png\nmap_d t.png\nKs 1 1 1\nNs 10
newmtl b\nTf 0.5 1 1\nillum 7\nNi 1.5\nKe 1 1 1\nPm 0.5\n"""


def seeds() -> dict[str, dict[str, bytes]]:
    """Return the files of each format by name, the main file first; 10 kB at most together."""
    picture = png([[[255, 0, 0, 200], [0, 255, 0, 100]]])
    gltf = rich_gltf()
    text = dict(gltf.document, buffers=[{"byteLength": len(gltf.content), "uri": "b.bin"}])
    triangles = [[0, 1, 2], [0, 2, 3]]
    mixed = [[0, 1, 2, 3], [1, 2, 3]]
    return {
        "glb": {"model.glb": gltf.glb()},
        "gltf": {"model.gltf": json.dumps(text).encode(), "b.bin": gltf.content},
        "obj": {"model.obj": OBJ.encode(), "m.mtl": MTL.encode(), "t.png": picture},
        "mtl": {"model.obj": OBJ.encode(), "m.mtl": MTL.encode(), "t.png": picture},
        "ascii": {"model.ply": ply("ascii", mixed)},
        "binary": {"model.ply": ply("binary_little_endian", triangles)},
        "mixed": {"model.ply": ply("binary_big_endian", mixed)},
    }


def mutated(kind: str, files: dict[str, bytes], random_: random.Random) -> dict[str, bytes]:
    """Return a damaged copy of the files of a format."""
    if kind in ("glb", "gltf") and random_.random() < 0.6:
        return _mutated_document(kind, random_)
    names = list(files)
    name = "m.mtl" if kind == "mtl" else random_.choice(names[:1] * 3 + names)
    content = bytearray(files[name])
    for _ in range(random_.choice((1, 1, 2, 5, 20))):
        place = random_.randrange(len(content) + 1)
        action = random_.randrange(6)
        if action == 0:
            content[place : place + 1] = bytes([random_.randrange(256)])
        elif action == 1:
            content[place : place + random_.choice((1, 4, 40))] = b""
        elif action == 2:
            content[place:place] = random_.choice(_SPECIAL)
        elif action == 3:
            other = random_.randrange(len(content) + 1)
            content[place:place] = content[other : other + random_.choice((4, 40, 400))]
        elif action == 4:
            numbers = list(re.finditer(rb"-?\d+(?:\.\d+)?", bytes(content)))
            if numbers:
                number = random_.choice(numbers)
                content[number.start() : number.end()] = random_.choice(_SPECIAL[4:9])
        else:
            del content[place:]
        if not content:
            break
    return {**files, name: bytes(content)}


def _mutated_document(kind: str, random_: random.Random) -> dict[str, bytes]:
    """Return a file of which some values of the document were changed."""
    gltf = rich_gltf()
    places = [place for place in _places(gltf.document) if place[1] != "asset"]
    for _ in range(random_.choice((1, 1, 2, 4))):
        owner, key = random_.choice(places)
        owner[key] = random_.choice(_VALUES)
    if kind == "glb":
        return {"model.glb": gltf.glb()}
    document = {"buffers": [{"byteLength": len(gltf.content), "uri": "b.bin"}], **gltf.document}
    return {"model.gltf": json.dumps(document).encode(), "b.bin": gltf.content}


def _places(value: Any) -> Iterator[tuple[Any, Any]]:
    """Yield each member of a document with its owner."""
    items = value.items() if isinstance(value, dict) else enumerate(value)
    for key, item in items:
        yield value, key
        if isinstance(item, dict | list):
            yield from _places(item)


def write_all(folder: Path, files: dict[str, bytes]) -> Path:
    """Write files into a folder; return the path of the first."""
    for name, content in files.items():
        (folder / name).write_bytes(content)
    return folder / next(iter(files))

"""Arrays of glTF files: every storage that the format has, and checked bounds."""

from __future__ import annotations

import base64
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from oitbench.errors import SceneError
from oitbench.importing import read_scene
from tests.importing.files import SIMPLE, Gltf, cube

CORNERS = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], dtype=float)


def faces(gltf: Gltf, folder: Path) -> set[tuple[tuple[float, ...], ...]]:
    """Return the triangles of a file as sets of corners that begin with the lowest."""
    mesh = gltf.one(folder).mesh
    found = set()
    for triangle in mesh.positions[mesh.triangles]:
        corners = [tuple(corner) for corner in triangle.tolist()]
        first = corners.index(min(corners))
        found.add(tuple(corners[first:] + corners[:first]))
    return found


def square(*triangles: tuple[int, int, int]) -> set[tuple[tuple[float, ...], ...]]:
    found = set()
    for triangle in triangles:
        corners = [tuple(CORNERS[k].tolist()) for k in triangle]
        first = corners.index(min(corners))
        found.add(tuple(corners[first:] + corners[:first]))
    return found


def indexed(gltf: Gltf, indices: list[int] | None, kind: str, mode: int, points: Any) -> Gltf:
    number = None if indices is None else gltf.array(indices, kind)
    gltf.add("nodes", {"mesh": gltf.mesh({"POSITION": gltf.array(points)}, number, mode=mode)})
    return gltf


@pytest.mark.parametrize("kind", ["uint8", "uint16", "uint32"])
def test_indices_of_each_type(kind: str, tmp_path: Path) -> None:
    gltf = indexed(Gltf(), [0, 1, 2, 0, 2, 3], kind, 4, CORNERS)
    assert faces(gltf, tmp_path) == square((0, 1, 2), (0, 2, 3))


def test_no_indices_strips_and_fans(tmp_path: Path) -> None:
    both = square((0, 1, 2), (0, 2, 3))
    assert faces(indexed(Gltf(), None, "", 4, CORNERS[[0, 1, 2, 0, 2, 3]]), tmp_path) == both
    assert faces(indexed(Gltf(), [0, 1, 2, 3], "uint8", 6, CORNERS), tmp_path) == both
    # The second triangle of a strip runs backwards, so that both have one orientation.
    strip = indexed(Gltf(), [1, 2, 0, 3], "uint8", 5, CORNERS)
    assert faces(strip, tmp_path) == square((1, 2, 0), (0, 2, 3))


def test_interleaved_vertices(tmp_path: Path) -> None:
    gltf = Gltf()
    table = np.concatenate([CORNERS, np.tile([0.0, 0.0, 1.0], (4, 1))], axis=1).astype("<f4")
    view = gltf.view(table.tobytes(), byteStride=24)
    shared = {"bufferView": view, "componentType": 5126, "count": 4, "type": "VEC3"}
    attributes = {
        "POSITION": gltf.add("accessors", shared),
        "NORMAL": gltf.add("accessors", {**shared, "byteOffset": 12}),
    }
    gltf.add("nodes", {"mesh": gltf.mesh(attributes, gltf.array([0, 1, 2], "uint8"))})
    mesh = gltf.one(tmp_path).mesh
    np.testing.assert_array_equal(mesh.positions, CORNERS[:3])
    np.testing.assert_array_equal(mesh.normals, [[0, 0, 1]] * 3)


@pytest.mark.parametrize("stored", [True, False], ids=["replaces", "zeros"])
def test_sparse_vertices(stored: bool, tmp_path: Path) -> None:
    gltf = Gltf()
    position = gltf.array(CORNERS[:3] if stored else [[9, 9, 9]] * 3)
    sparse = {
        "count": 2,
        "indices": {"bufferView": gltf.view(bytes([1, 2])), "componentType": 5121},
        "values": {"bufferView": gltf.view(np.array([[5, 0, 0], [0, 6, 0]], "<f4").tobytes())},
    }
    gltf.document["accessors"][position]["sparse"] = sparse
    if not stored:
        del gltf.document["accessors"][position]["bufferView"]
    gltf.add("nodes", {"mesh": gltf.mesh({"POSITION": position})})
    np.testing.assert_array_equal(
        gltf.one(tmp_path).mesh.positions, [[0, 0, 0], [5, 0, 0], [0, 6, 0]]
    )


def test_quantized_vertices(tmp_path: Path) -> None:
    gltf = Gltf()
    places = gltf.array([[0, 0, 0, 0], [32767, 0, 0, 0], [0, -32767, 0, 0]], "int16")
    gltf.document["accessors"][places] |= {"type": "VEC3", "normalized": True}
    gltf.document["bufferViews"][0]["byteStride"] = 8
    gltf.document["extensionsRequired"] = ["KHR_mesh_quantization"]
    gltf.add("nodes", {"mesh": gltf.mesh({"POSITION": places})})
    np.testing.assert_array_equal(
        gltf.one(tmp_path).mesh.positions, [[0, 0, 0], [1, 0, 0], [0, -1, 0]]
    )


@pytest.mark.parametrize("where", ["data", "file", "escaped"])
def test_buffers_of_their_own(where: str, tmp_path: Path) -> None:
    gltf = Gltf()
    gltf.triangle()
    name = "the buffer.bin"
    uri = {
        "data": f"data:application/octet-stream;base64,{base64.b64encode(gltf.content).decode()}",
        "file": name,
        "escaped": "the%20buffer.bin",
    }[where]
    (tmp_path / name).write_bytes(gltf.content)
    document = {key: value for key, value in gltf.document.items() if value}
    document["buffers"] = [{"byteLength": len(gltf.content), "uri": uri}]
    path = tmp_path / "model.gltf"
    path.write_text(json.dumps(document))
    found = read_scene(path, **SIMPLE)
    assert len(found.scene.objects[0].mesh.triangles) == 1
    assert list(found.files) == ([] if where == "data" else [name])


def damaged(change: Any) -> Gltf:
    """Return the file of an indexed cube after a change of its document."""
    gltf = Gltf()
    corners, triangles = cube()
    mesh = gltf.mesh({"POSITION": gltf.array(corners)}, gltf.array(triangles.ravel(), "uint16"))
    gltf.add("nodes", {"mesh": mesh})
    change(gltf.document)
    return gltf


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda d: d["accessors"][0].update(count=9), "accessor 0 ends at byte 108 of 96"),
        (lambda d: d["accessors"][0].update(count=10**11), "more than 100,000,000 numbers"),
        (lambda d: d["accessors"][0].update(byteOffset=4), "ends at byte 100 of 96"),
        (lambda d: d["accessors"][0].update(bufferView=7), "buffer view 7 is used, but"),
        (lambda d: d["accessors"][0].update(type="VEC2"), "the attribute needs another type"),
        (lambda d: d["accessors"][0].update(type="MAT4"), "vertices have no matrices"),
        (lambda d: d["accessors"][1].update(componentType=5122), "holds no indices"),
        (lambda d: d["bufferViews"][0].update(byteLength=10**9), "of 168"),
        (lambda d: d["bufferViews"][0].update(byteStride=8), "elements of 12 bytes, 8 apart"),
        (lambda d: d.update(buffers=[{"byteLength": 10**9}]), "1000000000 are announced"),
        (lambda d: d.update(buffers=[{"byteLength": 168, "uri": "http://x.org/b"}]), "nothing is"),
        (lambda d: d["nodes"][0].update(mesh=3), "mesh 3 is used, but there are 1"),
        (lambda d: d["nodes"][0].update(mesh=-1), "Expected `int` >= 0 - at `$.nodes"),
        (lambda d: d["meshes"][0]["primitives"][0].update(material=0), "material 0 is used"),
    ],
)  # fmt: skip
def test_a_damaged_document_is_one_clear_line(change: Any, message: str, tmp_path: Path) -> None:
    with pytest.raises(SceneError, match=message.replace("$", r"\$").replace("`", ".")):
        damaged(change).read(tmp_path)


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_numbers_that_are_none_are_refused(value: float, tmp_path: Path) -> None:
    gltf = Gltf()
    gltf.add("nodes", {"mesh": gltf.mesh({"POSITION": gltf.array([[0, 0, value]] * 3)})})
    with pytest.raises(SceneError, match="holds NaN or infinity"):
        gltf.read(tmp_path)


def test_an_index_out_of_range_is_refused(tmp_path: Path) -> None:
    gltf = indexed(Gltf(), [0, 1, 4], "uint8", 4, CORNERS)
    with pytest.raises(SceneError, match="a triangle uses vertex 4 of 4"):
        gltf.read(tmp_path)


def test_triangles_without_area_are_left_out(tmp_path: Path) -> None:
    gltf = indexed(Gltf(), [0, 1, 2, 0, 0, 3, 1, 1, 1], "uint8", 4, CORNERS)
    found = gltf.read(tmp_path)
    assert len(found.scene.objects[0].mesh.triangles) == 1
    assert found.notes == ("triangles without area are left out",)

"""Wavefront and polygon files."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from oitbench.errors import SceneError
from oitbench.importing import Imported, limits, read_scene, shapes
from oitbench.importing.obj import read
from oitbench.importing.obj.faces import Run, corners_of
from oitbench.scene import BLACK, Floats, Object, Texture, Wrap
from tests import meshes
from tests.importing.files import CUBE_QUADS, SIMPLE, close, cube, png, write

SQUARE = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n"


def load(folder: Path, text: str, name: str = "model.obj", **values: Any) -> Imported:
    return read_scene(write(folder, name, text), **{**SIMPLE, **values})


def one(folder: Path, text: str, name: str = "model.obj", **values: Any) -> Object:
    (item,) = load(folder, text, name, **values).scene.objects
    return item


def area(item: Object) -> float:
    return float(np.linalg.norm(meshes.face_normals(item.mesh), axis=1).sum() / 2)


def cube_faces(form: str = "{0}") -> str:
    lines = [f"v {x} {y} {z}" for x, y, z in cube()[0].tolist()]
    lines += ["f " + " ".join(form.format(k + 1) for k in quad) for quad in CUBE_QUADS]
    return "\n".join(lines) + "\n"


def test_polygons_are_split(tmp_path: Path) -> None:
    item = one(tmp_path, cube_faces())
    assert meshes.signed_volume(item.mesh) == pytest.approx(1)
    assert item.mesh.normals is None


def test_concave_polygons_keep_their_outline(tmp_path: Path) -> None:
    arrow = "v 0 0 0\nv 4 0 0\nv 4 4 0\nv 3 1 0\n"
    item = one(tmp_path, arrow + "f 1 2 3 4\n")
    assert area(item) == pytest.approx(4)
    assert (meshes.face_normals(item.mesh)[:, 2] > 0).all()
    # The same outline in other planes, from every corner, and seen from behind.
    tilted = "v 0 0 0\nv 0 4 0\nv 0 4 4\nv 0 3 1\n"
    across = "v 0 0 0\nv 4 0 0\nv 4 0 4\nv 3 0 1\n"
    for face in ("1 2 3 4", "2 3 4 1", "3 4 1 2", "4 1 2 3", "4 3 2 1", "1 4 3 2"):
        for outline in (arrow, tilted, across):
            assert area(one(tmp_path, outline + f"f {face}\n")) == pytest.approx(4)


def test_cutting_has_one_limit_for_a_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    arrow = "v 0 0 0\nv 4 0 0\nv 4 4 0\nv 3 1 0\n"
    # The fan of this corner covers more than the outline.
    text = "".join(f"{arrow}g {k}\nf -4 -3 -2 -1\n" for k in range(3))
    monkeypatch.setitem(limits.LIMITS, "steps of cutting", 2 * 4**2)
    imported = load(tmp_path, text)
    areas = [area(item) for item in imported.scene.objects]
    assert areas == pytest.approx([4, 4, 12])
    assert imported.notes == (
        "many concave polygons are split as if they were convex; [limit=2] cuts more",
    )
    assert not load(tmp_path, text, limit=2.0).notes


def test_only_what_faces_depend_on_divides_them(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    runs: list[Run] = []

    def spy(run: Run, counts: tuple[int, int, int]) -> Iterator[shapes.Indices]:
        runs.append(run)
        return corners_of(run, counts)

    monkeypatch.setattr(read, "corners_of", spy)
    item = one(tmp_path, SQUARE + "f 1 2 3\n# more\n\nmtllib x.mtl\nl 1 2\nlod 1\nf 1 3 4\n")
    assert (area(item), [len(run.faces) for run in runs]) == (1, [2])
    runs.clear()
    # Negative indices count from the vertices before their face.
    item = one(tmp_path, SQUARE + "f -4 -3 -2\nv 9 9 9\nf -5 -3 -2\n")
    assert (area(item), [len(run.faces) for run in runs]) == (1, [1, 1])


@pytest.mark.parametrize(
    "face", ["1 2 3 4", "-4 -3 -2 -1", "1/ 2/ 3/ 4/", "1// 2 3// 4//", "+1 2 3 4 # front"]
)
def test_indices_of_wavefront(face: str, tmp_path: Path) -> None:
    if "#" in face:
        face = face.partition("#")[0]
    assert area(one(tmp_path, SQUARE + f"f {face}\n")) == 1


@pytest.mark.parametrize(
    "face", ["1 2 5", "0 1 2", "-5 1 2", "1 2 x", "1/1 2/1 3/1", "1/1/1/1 2 3"]
)
def test_damaged_faces_are_refused(face: str, tmp_path: Path) -> None:
    with pytest.raises(SceneError, match="a face"):
        one(tmp_path, SQUARE + f"f {face}\n")


@pytest.mark.parametrize("line", ["v 1 2", "v 1 2 x", "v 1 2 nan", "v 1 2 inf", "vn 1 2", "v"])
def test_damaged_numbers_are_refused(line: str, tmp_path: Path) -> None:
    with pytest.raises(SceneError, match="a line 'v"):
        one(tmp_path, SQUARE + line + "\nf 1 2 3\n")


def test_normals_coordinates_and_colors(tmp_path: Path) -> None:
    text = (
        "v 0 0 0 1 0 0\nv 1 0 0 0 1 0\nv 0 1 0 0 0 1\nvt 0 0\nvt 1 0\nvt 0 0.5\nvn 0 0 2\n"
        "mtllib a b.mtl\nusemtl red one\nf 1/1/1 2/2/1 3/3/1\n"
    )
    write(
        tmp_path, "a b.mtl", "newmtl red one\nKd 0.5 0 0\nmap_Kd -s 2 2 1 -clamp on the map.png\n"
    )
    (tmp_path / "the map.png").write_bytes(png([[[255, 255, 255], [0, 0, 0]]]))
    imported = load(tmp_path, text)
    (item,) = imported.scene.objects
    assert item.name == "red one"
    np.testing.assert_array_equal(item.mesh.normals, [[0, 0, 1]] * 3)
    np.testing.assert_array_equal(item.mesh.albedo, np.eye(3))
    np.testing.assert_array_equal(item.mesh.uvs, [[0, 0], [2, 0], [0, 1]])
    albedo = item.material.albedo
    assert isinstance(albedo, Texture)
    close(albedo.texels, [[[0.5, 0, 0], [0, 0, 0]]])
    assert albedo.wrap == (Wrap.CLAMP, Wrap.CLAMP)
    assert sorted(imported.files) == ["a b.mtl", "the map.png"]


def test_smoothing_groups(tmp_path: Path) -> None:
    fold = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n"
    smooth = one(tmp_path, fold + "s 1\nf 1 2 3\nf 1 4 2\n").mesh
    assert len(smooth.positions) == 4
    assert smooth.normals is not None
    close(smooth.normals[0], [0, 0.5**0.5, 0.5**0.5], atol=1e-6)
    mixed = one(tmp_path, fold + "s 1\nf 1 2 3\ns off\nf 1 4 2\n").mesh
    assert (meshes.agreement(mixed) > 0.999).all()


def test_objects_and_materials_of_wavefront(tmp_path: Path) -> None:
    text = SQUARE + "mtllib m.mtl\no front\nusemtl a\nf 1 2 3\nusemtl b\nf 1 3 4\no back\nf 4 3 2\n"
    write(tmp_path, "m.mtl", "newmtl a\nKd 1 0 0\nnewmtl b\nKd 0 0 1\nillum 2\n")
    items = load(tmp_path, text).scene.objects
    assert [item.name for item in items] == ["front", "front 2", "back"]
    assert [item.material.albedo for item in items] == [(1, 0, 0), (0, 0, 1), (0, 0, 1)]


def surface(folder: Path, described: str, text: str = SQUARE + "usemtl m\nf 1 2 3 4\n") -> Object:
    write(folder, "m.mtl", f"newmtl m\n{described}\n")
    return one(folder, "mtllib m.mtl\n" + text)


@pytest.mark.parametrize("blank", ["\t", " \t ", "  "])
def test_any_blanks_follow_a_keyword(blank: str, tmp_path: Path) -> None:
    def spaced(text: str) -> str:
        lines = (line.partition(" ") for line in text.splitlines())
        return "".join(f"{blank}{key}{blank}{rest}{blank}\n" for key, _, rest in lines)

    write(tmp_path, "m.mtl", spaced("newmtl the red\nKd 1 0 0\nd 0.5\n"))
    text = spaced("mtllib m.mtl\no a square\n" + SQUARE + "usemtl the red\ns off\nf 1 2 3 4\n")
    imported = load(tmp_path, text)
    (item,) = imported.scene.objects
    assert (item.name, area(item), imported.notes) == ("a square", 1, ())
    assert (item.material.albedo, item.material.coverage) == ((1, 0, 0), 0.5)


def test_materials_of_wavefront(tmp_path: Path) -> None:
    thin = surface(tmp_path, "Kd 0.8 0.8 0.8\nd 0.25\nTf 1 1 1\nillum 2").material
    assert (thin.coverage, thin.transmission) == (0.25, BLACK)
    assert surface(tmp_path, "Tr 0.25").material.coverage == 0.75
    pane = surface(tmp_path, "Kd 0.8 0.8 0.8\nTf 1 0.5 0.25\nillum 4\nNi 1.5").material
    assert (pane.transmission, pane.albedo, pane.solid) == ((1, 0.5, 0.25), BLACK, False)
    assert pane.reflectance == pytest.approx(0.04)
    glowing = surface(tmp_path, "Ke 2 1 0\nKs 1 1 1\nNs 0").material
    assert (glowing.emission, glowing.reflectance, glowing.roughness) == ((2, 1, 0), 0.04, 1)
    flat = surface(tmp_path, "Kd 0.5 0.25 0\nillum 0").material
    assert (flat.emission, flat.albedo, flat.reflectance) == ((0.5, 0.25, 0), BLACK, 0)
    metal = surface(tmp_path, "Kd 0.9 0.6 0.3\nPm 1\nPr 0.2").material
    assert metal.reflectance == pytest.approx(0.3)
    assert metal.albedo == pytest.approx((0.6, 0.3, 0))
    assert metal.roughness == pytest.approx(0.2)


def test_a_metal_of_wavefront_has_the_colors_of_its_vertices(tmp_path: Path) -> None:
    red = "v 0 0 0 1 0 0\nv 1 0 0 1 0 0\nv 0 1 0 1 0 0\n"
    gray = "v 0 0 1 0.5 0.5 0.5\nv 1 0 1 0.5 0.5 0.5\nv 0 1 1 0.5 0.5 0.5\n"
    write(tmp_path, "m.mtl", "newmtl m\nKd 1 1 1\nPm 1\n")
    faces = "mtllib m.mtl\nusemtl m\no red\nf 1 2 3\no gray\nf 4 5 6\n"
    imported = load(tmp_path, red + gray + faces)
    first, second = imported.scene.objects
    assert (first.material.reflectance, first.material.albedo) == (0, (1, 1, 1))
    assert second.material.reflectance == pytest.approx(0.5)
    assert second.material.albedo == BLACK
    assert [note.partition(":")[0] for note in imported.notes] == ["metals"]


def test_refracting_materials_of_wavefront(tmp_path: Path) -> None:
    faces = cube_faces().replace("f ", "usemtl m\nf ", 1)
    solid = surface(tmp_path, "Tf 1 1 1\nillum 7\nNi 1.5", faces).material
    assert (solid.solid, solid.index) == (True, 1.5)
    opened = "\n".join(faces.splitlines()[:-1]) + "\n"
    assert not surface(tmp_path, "Tf 1 1 1\nillum 7\nNi 1.5", opened).material.solid


def test_alpha_maps_of_wavefront(tmp_path: Path) -> None:
    (tmp_path / "gray.png").write_bytes(png([[0, 255]]))
    (tmp_path / "alpha.png").write_bytes(png([[[9, 9, 9, 255], [9, 9, 9, 51]]]))
    for name, expected in (("gray", [[0, 1]]), ("alpha", [[1, 0.2]])):
        coverage = surface(tmp_path, f"map_d {name}.png").material.coverage
        assert isinstance(coverage, Texture)
        close(coverage.texels, expected)


def test_missing_materials_and_pictures_are_noted(tmp_path: Path) -> None:
    write(tmp_path, "m.mtl", "newmtl m\nmap_Kd gone.png\nbump x.png\n")
    text = SQUARE + "mtllib m.mtl\nmtllib gone.mtl\nusemtl m\nf 1 2 3\nusemtl x\nf 1 3 4\n"
    assert load(tmp_path, text).notes == (
        "'bump' of materials is ignored (m)",
        "a file of materials is missing; its surfaces are gray (gone.mtl)",
        "a picture is missing; its surfaces have no texture (gone.png)",
        "materials that no file describes are gray (x)",
    )
    with pytest.raises(SceneError, match="outside the file's folder"):
        load(tmp_path, SQUARE + "mtllib ../m.mtl\nf 1 2 3\n")


VERTICES = "element vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
COLORS = "".join(f"property uchar {name}\n" for name in ("red", "green", "blue", "alpha"))
FACES = "element face 2\nproperty list uchar int vertex_indices\n"
CORNERS = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], dtype=float)
PAINT = np.array([[255, 0, 0, 255], [0, 188, 0, 51], [0, 0, 255, 0], [0, 0, 0, 255]])


def ply(order: str, faces: list[list[int]], extra: str = "") -> bytes:
    """Return a file of four colored vertices, in any order of bytes."""
    head = f"ply\nformat {order} 1.0\ncomment x\n{VERTICES}{COLORS}{FACES}{extra}end_header\n"
    if order == "ascii":
        rows = [[*corner, *paint] for corner, paint in zip(CORNERS, PAINT, strict=True)]
        rows += [[len(face), *face] for face in faces]
        return (head + "\n".join(" ".join(map(str, row)) for row in rows) + "\n").encode()
    sign = {"binary_little_endian": "<", "binary_big_endian": ">"}[order]
    body = b""
    for corner, paint in zip(CORNERS, PAINT, strict=True):
        body += corner.astype(f"{sign}f4").tobytes() + paint.astype("u1").tobytes()
    for face in faces:
        body += bytes([len(face)]) + np.array(face, dtype=f"{sign}i4").tobytes()
    return head.encode() + body


def load_ply(folder: Path, content: bytes, **values: Any) -> Object:
    path = folder / "model.ply"
    path.write_bytes(content)
    (item,) = read_scene(path, **{**SIMPLE, **values}).scene.objects
    return item


@pytest.mark.parametrize(
    "faces", [[[0, 1, 2], [0, 2, 3]], [[0, 1, 2, 3], [1, 2, 3]]], ids=["equal", "mixed"]
)
@pytest.mark.parametrize("order", ["ascii", "binary_little_endian", "binary_big_endian"])
def test_polygon_files(order: str, faces: list[list[int]], tmp_path: Path) -> None:
    item = load_ply(tmp_path, ply(order, faces))
    assert area(item) == pytest.approx(1 if len(faces[0]) == 3 else 1.5)
    np.testing.assert_array_equal(item.mesh.positions, CORNERS)
    expected: Floats = np.array([[1, 0, 0], [0, 0.503, 0], [0, 0, 1], [0, 0, 0]])
    close(item.mesh.albedo, expected, atol=1e-3)
    close(item.mesh.coverage, [1, 0.2, 0, 1])


def test_polygon_files_with_z_up(tmp_path: Path) -> None:
    item = load_ply(tmp_path, ply("ascii", [[0, 1, 2], [0, 2, 3]]), up="z", unit=0.01)
    np.testing.assert_array_equal(
        item.mesh.positions, [[0, 0, 0], [1, 0, 0], [1, 0, -1], [0, 0, -1]]
    )


@pytest.mark.parametrize("order", ["ascii", "binary_little_endian"])
@pytest.mark.parametrize(
    ("change", "message"),
    [
        ((b"vertex 4", b"vertex 400"), "too short|more than|ends before"),
        ((b"vertex 4", b"vertex 99999999999"), "too short"),
        ((b"face 2", b"face -2"), "negative count"),
        ((b"face 2", b"face 3"), "ends before"),
        ((b"float x", b"thing x"), "unknown line: property thing x"),
        ((b"float x", b"list char x"), "unknown line"),
        ((b"end_header", b"end"), "its header is missing"),
        ((b"property float x\n", b""), "have no x, y and z|ends before|impossible|uses vertex"),
    ],
)  # fmt: skip
def test_damaged_polygon_files(
    order: str, change: tuple[bytes, bytes], message: str, tmp_path: Path
) -> None:
    with pytest.raises(SceneError, match=message):
        load_ply(tmp_path, ply(order, [[0, 1, 2], [0, 2, 3]]).replace(*change))


def test_indices_of_polygon_files_are_checked(tmp_path: Path) -> None:
    for wrong in (4, -1):
        for order in ("ascii", "binary_big_endian"):
            with pytest.raises(SceneError, match="a triangle uses vertex"):
                load_ply(tmp_path, ply(order, [[0, 1, 2], [0, 1, wrong]]))


def test_elements_that_are_not_shown_are_noted(tmp_path: Path) -> None:
    extra = "element edge 1\nproperty int vertex1\nproperty list uchar int vertex2\n"
    content = ply("ascii", [[0, 1, 2], [0, 2, 3]], extra) + b"7 2 1 1\n"
    (tmp_path / "model.ply").write_bytes(content)
    assert read_scene(tmp_path / "model.ply", **SIMPLE).notes == ("elements 'edge' are left out",)


@pytest.mark.parametrize("far", [1, 2**40], ids=["one key", "rows"])
def test_distinct_rows_are_in_order(far: int) -> None:
    table = np.array([[2, -1], [0, 5], [2, -1], [0, -1]]) * far
    rows, numbers = shapes.distinct_rows(table)
    np.testing.assert_array_equal(rows, np.array([[0, -1], [0, 5], [2, -1]]) * far)
    np.testing.assert_array_equal(rows[numbers], table)


def test_faces_of_many_forms_are_read_alike(tmp_path: Path) -> None:
    head = SQUARE + "vt 0 0\nvn 0 0 1\n"
    for form in ("{0}", "{0}/1", "{0}//1", "{0}/1/1", "{0}/", "{0}//"):
        face = " ".join(form.format(k) for k in (1, 2, 3))
        assert area(one(tmp_path, f"{head}f {face}\nf 1/1 3 4//1\n")) == 1, form
        assert area(one(tmp_path, f"{head}f {face}\nf {face}\n")) == 1, form
    for wrong in ("1/1/1/1 2/1 3", "1/2/3 4 3/1"):
        with pytest.raises(SceneError, match="a face"):
            one(tmp_path, f"{head}f {wrong}\n")

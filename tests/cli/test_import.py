"""Files of users on the command line: `--scene FILE`, and `oitbench import`."""

from __future__ import annotations

import ast
import json
import re
from pathlib import Path

import numpy as np
import pygltflib
import pytest

from oitbench.image.files import read_exr, write_exr
from oitbench.places import Places
from oitbench.plugins import Collection
from tests.cli.helpers import SMALL, Call
from tests.importing.files import cube, png, write

GLASS = {
    "KHR_materials_transmission": {"transmissionFactor": 1},
    "KHR_materials_ior": {"ior": 1.4},
    "KHR_materials_volume": {
        "thicknessFactor": 1, "attenuationDistance": 0.5, "attenuationColor": [1, 0.5, 0.2],
    },
}  # fmt: skip

TRIANGLE = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"


@pytest.fixture
def model(tmp_path: Path) -> Path:
    """Return a .glb with a BLEND and a transmissive material, written by another library."""
    corners, triangles = cube()
    points, faces = corners.astype("<f4").tobytes(), triangles.astype("<u2").tobytes()
    plain = pygltflib.PbrMetallicRoughness(metallicFactor=0, roughnessFactor=0.2)
    red = pygltflib.PbrMetallicRoughness(baseColorFactor=[1, 0, 0, 0.5], metallicFactor=0)
    gltf = pygltflib.GLTF2(
        scene=0,
        scenes=[pygltflib.Scene(nodes=[0, 1])],
        nodes=[pygltflib.Node(mesh=0), pygltflib.Node(mesh=1, translation=[0, 0, -2])],
        meshes=[
            pygltflib.Mesh(
                primitives=[
                    pygltflib.Primitive(
                        attributes=pygltflib.Attributes(POSITION=0), indices=1, material=material
                    )
                ]
            )
            for material in (0, 1)
        ],
        materials=[
            pygltflib.Material(name="glass", pbrMetallicRoughness=plain, extensions=GLASS),
            pygltflib.Material(
                name="red", pbrMetallicRoughness=red, alphaMode="BLEND",
                normalTexture=pygltflib.NormalMaterialTexture(index=0),
            ),
        ],
        accessors=[
            pygltflib.Accessor(bufferView=0, componentType=5126, count=8, type="VEC3"),
            pygltflib.Accessor(bufferView=1, componentType=5123, count=36, type="SCALAR"),
        ],
        bufferViews=[
            pygltflib.BufferView(buffer=0, byteLength=len(points)),
            pygltflib.BufferView(buffer=0, byteOffset=len(points), byteLength=len(faces)),
        ],
        buffers=[pygltflib.Buffer(byteLength=len(points) + len(faces))],
        extensionsUsed=list(GLASS),
    )  # fmt: skip
    gltf.set_binary_blob(points + faces)
    path = tmp_path / "two cubes.glb"
    gltf.save(path)
    return path


def test_a_file_is_a_scene_from_a_run_to_its_report(
    call: Call, model: Path, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    out = tmp_path / "results"
    chosen = ("--scene", f"{model}[light=none]", "--method", "phenomenological")
    arguments = ("run", *chosen, "--truth", "exact", "--out", out, *SMALL)
    answer = call(*arguments)
    assert answer.code == 0, answer
    assert caplog.messages == ["two cubes: normal maps are ignored (red)"]
    records = [json.loads(line) for line in (out / "cells.jsonl").read_text().splitlines()]
    assert {record["scene"] for record in records} == {"two cubes[light=none]"}
    assert "REFRACTION" in records[-1]["outcome"]["effects"]["requested"]
    # The same file keeps its cells; another content gives new ones.
    assert "1 kept" in call(*arguments).out
    content = model.read_bytes()
    model.write_bytes(re.sub(rb'("ior": ?)1.4', rb"\g<1>1.3", content))
    assert model.read_bytes() != content
    assert "0 kept" in call(*arguments).out
    assert call("report", out).code == 0
    assert "two cubes" in (out / "report" / "index.html").read_text()


def test_parameters_of_a_file(call: Call, model: Path, tmp_path: Path) -> None:
    def picture(selector: object) -> float:
        out = tmp_path / "x.exr"
        assert call("render", selector, "sorted_over", "-o", out, *SMALL).code == 0
        return float(read_exr(out).mean())

    sky = tmp_path / "sky.exr"
    write_exr(sky, np.full((4, 8, 3), 9.0, dtype=np.float32))
    dim = picture(f"{model}[light=none]")
    assert picture(f"{model}[light=none,environment={sky}]") > 3 * dim > 0
    assert picture(f"{model}[light=none,environment=none]") == 0


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        ("gone.glb", None, "there is no such file"),
        ("a[b.obj", "", "rename the file"),
        ("bottles.obj", "", "two scenes are named 'bottles'"),
        ("empty.obj", "", "it has no triangle that can be seen"),
        ("broken.glb", "{", "its JSON cannot be read"),
    ],
)
@pytest.mark.usefixtures("model")
def test_a_file_that_is_no_scene_is_refused(
    call: Call, tmp_path: Path, name: str, content: str | None, message: str
) -> None:
    path = tmp_path / name
    if content is not None:
        write(tmp_path, name, content)
    if "[" in name:
        call("import", path, "-o", tmp_path / "mine").assert_refused(message)
        return
    call("render", path, "sorted_over", "-o", tmp_path / "x.exr", *SMALL).assert_refused(message)


def test_a_file_is_kept_as_a_scene_of_a_collection(
    call: Call, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    folder, mine = tmp_path / "from", tmp_path / "mine"
    (folder / "maps").mkdir(parents=True)
    (folder / "maps" / "t.png").write_bytes(png([[[255, 0, 0]], [[0, 0, 255]]]))
    write(folder, "m.mtl", "newmtl a\nmap_Kd maps/t.png\n")
    square = "v 0 0 0\nv 1 0 0\nv 1 1 0\nvt 0 0\nvt 1 0\nvt 1 1\n"
    path = write(folder, "card.obj", f"{square}mtllib m.mtl\nusemtl a\nf 1/1 2/2 3/3\nl 1 2\n")
    sky = folder / "sky.exr"
    write_exr(sky, np.ones((2, 4, 3), dtype=np.float32))
    options = ("--environment", sky, "--ground", "no", "--light", "none")
    answer = call("import", path, "-o", mine, *options)
    assert answer.code == 0, answer
    assert "points and lines are left out" in caplog.text
    scenes = mine / "scenes"
    kept = sorted(p.relative_to(scenes).as_posix() for p in scenes.rglob("*") if p.is_file())
    assert kept == ["card.py", "card/card.obj", "card/m.mtl", "card/maps/t.png", "card/sky.exr"]
    before = [tmp_path / "a.exr", f"{path}[environment={sky},ground=no,light=none]"]
    after = [tmp_path / "b.exr", "card", "--collection", mine]
    for out, scene, *rest in (before, after):
        assert call("render", scene, "sorted_over", "-o", out, *rest, *SMALL).code == 0
    np.testing.assert_array_equal(read_exr(tmp_path / "a.exr"), read_exr(tmp_path / "b.exr"))
    call("import", path, "-o", mine).assert_refused("card.py exists")
    call("import", path, "-o", mine, "--name", "_x").assert_refused("give another one by --name")
    call("import", path, "-o", mine, "--light", "moon").assert_refused("light cannot be moon")
    call("import", tmp_path / "x.fbx", "-o", mine).assert_refused("unknown format")


@pytest.mark.parametrize(
    ("file", "options"),
    [
        ('"""+str(open(chr(114)))+""".obj', ()),
        ('"""+str(open(chr(114)))+""".obj', ("--name", "plain")),
        ("a\\N.obj", ("--name", "plain")),
        ("it's.obj", ()),
    ],
)
def test_the_name_of_a_file_is_no_code(
    call: Call, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, file: str, options: tuple[str, ...]
) -> None:
    monkeypatch.chdir(tmp_path)
    write(tmp_path, file, TRIANGLE)
    plain = ("--ground", "no", "--environment", "none")
    answer = call("import", tmp_path / file, "-o", tmp_path / "mine", *plain, *options)
    assert answer.code == 0, answer
    (module,) = (tmp_path / "mine" / "scenes").glob("*.py")
    tree = ast.parse(module.read_text())
    assert ast.get_docstring(tree) == f"{module.stem}, imported from {file}."
    found = Collection(Places([tmp_path / "mine"]))
    assert found.build_scene(module.stem).name == module.stem


def test_a_module_that_cannot_be_written_is_one_clear_line(call: Call, tmp_path: Path) -> None:
    path = write(tmp_path, "card.obj", TRIANGLE)
    (tmp_path / "mine" / "scenes").mkdir(parents=True)
    (tmp_path / "mine" / "scenes" / "card.py").symlink_to(tmp_path / "gone" / "card.py")
    call("import", path, "-o", tmp_path / "mine").assert_refused("card.py cannot be kept: No such")


def test_a_link_is_kept_under_its_own_name(call: Call, tmp_path: Path) -> None:
    (tmp_path / "blobs").mkdir()
    write(tmp_path / "blobs", "3fa9", TRIANGLE)
    (tmp_path / "card.obj").symlink_to(tmp_path / "blobs" / "3fa9")
    answer = call("import", tmp_path / "card.obj", "-o", tmp_path / "mine")
    assert answer.code == 0, answer
    kept = tmp_path / "mine" / "scenes" / "card" / "card.obj"
    assert kept.read_text() == TRIANGLE
    assert not kept.is_symlink()
    assert Collection(Places([tmp_path / "mine"])).build_scene("card").name == "card"


def test_an_environment_replaces_no_texture(call: Call, tmp_path: Path) -> None:
    folder, mine = tmp_path / "from", tmp_path / "mine"
    folder.mkdir()
    (folder / "t.png").write_bytes(png([[[255, 0, 0], [0, 0, 255]]]))
    (tmp_path / "t.png").write_bytes(png([[[9, 9, 9], [8, 8, 8]]]))
    write(folder, "m.mtl", "newmtl a\nmap_Kd t.png\n")
    path = write(folder, "card.obj", f"mtllib m.mtl\nusemtl a\n{TRIANGLE}")
    arguments = ("import", path, "-o", mine, "--environment")
    call(*arguments, tmp_path / "t.png").assert_refused("another file of the scene has this name")
    assert not mine.exists()
    # The texture itself may be the environment, too.
    answer = call(*arguments, "t.png")
    assert answer.code == 0, answer
    assert (mine / "scenes" / "card" / "t.png").read_bytes() == (folder / "t.png").read_bytes()

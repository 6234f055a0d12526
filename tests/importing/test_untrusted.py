"""Files that are not to be trusted: paths, sizes, pictures."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pytest

from oitbench.errors import SceneError, UsageError
from oitbench.importing import limits, read_scene
from oitbench.importing.files import Folder
from oitbench.importing.limits import Budget
from oitbench.importing.pictures import read_picture
from tests.importing.files import SIMPLE, Gltf, picture, png


@pytest.fixture
def folder(tmp_path: Path) -> Folder:
    inside = tmp_path / "inside"
    (inside / "below").mkdir(parents=True)
    (tmp_path / "secret.bin").write_bytes(b"secret")
    (inside / "below" / "part.bin").write_bytes(b"part")
    (inside / "link.bin").symlink_to(tmp_path / "secret.bin")
    (inside / "way").symlink_to(tmp_path)
    os.mkfifo(inside / "pipe.bin")
    return Folder(inside / "model.gltf", Budget())


@pytest.mark.parametrize(
    "uri", ["below/part.bin", "below/./part.bin", "below%2Fpart.bin", "below/../below/part.bin"]
)
def test_files_of_the_folder_are_read(folder: Folder, uri: str) -> None:
    assert folder.read_uri(uri) == b"part"
    assert list(folder.read_files) == ["below/part.bin"]


@pytest.mark.parametrize(
    "uri",
    [
        "../secret.bin", "below/../../secret.bin", "..%2Fsecret.bin", "%2e%2e/secret.bin",
        "..\\secret.bin", "/etc/passwd", "%2Fetc/passwd", "file:///etc/passwd", "FILE:secret.bin",
        "http://example.org/x", "//example.org/x", "link.bin", "way/secret.bin", "pipe.bin",
        "below", ".", "", "a\0b", "~/x", "C:/x", "missing.bin", "data:text/plain,abc", "x" * 5000,
    ],
)  # fmt: skip
def test_nothing_else_is_read(folder: Folder, uri: str) -> None:
    with pytest.raises(SceneError) as caught:
        folder.read_uri(uri)
    assert "secret" not in str(caught.value).replace("secret.bin", "")
    assert len(str(caught.value)) < 300
    assert not folder.read_files


def test_data_that_is_no_base64_is_refused(folder: Folder) -> None:
    assert folder.read_uri("data:;base64,AAAA") == b"\0\0\0"
    with pytest.raises(SceneError, match="no base64"):
        folder.read_uri("data:;base64,AA!A")


def test_the_limits_can_be_raised(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    gltf = Gltf()
    gltf.triangle()
    gltf.triangle()
    monkeypatch.setitem(limits.LIMITS, "triangles", 1)
    with pytest.raises(SceneError, match=r"more than 1 triangles; .* by \[limit=2\]"):
        gltf.read(tmp_path)
    assert len(gltf.read(tmp_path, limit=2.0).scene.objects) == 2


@pytest.mark.parametrize(
    ("kind", "least"),
    [
        ("bytes", 20),
        ("entries of JSON", 20),
        ("nodes", 0),
        ("vertices", 2),
        ("numbers of arrays", 8),
    ],
)
def test_every_limit_holds(
    kind: str, least: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    gltf = Gltf()
    gltf.triangle()
    monkeypatch.setitem(limits.LIMITS, kind, 10**6)
    gltf.read(tmp_path)
    monkeypatch.setitem(limits.LIMITS, kind, least)
    with pytest.raises(SceneError, match=f"more than .* {kind}"):
        gltf.read(tmp_path)


def test_instances_count_as_triangles(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(limits.LIMITS, "triangles", 10)
    gltf = Gltf()
    node = gltf.triangle()
    attributes = {"TRANSLATION": gltf.array([[0, 0, 0]] * 11)}
    gltf.document["nodes"][node]["extensions"] = {
        "EXT_mesh_gpu_instancing": {"attributes": attributes}
    }
    with pytest.raises(SceneError, match="more than 10 triangles"):
        gltf.read(tmp_path)


def test_pictures_of_any_size_are_not_decoded(tmp_path: Path) -> None:
    assert read_picture(picture(1, 1, b"\0\x80"), "x", Budget()).tolist() == [
        [[128, 128, 128, 255]]
    ]
    # 5,000 × 5,000 gray texels of zeros take 25 kB in a file, and a gigabyte as a material.
    with pytest.raises(SceneError, match="more than 17,000,000 texels"):
        read_picture(picture(5000, 5000, b""), "x", Budget())
    for content in (picture(2**31 - 1, 2**31 - 1, b""), b"", b"GIF89a", png([[1]])[:40]):
        with pytest.raises(SceneError):
            read_picture(content, "x", Budget(1000))


def test_textures_that_are_computed_count_as_texels(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(limits.LIMITS, "texels of textures", 60)
    gltf = Gltf()
    image = gltf.picture([[[k, 0, 0] for k in range(20)]])
    uvs = gltf.array([[0, 0], [1, 0], [0, 1]])
    for factor in (0.1, 0.2, 0.3, 0.4, 0.5):
        color = {"baseColorFactor": [factor, 1, 1, 1], "baseColorTexture": {"index": image}}
        gltf.triangle({"pbrMetallicRoughness": {"metallicFactor": 0, **color}}, TEXCOORD_0=uvs)
    with pytest.raises(SceneError, match="more than 60 texels"):
        gltf.read(tmp_path)


def deep(depth: int) -> str:
    return '{"asset":{"version":"2.0"},"extras":' + "[" * depth + "]" * depth + "}"


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (deep(100_000), "JSON cannot be read: maximum recursion"),
        ('{"asset":{"version":"1.0"},"nodes":{}}', "it is glTF '1.0'; convert it"),
        ('{"asset":{"version":"2.0"},"nodes":{}}', "Expected `array`, got `object`"),
        ("{", "JSON cannot be read"),
        ("", "JSON cannot be read"),
        ('{"asset":{"version":"2.0"}}', "no triangle that can be seen"),
        ("glTF", "ends in its header"),
        ("glTF\2\0\0\0\xff\0\0\0\xff\0\0\0JSON", "longer than the file"),
    ],
)
def test_a_broken_container_is_one_clear_line(content: str, message: str, tmp_path: Path) -> None:
    path = tmp_path / "model.gltf"
    path.write_bytes(content.encode("latin-1"))
    with pytest.raises(SceneError, match=message.replace("`", ".")):
        read_scene(path, **SIMPLE)


def test_names_of_a_file_cannot_break_a_line(tmp_path: Path) -> None:
    gltf = Gltf()
    gltf.triangle()
    gltf.document["extensionsRequired"] = ["a\nb\x1b[31m" + "x" * 10_000]
    with pytest.raises(SceneError) as caught:
        gltf.read(tmp_path)
    assert "\n" not in str(caught.value)
    assert "\x1b" not in str(caught.value)
    assert len(str(caught.value)) < 200


def test_unknown_formats_are_refused(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="give one of"):
        read_scene(tmp_path / "model.fbx")


def test_pictures_are_whole(tmp_path: Path) -> None:
    """Gray of 16 bits keeps its high byte, and only some pictures have an alpha."""
    from PIL import Image

    deep = tmp_path / "deep.png"
    Image.fromarray(np.array([[0, 256, 65535]], dtype=np.uint16)).save(deep)
    for content, expected in (
        (deep.read_bytes(), [[0, 0, 0, 255], [1, 1, 1, 255], [255, 255, 255, 255]]),
        (png([[[1, 2, 3]]]), [[1, 2, 3, 255]]),
        (png([[[1, 2, 3, 4]]]), [[1, 2, 3, 4]]),
    ):
        assert read_picture(content, "x", Budget()).tolist() == [expected]

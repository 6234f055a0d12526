"""Plugins are found by name and by path; a broken plugin is an error only when it is used."""

from __future__ import annotations

import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from oitbench.errors import DeclarationError, SceneError, UsageError
from oitbench.places import Places, own_folder
from oitbench.plugins import Collection

METHOD = """import oitbench as oit


class Mine(oit.Method):
    strength = oit.Parameter(3)

    def plan(self, request):
        return oit.Plan({"color": oit.Target("rgba16f")})
"""
SCENE = '''"""One wall."""
from oitbench import Parameter
from oitbench.modeling.mesh import quad
from oitbench.scene import Camera, Material, Object, Scene

parameters = {"alpha": Parameter(0.5, low=0.0, high=1.0)}


def build(*, name: str, alpha: float) -> Scene:
    wall = Object("wall", quad((0, 0, -2), (1, 0, 0), (0, 1, 0)), Material(coverage=alpha))
    return Scene(name, Camera((0, 0, 0), (0, 0, -1)), (wall,))
'''

REPORT = '''"""A report."""
title = "Mine"


def build(context):
    return []
'''


def write_file(folder: Path, text: str) -> Path:
    """Write the folder of a method without shaders."""
    folder.mkdir(parents=True)
    (folder / "method.py").write_text(text)
    return folder


@pytest.fixture
def foreign(tmp_path: Path) -> Path:
    """A foreign collection with one working and one broken plugin of each kind."""
    folder = tmp_path / "other place"
    write_file(folder / "methods" / "mine", METHOD)
    write_file(folder / "methods" / "broken", "import no_such_module\n")
    for kind in ("scenes", "reports"):
        (folder / kind).mkdir()
        (folder / kind / "broken.py").write_text("this is no Python\n")
    (folder / "scenes" / "wall.py").write_text(SCENE)
    (folder / "reports" / "mine.py").write_text(REPORT)
    return folder


def test_the_suite_has_its_own_plugins() -> None:
    found = Collection.load()
    assert {"a_buffer", "alpha_blend", "weighted_blended"} <= set(found.methods)
    assert {"layer_stack", "fragment_lists"} <= set(found.scenes)
    assert own_folder() in found.folders


def test_the_name_of_a_link_decides_what_a_scene_is(tmp_path: Path) -> None:
    payload = tmp_path / "payload.py"
    payload.write_text(f"open({str(tmp_path / 'ran')!r}, 'w')\n{SCENE}")
    (tmp_path / "scene.glb").symlink_to(payload)
    with pytest.raises(SceneError, match="its JSON cannot be read"):
        Collection(Places()).build_scene(str(tmp_path / "scene.glb"))
    assert not (tmp_path / "ran").exists()
    # Stores of files name them by their digests.
    (tmp_path / "blobs").mkdir()
    blob = tmp_path / "blobs" / "3fa9"
    blob.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    (tmp_path / "model.obj").symlink_to(blob)
    places = Places()
    assert Collection(places).build_scene(str(tmp_path / "model.obj")).name == "model"
    assert places.scene_files == (tmp_path.resolve() / "model.obj",)
    # Another way to the same file is no second scene of that name.
    assert places.find_scene(str(tmp_path / "blobs" / ".." / "model.obj")) == "model"


def test_plugins_are_found_from_any_folder(foreign: Path) -> None:
    script = (
        "from oitbench.plugins import Collection;"
        f"c = Collection.load([{str(foreign)!r}]);"
        "print('a_buffer' in c.methods, 'mine' in c.methods, c.build_scene('wall').name)"
    )
    answer = subprocess.run(
        [sys.executable, "-c", script], cwd=foreign, capture_output=True, text=True, check=True
    )
    assert answer.stdout.split() == ["True", "True", "wall"]


def test_plugins_of_a_foreign_collection_are_added(foreign: Path) -> None:
    found = Collection.load([foreign])
    (mine,) = found.expand_methods(["mine[strength=5]"])
    assert (mine.label, mine.values) == ("mine[strength=5]", {"strength": 5})
    assert mine.folders == (foreign / "methods" / "mine",)
    assert found.build_scene("wall[alpha=0.25]").objects[0].material.coverage == 0.25
    assert found.reports["mine"].__doc__ == "A report."
    assert "a_buffer" in found.methods


@pytest.mark.parametrize("kind", ["method", "scene", "report"])
def test_plugins_with_the_same_name_are_refused(kind: str, foreign: Path, tmp_path: Path) -> None:
    other = tmp_path / "other"
    shutil.copytree(foreign, other)
    for folder in (foreign, other):
        for name in {"method", "scene", "report"} - {kind}:
            shutil.rmtree(folder / f"{name}s")
    with pytest.raises(UsageError, match=f"two {kind}s are named") as caught:
        Collection.load([foreign, other])
    assert str(foreign) in str(caught.value)
    assert str(other) in str(caught.value)


def test_a_folder_that_is_given_twice_is_added_once(foreign: Path) -> None:
    found = Collection.load([foreign, foreign / "methods" / ".."])
    assert found.folders.count(foreign) == 1


def test_only_a_method_of_the_suite_can_be_the_truth(foreign: Path) -> None:
    write_file(foreign / "methods" / "mythical", METHOD + "    truth = {}\n")
    found = Collection.load([foreign])
    with pytest.raises(DeclarationError, match="only the suite's own method can be the truth"):
        found.methods["mythical"]
    assert found.truth().name == "a_buffer"


def test_methods_of_a_collection_share_its_shaders(foreign: Path) -> None:
    (foreign / "glsl").mkdir()
    found = Collection.load([foreign])
    folder = foreign / "methods" / "mine"
    assert found.methods["mine"].folders == (folder, foreign / "glsl")


def test_a_broken_plugin_is_an_error_only_when_it_is_used(foreign: Path) -> None:
    found = Collection.load([foreign])
    assert "broken" in list(found.methods)
    assert found.truth().name == "a_buffer"
    with pytest.raises(DeclarationError, match=r"broken/method\.py:1: ModuleNotFoundError"):
        found.expand_methods(["broken"])
    with pytest.raises(DeclarationError, match=r"scenes/broken\.py:1: SyntaxError"):
        found.build_scene("broken")
    with pytest.raises(DeclarationError, match=r"reports/broken\.py"):
        found.reports["broken"]


def test_a_method_can_be_the_path_of_its_folder(foreign: Path) -> None:
    folder = foreign / "methods" / "mine"
    (mine,) = Collection.load().expand_methods([f"{folder}[strength=7]"])
    assert mine.label == "mine[strength=7]"


def test_a_relative_path_starts_at_the_current_folder(
    foreign: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(foreign / "methods")
    (mine,) = Collection.load().expand_methods(["mine"])
    assert mine.name == "mine"


def test_folders_whose_names_differ_only_in_punctuation_are_distinct(tmp_path: Path) -> None:
    folders = [write_file(tmp_path / name, METHOD) for name in ("my-way", "my_way", "my.way")]
    found = Collection.load().expand_methods([str(folder) for folder in folders])
    assert [item.folders[0] for item in found] == folders


def test_unknown_names_and_paths_are_refused(tmp_path: Path) -> None:
    found = Collection.load()
    with pytest.raises(UsageError, match="unknown method 'a_bufer'; did you mean a_buffer"):
        found.expand_methods(["a_bufer"])
    with pytest.raises(UsageError, match="unknown scene 'layers_stack'; did you mean layer_stack"):
        found.build_scene("layers_stack")
    with pytest.raises(UsageError, match=r"is no method; it has no method\.py"):
        found.expand_methods([str(tmp_path / "nowhere")])
    with pytest.raises(UsageError, match="is no collection"):
        Collection.load([tmp_path / "nowhere"])
    with pytest.raises(UsageError, match="selects 2 scenes; name one"):
        found.build_scene("layer_stack[count=1,2]")


def test_a_file_must_define_exactly_one_method(tmp_path: Path) -> None:
    none = write_file(tmp_path / "none", "import oitbench as oit\n")
    two = write_file(tmp_path / "two", METHOD + METHOD.replace("Mine", "Yours"))
    for folder, count in ((none, 0), (two, 2)):
        with pytest.raises(DeclarationError, match=f"defines {count} methods; define exactly one"):
            Collection.load().expand_methods([str(folder)])


def test_a_scene_must_define_its_parameters(foreign: Path) -> None:
    (foreign / "scenes" / "silent.py").write_text("def build() -> None: ...\n")
    with pytest.raises(DeclarationError, match=r"silent\.py: defines no 'parameters'"):
        Collection.load([foreign]).build_scene("silent")


def test_a_scene_that_states_its_near_plane_has_it_as_a_parameter(foreign: Path) -> None:
    path = foreign / "scenes" / "close.py"
    units = SCENE.replace("(wall,))", "(wall,), meters_per_unit=0.1)")
    path.write_text(units.replace("parameters =", "near = 0.05\nparameters ="))
    collection = Collection.load([foreign])
    assert collection.scenes["close"].parameters["near"].default == 0.05
    for label, near in (("close", 0.05), ("close[near=0.02]", 0.02)):
        scene = collection.build_scene(label)
        assert scene.name == label
        assert scene.in_meters().camera.near == pytest.approx(near)
    with pytest.raises(UsageError, match="near is 0"):
        collection.build_scene("close[near=0]")
    path.write_text(SCENE.replace("parameters =", "near = -1.0\nparameters ="))
    with pytest.raises(DeclarationError, match=r"close\.py: near is -1\.0; give a float"):
        _ = Collection.load([foreign]).scenes["close"]


def test_the_collection_of_an_installed_package_is_found(
    foreign: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    package = tmp_path / "site"
    (package / "extra").mkdir(parents=True)
    (package / "extra" / "__init__.py").write_text(f"FOLDER = {str(foreign)!r}\n")
    facts = package / "extra-1.0.dist-info"
    facts.mkdir()
    (facts / "METADATA").write_text("Metadata-Version: 2.1\nName: extra\nVersion: 1.0\n")
    (facts / "entry_points.txt").write_text("[oitbench.collections]\nextra = extra:FOLDER\n")
    monkeypatch.syspath_prepend(str(package))
    found = Collection.load()
    assert foreign in found.folders
    assert "mine" in found.methods


def test_files_with_an_underscore_are_no_plugins(foreign: Path) -> None:
    (foreign / "scenes" / "_helpers.py").write_text("")
    write_file(foreign / "methods" / "_draft", METHOD)
    found = Collection.load([foreign])
    assert "_helpers" not in found.scenes
    assert "_draft" not in found.methods

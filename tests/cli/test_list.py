"""`oitbench list`: methods, scenes and their parameters."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from oitbench.catalog.catalog import Catalog
from oitbench.catalog.messages import Entry, Kind
from tests.cli.helpers import Call
from tests.helpers import write_method


def test_methods_scenes_and_parameters_are_listed(call: Call) -> None:
    answer = call("list", "methods", "--json")
    assert answer.code == 0
    methods = {entry["name"]: entry for entry in json.loads(answer.out)}
    assert methods["a_buffer"]["parameters"]["node"]["choices"] == ["precise", "compact"]
    assert methods["a_buffer"]["title"].startswith("A-buffer")
    assert methods["a_buffer"]["no_msaa"] == ""
    assert methods["depth_peeling"]["no_msaa"]
    answer = call("list")
    assert answer.code == 0
    assert f"one sample per pixel: {methods['depth_peeling']['no_msaa']}" in answer.out
    assert "layer_stack" in answer.out
    assert "colored_transmission" in answer.out


def test_a_broken_plugin_is_listed_as_such(call: Call, tmp_path: Path) -> None:
    (tmp_path / "methods" / "unreadable").mkdir(parents=True)
    (tmp_path / "methods" / "unreadable" / "method.py").write_text("this is no Python\n")
    answer = call("list", "methods", "--collection", tmp_path)
    assert answer.code == 0
    assert "cannot be loaded" in answer.out
    assert "a_buffer" in answer.out


def test_a_scene_is_asked_for_once(
    call: Call, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    good = (
        '"""One view."""\nfrom oitbench.modeling.mesh import quad\n'
        "from oitbench.scene import Camera, Material, Object, Scene\nparameters = {}\n"
        "def build(*, name):\n    mesh = quad((0, 0, -2), (1, 0, 0), (0, 1, 0))\n"
        "    camera = Camera((0, 0, 0), (0, 0, -1))\n"
        "    return Scene(name, camera, (Object('wall', mesh, Material()),))\n"
    )
    (tmp_path / "scenes").mkdir()
    (tmp_path / "scenes" / "good.py").write_text(good)
    leaving = good.replace("    return", "    __import__('os')._exit(5)\n    return")
    (tmp_path / "scenes" / "leaving.py").write_text(leaving)
    asked: list[tuple[str, bool]] = []
    ask = Catalog.entry

    def entry(self: Catalog, kind: Kind, name: str, check: bool = False) -> Entry:
        asked.append((name, check))
        return ask(self, kind, name, check)

    monkeypatch.setattr(Catalog, "entry", entry)
    monkeypatch.setattr(Catalog, "names", lambda self, kind: ["good", "leaving"])
    answer = call("list", "scenes", "--json", "--collection", tmp_path)
    found = {item["name"]: item for item in json.loads(answer.out)}
    assert (found["good"]["title"], found["good"]["views"][0]) == ("One view.", "main")
    assert (found["leaving"]["title"], found["leaving"]["views"]) == ("One view.", [])
    assert asked == [("good", True), ("leaving", True), ("leaving", False)]


def test_a_method_that_ends_its_process_is_missing_in_the_measured_table(
    call: Call, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    write_method(tmp_path / "methods" / "leaving", "__import__('os')._exit(0)")
    monkeypatch.setattr(Catalog, "names", lambda self, kind: ["leaving", "weighted_sum"])
    answer = call("list", "methods", "--measure", "--collection", tmp_path)
    assert answer.code == 1
    assert [line.split()[1] for line in answer.out.splitlines()[2:]] == ["`weighted_sum`"]
    assert answer.err.startswith("failed leaving: the worker process ended with code 0")


def test_classes_of_methods_are_a_table_or_json(call: Call) -> None:
    options = ("--class", "--method", "weighted_blended[msaa=1,4]")
    answer = call("list", "methods", *options)
    assert answer.code == 0
    rows = [line.split(" | ") for line in answer.out.splitlines()[2:]]
    assert [(row[0], row[1], row[7]) for row in rows] == [
        ("| `weighted_blended`", "multiple targets", "72"),
        ("| `weighted_blended[msaa=4]`", "multiple targets", "288"),
    ]
    found = json.loads(call("list", "methods", *options, "--json").out)
    assert [(row["method"], row["class"], row["samples"]) for row in found] == [
        ("weighted_blended", "targets", 1),
        ("weighted_blended[msaa=4]", "targets", 4),
    ]


@pytest.mark.parametrize(
    ("plan", "part"),
    [("None", "return an oit.Plan"), ('Plan({}, (Gather("a.glsl", writes={"x": ADD}),))', "'x'")],
)
def test_a_method_without_a_valid_plan_has_no_class(
    call: Call, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, plan: str, part: str
) -> None:
    folder = tmp_path / "methods" / "wrong"
    folder.mkdir(parents=True)
    (folder / "method.py").write_text(
        "from oitbench import *\n\n\nclass Wrong(Method):\n"
        f"    def plan(self, request):\n        return {plan}\n"
    )
    monkeypatch.setattr(Catalog, "names", lambda self, kind: ["wrong", "weighted_sum"])
    answer = call("list", "methods", "--class", "--collection", tmp_path)
    assert answer.code == 1
    assert [line.split()[1] for line in answer.out.splitlines()[2:]] == ["`weighted_sum`"]
    assert answer.err.startswith("failed wrong: ")
    assert part in answer.err


def test_classes_need_methods(call: Call) -> None:
    call("list", "scenes", "--class").assert_refused("oitbench list methods --class")
    call("list", "methods", "--method", "a_buffer").assert_refused("list methods --class")


def test_statistics_of_scenes_are_a_table_or_json(call: Call) -> None:
    options = ("--stats", "--size", "16x8", "--scene", "layer_stack[count=2,3]")
    answer = call("list", "scenes", *options)
    assert answer.code == 0
    rows = [line.split(" | ") for line in answer.out.splitlines()[2:]]
    assert [(row[0], row[6]) for row in rows] == [
        ("| `layer_stack[count=2]`", "256"),
        ("| `layer_stack[count=3]`", "384"),
    ]
    found = json.loads(call("list", "scenes", *options, "--json").out)
    assert [row["statistics"]["complexity"]["histogram"] for row in found] == [
        [[2, 128]],
        [[3, 128]],
    ]


def test_a_scene_that_cannot_be_built_is_missing_in_the_statistics(
    call: Call, plugins: Path
) -> None:
    options = ("--stats", "--size", "16x8", "--scene", "layer_stack", "--scene", "crasher")
    answer = call("list", "scenes", *options, "--collection", plugins)
    assert answer.code == 1
    assert len(answer.out.splitlines()) == 3
    assert answer.err.startswith("failed crasher:")


def test_statistics_need_scenes(call: Call) -> None:
    call("list", "methods", "--stats").assert_refused("oitbench list scenes --stats")
    call("list", "scenes", "--scene", "layer_stack").assert_refused("list scenes --stats")

"""A file that crashes, hangs or ends the process when it is loaded is only a broken entry."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from oitbench.catalog.catalog import Catalog, Choice
from oitbench.errors import UsageError

METHOD = '''"""Shows nothing.

More about it.
"""
import oitbench as oit


class Mine(oit.Method):
    strength = oit.Parameter(3, low=1, grid=(1, 2), help="how much")
    expresses = oit.Effect.COVERAGE
    promises = oit.promise("order_independent")
    quick = False
'''
SCENE = '''"""Nothing to see."""
from oitbench import Parameter
from oitbench.scene import Camera, Scene

parameters = {"depth": Parameter(0.5)}


def build(*, name, depth):
    return Scene(name, Camera((0, 0, 0), (0, 0, -1)))
'''
REPORT = '"""All of it."""\ntitle = "Mine"\n\n\ndef build(context):\n    return []\n'
FAULTS = {
    "exits": ("import os; os._exit(7)", "ended with code 7 while loading the file"),
    "crashes": ("import os; os.abort()", "ended by signal 6 (SIGABRT) while loading the file"),
    "hangs": ("while True: pass", "took longer than 10 s while loading the file"),
    "quits": ("raise SystemExit(3)", ":1: SystemExit: 3"),
    "interrupts": ("raise KeyboardInterrupt", "KeyboardInterrupt"),
    "grows": ("x = []\nwhile True: x.append(b'1' * 2**20)", "needs more than 0.391 GiB of memory"),
    "asks": ("input('name? ')", ":1: EOFError"),
    "endless": ("def f(): f()\nf()", ":1: RecursionError"),
    "wrong": ("this is no Python", ":1: SyntaxError"),
    "infinite": (
        "import oitbench\noitbench.Parameter(float('inf'))",
        ":2: a value of a parameter is inf",
    ),
}


def write_method(folder: Path, text: str) -> Path:
    folder.mkdir(parents=True)
    (folder / "method.py").write_text(text)
    return folder


@pytest.fixture(scope="module")
def faulty(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A collection with each fault, and a good plugin of each kind that comes last."""
    folder = tmp_path_factory.mktemp("faulty")
    for name, (text, _) in FAULTS.items():
        write_method(folder / "methods" / name, text)
    write_method(folder / "methods" / "zz_good", METHOD + 'print("hello")\n')
    (folder / "scenes").mkdir()
    (folder / "scenes" / "exits_too.py").write_text("import os; os._exit(0)")
    (folder / "scenes" / "shapeless.py").write_text("parameters = {'depth': 1}\nbuild = 2\n")
    (folder / "scenes" / "void.py").write_text(SCENE)
    (folder / "reports").mkdir()
    (folder / "reports" / "exits_also.py").write_text("import os; os._exit(9)")
    (folder / "reports" / "unread.py").write_text("(" * 10_000)
    (folder / "reports" / "whole.py").write_text(REPORT)
    return folder


@pytest.fixture(scope="module")
def catalog(faulty: Path) -> Iterator[Catalog]:
    with Catalog([faulty], memory_limit=400 * 2**20, load_seconds=10.0) as catalog:
        yield catalog


@pytest.mark.parametrize("name", FAULTS)
def test_a_fault_belongs_to_its_file(catalog: Catalog, faulty: Path, name: str) -> None:
    error = catalog.entry("method", name).error
    assert f"methods/{name}/method.py:" in error
    assert FAULTS[name][1] in error
    assert "\n" not in error


def test_plugins_beside_faulty_ones_are_described(catalog: Catalog) -> None:
    good = catalog.entry("method", "zz_good")
    assert (good.title, good.error, good.quick) == ("Shows nothing.", "", False)
    assert (good.expresses, good.promises) == (["coverage"], ["order_independent"])
    assert good.parameters["strength"].grid == (1, 2)
    assert (good.parameters["strength"].low, good.parameters["strength"].help) == (1, "how much")
    scene = catalog.entry("scene", "void")
    assert (scene.title, scene.parameters["depth"].default) == ("Nothing to see.", 0.5)
    assert type(scene.parameters["depth"].default) is float
    assert catalog.entry("report", "whole", check=True).title == "All of it."
    assert catalog.entry("method", "a_buffer").error == ""


def test_output_of_plugins_goes_to_standard_error(
    faulty: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    with Catalog([faulty]) as catalog:
        assert catalog.entry("method", "zz_good").error == ""
    printed = capfd.readouterr()
    assert printed.out == ""
    assert "hello" in printed.err


def test_faults_of_scenes_and_reports(catalog: Catalog) -> None:
    assert (
        "exits_too.py: the worker process ended with" in catalog.entry("scene", "exits_too").error
    )
    assert "map names to oit.Parameter" in catalog.entry("scene", "shapeless").error
    assert catalog.entry("report", "unread").error
    # A report is not loaded unless it is to be checked.
    assert catalog.entry("report", "exits_also").error == ""
    assert "ended with code 9" in catalog.entry("report", "exits_also", check=True).error


def test_a_scene_that_cannot_be_built_is_still_described(tmp_path: Path) -> None:
    (tmp_path / "scenes").mkdir()
    leaving = SCENE.replace("    return Scene", "    __import__('os')._exit(5)\n    return Scene")
    (tmp_path / "scenes" / "leaving.py").write_text(leaving)
    with Catalog([tmp_path]) as catalog:
        assert "ended with code 5" in catalog.entry("scene", "leaving", check=True).error
        assert catalog.entry("scene", "leaving").title == "Nothing to see."
        assert "ended with code 5" in catalog.entry("scene", "leaving", check=True).error
        (choice,) = catalog.expand_scenes(["leaving[depth=1]"])
        assert (choice.label, choice.error) == ("leaving[depth=1]", "")


def test_a_file_is_inspected_once(tmp_path: Path) -> None:
    file = tmp_path / "card.obj"
    file.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    with Catalog() as catalog:
        one, other = catalog.expand_scenes([str(file), f"{file}[up=z]"])
        found = catalog.inspect(one)
        assert catalog.inspect(one) is found
        assert catalog.inspect(other) is not found


def test_no_file_is_loaded_into_this_process(catalog: Catalog) -> None:
    catalog.entry("method", "zz_good")
    catalog.entry("scene", "void")
    assert not [name for name in sys.modules if "zz_good" in name or name.endswith("void")]


def test_selectors_are_expanded(catalog: Catalog) -> None:
    chosen = catalog.expand_methods(["zz_good[strength=3,4]", "zz_good", "exits[a=1,2,b=x]"])
    assert [(choice.label, choice.name) for choice in chosen] == [
        ("zz_good", "zz_good"),
        ("zz_good[strength=4]", "zz_good"),
        ("exits[a=1,b=x]", "exits"),
        ("exits[a=2,b=x]", "exits"),
    ]
    assert [bool(choice.error) for choice in chosen] == [False, False, True, True]
    assert catalog.expand_scenes(["void[depth=0.50]"]) == [Choice("void", "void")]
    with pytest.raises(UsageError, match="strength is 0; it must be at least 1"):
        catalog.expand_methods(["zz_good[strength=0]"])
    with pytest.raises(UsageError, match="unknown method 'zz_god'; did you mean zz_good"):
        catalog.expand_methods(["zz_god"])


def test_a_method_can_be_a_folder(catalog: Catalog, tmp_path: Path) -> None:
    folder = write_method(tmp_path / "elsewhere", METHOD)
    (choice,) = catalog.expand_methods([f"{folder}[strength=9]"])
    assert choice.label == "elsewhere[strength=9]"
    assert catalog.path("method", "elsewhere") == folder / "method.py"


def test_a_scene_that_cannot_be_built_has_no_axes(catalog: Catalog, tmp_path: Path) -> None:
    scenes = catalog.expand_scenes(["shadow_trio[detail=0.05]", "exits_too"])
    methods = catalog.expand_methods(["sorted_over", "exits"])
    axes = catalog.effects_axes(scenes[0], methods, None)
    assert set(axes) == {"sorted_over"}
    assert axes["sorted_over"][:2] == ["requested", "-shadows"]
    assert catalog.effects_axes(scenes[1], methods, None) == {}


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("import os; os._exit(5)", "collection extra:FOLDER: the worker process ended with code 5"),
        ("raise ValueError('no')", "extra/__init__.py:1: ValueError: no"),
    ],
)
def test_an_installed_collection_that_fails_is_left_out(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    caplog: pytest.LogCaptureFixture,
    text: str,
    message: str,
) -> None:
    (tmp_path / "extra").mkdir()
    (tmp_path / "extra" / "__init__.py").write_text(text)
    facts = tmp_path / "extra-1.0.dist-info"
    facts.mkdir()
    (facts / "METADATA").write_text("Metadata-Version: 2.1\nName: extra\nVersion: 1.0\n")
    (facts / "entry_points.txt").write_text("[oitbench.collections]\nextra = extra:FOLDER\n")
    monkeypatch.syspath_prepend(str(tmp_path))
    with Catalog() as catalog:
        (problem,) = catalog.problems
        assert message in problem
        assert "a_buffer" in catalog.names("method")
    assert message in caplog.text


def test_names_that_no_record_could_hold_are_refused(tmp_path: Path) -> None:
    folder = Path(os.fsdecode(os.fsencode(tmp_path) + b"/caf\xe9"))
    write_method(Path(os.fsdecode(os.fsencode(folder) + b"/methods/m\xe9thode")), METHOD)
    write_method(folder / "methods" / "good", METHOD)
    with Catalog([folder]) as catalog:
        assert catalog.entry("method", "good").error == ""
        broken = catalog.entry("method", r"m\udce9thode").error
        assert broken.endswith("the name is not printable UTF-8; rename the file or folder")
        assert r"caf\udce9" in broken

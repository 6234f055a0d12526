"""Faults of methods and scenes: each is one line that names the file and the fault."""

from __future__ import annotations

from pathlib import Path

import pytest

from oitbench.errors import OitbenchError, SceneError
from oitbench.gl.device import Device
from oitbench.plugins import Collection
from tests.helpers import Layer, render, stack

METHOD = '''"""A method."""
import oitbench as oit


class Mine(oit.Method):
    expresses = oit.Effect.COVERAGE
    promises = oit.promise("order_independent")

    def plan(self, request: oit.Request) -> oit.Plan:
        targets = {"sum": oit.Target("rgba16f")}
        gather = oit.Gather("gather.glsl", writes={"sum": oit.ADD})
        resolve = oit.Resolve("resolve.glsl", reads=("sum",), writes={"color": oit.OVER})
        return oit.Plan(targets, (gather, resolve))
'''
GATHER = "void gather(Fragment fragment) {\n    sum = premultiplied(fragment);\n}\n"
RESOLVE = '#include "part.glsl"\nvoid resolve() {\n    color = part(read_sum());\n}\n'
PART = "vec4 part(vec4 x) {\n    return x;\n}\n"
FILES = {"method.py": METHOD, "gather.glsl": GATHER, "resolve.glsl": RESOLVE, "part.glsl": PART}
SCENE = '''"""A scene."""
from oitbench.modeling.mesh import quad
from oitbench.scene import Camera, Material, Object, Scene

parameters = {}


def build(*, name: str) -> Scene:
    camera = Camera((0, 0, 0), (0, 0, -1))
    pane = Object("pane", quad((0, 0, -2), (1, 0, 0), (0, 1, 0)), Material(coverage=0.5))
    return Scene(name, camera, (pane,))
'''


def fault(device: Device, folder: Path, file: str, right: str, wrong: str) -> str:
    """Return the message of a method in which one text of one file is replaced."""
    folder.mkdir()
    for name, text in FILES.items():
        assert name != file or right in text
        (folder / name).write_text(text.replace(right, wrong) if name == file else text)
    with pytest.raises(OitbenchError) as caught:
        render_one_layer(device, folder)
    message = str(caught.value)
    assert "\n" not in message
    return message


def render_one_layer(device: Device, folder: Path) -> None:
    (method,) = Collection.load().expand_methods([str(folder)])
    render(device, stack([Layer(2, 0.5)]), method)


def test_the_method_of_these_tests_is_right(device: Device, tmp_path: Path) -> None:
    for name, text in FILES.items():
        (tmp_path / name).write_text(text)
    render_one_layer(device, tmp_path)


@pytest.mark.parametrize(
    ("right", "wrong", "message"),
    [
        ("import oitbench", "import oitbenhc", "method.py:2: ModuleNotFoundError"),
        ("class Mine(oit", "class Mine(oit,", "method.py:5: SyntaxError"),
        ("Effect.COVERAGE", "Effect.COVERGE", "method.py:6: AttributeError: COVERGE; did you mean"),
        ("order_independent", "order_indepent", "method.py:7: unknown promise 'order_indepent'"),
        ("promises =", "promisses =", "unknown member promisses; did you mean promises?"),
        ("expresses =", "expreses =", "unknown member expreses; did you mean expresses?"),
        ('oit.promise("order_independent")', '"order_independent"', "write oit.promise"),
        ("expresses = oit.Effect.COVERAGE", "expresses = 1", "expresses is 1; combine oit.Effect"),
        ("    promises =", "    views = {'x': 1}\n    promises =", "views is {'x': 1}; map names"),
        ("oit.ADD", "oit.AD", "method.py:11: AttributeError: module 'oitbench' has no attribute"),
        ("        return oit.Plan", "        oit.Plan", "plan returns None; return an oit.Plan"),
        ("(gather, resolve))", "(gather, None))", "passes hold None; a pass is Gather or Resolve"),
        ('"rgba16f"', '"rgba16"', "method.py:10: unknown texture format 'rgba16'; did you mean"),
        ('"rgba16f")', '"rgba16f", clear=(1.0, 0.0))', "method.py:10: target: clear has 2 values"),
        ('reads=("sum",)', 'reads=("sun",)', "resolve.glsl: unknown target 'sun'; did you mean"),
        ("(gather, resolve)", "(resolve,)", "resolve.glsl: reads 'sum', but no pass writes it"),
        ('"gather.glsl"', '"gathr.glsl"', "no shader 'gathr.glsl' in"),
    ],
)
def test_faults_of_a_declaration(
    device: Device, tmp_path: Path, right: str, wrong: str, message: str
) -> None:
    assert message in fault(device, tmp_path / "mine", "method.py", right, wrong)


@pytest.mark.parametrize(
    ("file", "right", "wrong", "message"),
    [
        ("resolve.glsl", "part.glsl", "prt.glsl", "resolve.glsl:1: there is no shader 'prt.glsl'"),
        ("resolve.glsl", "part.glsl", "prt.glsl", "did you mean part.glsl?"),
        ("resolve.glsl", "void resolve", "void reslve", "defines no 'void resolve()'"),
        ("gather.glsl", "void gather", "void gathr", "no 'void gather(Fragment fragment)'"),
        ("gather.glsl", "sum = premultiplied(fragment);", "", "never assigns its output 'sum'"),
        ("part.glsl", "return x;", "return 1;", "part.glsl:2: error"),
        ("resolve.glsl", "read_sum()", "read_sun()", "resolve.glsl:3: error"),
    ],
)
def test_faults_of_a_shader(
    device: Device, tmp_path: Path, file: str, right: str, wrong: str, message: str
) -> None:
    assert message in fault(device, tmp_path / "mine", file, right, wrong)


@pytest.mark.parametrize(
    ("right", "wrong", "message"),
    [
        ("return Scene(name", "Scene(name", "build returns None; return a Scene"),
        ("Scene(name, camera", "Scene(name, camra", "panes.py:11: NameError: name 'camra'"),
        (
            "(pane,))",
            "(pane,), background=(0, 0, float('nan')))",
            "panes.py:11: scene panes: backg",
        ),
        ("(0, 0, -1))", "(0, 0, 0))", "panes.py:9: camera: position and target coincide"),
    ],
)
def test_faults_of_a_scene(tmp_path: Path, right: str, wrong: str, message: str) -> None:
    (tmp_path / "scenes").mkdir()
    assert right in SCENE
    (tmp_path / "scenes" / "panes.py").write_text(SCENE.replace(right, wrong))
    with pytest.raises(SceneError) as caught:
        Collection.load([tmp_path]).build_scene("panes")
    assert str(caught.value).count("scene panes: ") == 1
    assert message in str(caught.value)


def test_a_known_name_goes_before_a_folder_of_the_working_directory(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = tmp_path / "alpha_blend"
    folder.mkdir()
    (folder / "method.py").write_text(METHOD)
    monkeypatch.chdir(tmp_path)
    (known,) = Collection.load().expand_methods(["alpha_blend"])
    assert known.folders[0] != folder
    with pytest.raises(OitbenchError, match="two methods are named"):
        Collection.load().expand_methods(["./alpha_blend"])


def test_members_that_resemble_no_other_are_allowed(tmp_path: Path) -> None:
    text = METHOD.replace("    promises", "    taps = 7\n    promises")
    (tmp_path / "method.py").write_text(text)
    (method,) = Collection.load().expand_methods([str(tmp_path)])
    assert method.name == tmp_path.name

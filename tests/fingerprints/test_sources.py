"""Fingerprints of code: prose and layout do not matter, everything else does."""

from __future__ import annotations

import ast
import shutil
from pathlib import Path

import pytest

from oitbench.fingerprints import code
from oitbench.fingerprints.code import method_fingerprint
from oitbench.fingerprints.sources import glsl_code, python_code, sources_digest
from tests.helpers import collection, foreign_method, write_method

PYTHON = '''"""A module."""

x = 1  # one


class A:
    """A class."""

    y: int = 2
    """A field."""

    def f(self):
        """Say nothing."""
        return "text"
'''


@pytest.mark.parametrize(
    "changed",
    [
        PYTHON.replace("A module", "Something else"),
        PYTHON.replace("# one", "# two").replace("x = 1  ", "x = 1 "),
        PYTHON.replace("A class", "B").replace("A field", "C").replace("Say nothing", "D"),
        PYTHON.replace('    """A field."""\n', ""),
        PYTHON.replace("\n\n", "\n").replace('"text"', "('text')"),
    ],
)
def test_prose_and_layout_of_python_do_not_matter(changed: str) -> None:
    assert changed != PYTHON
    assert python_code(changed) == python_code(PYTHON)


@pytest.mark.parametrize(
    ("old", "new"), [("x = 1", "x = 2"), ("y: int", "y: str"), ('"text"', '"test"'), ("f(", "g(")]
)
def test_code_of_python_matters(old: str, new: str) -> None:
    assert python_code(PYTHON.replace(old, new)) != python_code(PYTHON)


GLSL = """// A shader.
#define A 1  /* one */
float f(float x) {
    return x * 2.0; // twice \\
        return 0.0;
}
"""


def test_prose_and_layout_of_glsl_do_not_matter() -> None:
    assert glsl_code(GLSL) == "#define A 1\nfloat f(float x) {\nreturn x * 2.0;\n}"
    assert glsl_code("a/* b\nc */d") == glsl_code("a d")
    assert glsl_code("a /*/ b */ c // d") == "a c"


def test_code_of_glsl_matters() -> None:
    for old, new in (("2.0", "2.02"), ("A 1", "A 2"), ("x *", "x +")):
        assert glsl_code(GLSL.replace(old, new)) != glsl_code(GLSL)


def test_files_that_cannot_be_parsed_have_digests(tmp_path: Path) -> None:
    contents = [b"x = (", b"x = [", b"\xff\xfe", b"x = 1", b"(" * 5000 + b")" * 5000]
    digests = set()
    for number, content in enumerate(contents):
        path = tmp_path / f"{number}.py"
        path.write_bytes(content)
        digests.add(sources_digest({"same": path}))
    assert len(digests) == len(contents)


def written(folder: Path) -> str:
    return method_fingerprint(foreign_method(folder))


def test_every_file_of_a_method_matters_except_prose(tmp_path: Path) -> None:
    folder = write_method(
        tmp_path / "mine", '(Gather("draw.glsl", writes={"color": ADD}),)', draw="void gather() {}"
    )
    found = [written(folder)]
    for name, text in (
        ("draw.glsl", "void gather() { discard; }"),
        ("table.csv", "1,2"),
        ("table.csv", "1,3"),
        ("parts/more.glsl", "float x;"),
        ("method.py", (folder / "method.py").read_text().replace("ADD", "OVER")),
    ):
        (folder / name).parent.mkdir(exist_ok=True)
        (folder / name).write_text(text)
        found.append(written(folder))
    assert len(set(found)) == len(found)
    for name, text in (
        ("README.md", "words"),
        ("draw.glsl", "// words\nvoid gather() { discard; } // more"),
        ("method.py", "# words\n" + (folder / "method.py").read_text()),
        ("__pycache__/method.pyc", "x"),
        (".git/config", "x"),
        ("results/cells.jsonl", "x"),
    ):
        (folder / name).parent.mkdir(exist_ok=True)
        (folder / name).write_text(text)
        assert written(folder) == found[-1], name
    moved = shutil.copytree(folder, tmp_path / "elsewhere" / "mine")
    assert written(moved) == found[-1]


def test_parameters_and_shaders_of_the_collection_matter(tmp_path: Path) -> None:
    folder = write_method(
        tmp_path / "methods" / "mine", "()", members="p = Parameter(1.0, low=0.0, high=9.0)"
    )
    (tmp_path / "glsl").mkdir()
    shared = tmp_path / "glsl" / "shared.glsl"
    found = []
    for text in ("float x;", "float y;"):
        shared.write_text(text)
        kind = type(foreign_method(folder))
        found += [method_fingerprint(kind(p=value)) for value in (1.0, 1 + 1e-15)]
    assert len(set(found)) == 4


def test_the_sources_of_the_engine_exist_and_differ_from_those_of_the_metrics() -> None:
    named = (*code._ENGINE, *code._TIMING, *code._METRICS)
    files = code._own_files(named)
    assert all(path.is_file() for path in files.values())
    for name in named:
        assert any(file == name or file.startswith(f"{name}/") for file in files), name
    expected = {"gl/shaders/shading.glsl", "gl/frame.py", "scene/texturing.py", "matrix/bench.py"}
    assert expected <= files.keys()
    assert code.engine_fingerprint() != code.metrics_fingerprint()
    assert not any(name.startswith("cli/") for name in files)


def test_sources_of_timing_change_times_but_no_picture(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """Each source belongs to one fingerprint, so that another way of timing redraws nothing."""
    for name in ("measure/timing.py", "measure/oracle.py"):
        path = tmp_path / name
        path.parent.mkdir(exist_ok=True)
        path.write_text("x = 1\n")
    monkeypatch.setattr(code, "_PACKAGE", tmp_path)
    monkeypatch.setattr(code, "_ENGINE", ("measure",))
    monkeypatch.setattr(code, "_TIMING", ("measure/timing.py",))

    def both() -> tuple[str, str]:
        return code.engine_fingerprint.__wrapped__(), code.timing_fingerprint.__wrapped__()

    before = both()
    (tmp_path / "measure" / "timing.py").write_text("x = 2\n")
    timed = both()
    assert (timed[0] == before[0], timed[1] == before[1]) == (True, False)
    (tmp_path / "measure" / "oracle.py").write_text("x = 2\n")
    drawn = both()
    assert (drawn[0] == timed[0], drawn[1] == timed[1]) == (False, True)


def test_a_source_is_parsed_again_if_the_parser_was_interrupted(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    parse, failing = ast.parse, [SystemError("AST constructor recursion depth mismatch")]

    def interrupted(text: str) -> ast.Module:
        if failing:
            raise failing.pop()
        return parse(text)

    expected = python_code("x = 1\n")
    monkeypatch.setattr(ast, "parse", interrupted)
    assert python_code("x = 1\n") == expected
    assert not failing


def test_the_metrics_depend_on_their_packages(monkeypatch: pytest.MonkeyPatch) -> None:
    found = []
    for version in ("1.0", "1.1", None):
        monkeypatch.setattr(code, "package_version", lambda name, version=version: version)
        code.metrics_fingerprint.cache_clear()
        found.append(code.metrics_fingerprint())
    code.metrics_fingerprint.cache_clear()
    assert len(set(found)) == 3


def test_own_methods_have_different_fingerprints() -> None:
    methods = collection().expand_methods(list(collection().methods))
    assert len({method_fingerprint(method) for method in methods}) == len(methods)

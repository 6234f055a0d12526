"""The engine is independent of plugins, and the command line starts quickly."""

from __future__ import annotations

import ast
import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from oitbench.places import own_folder

ROOT = own_folder()
ENGINE = ROOT / "oitbench"
CONTENT = ("methods", "scenes", "reports")
ALLOWED = sys.stdlib_module_names | {"oitbench", "numpy", "matplotlib", "pandas"}
HEAVY = ("mitsuba", "drjit", "pandas", "matplotlib", "skimage", "flip_evaluator", "OpenEXR", "PIL")
ADAPTERS = ENGINE / "engines" / "adapters"
"""Adapters of other engines name the methods that they compare with."""
HOMONYMS = {"engine", "glow", "hair", "moments"}
"""Names of scenes and methods that are also words of the field."""
COMMENTS = {
    ".glsl": r"//[^\n]*|/\*.*?\*/",
    ".js": r"//[^\n]*|/\*.*?\*/",
    ".css": r"/\*.*?\*/",
    ".html": r"<!--.*?-->|\{#.*?#\}",
    ".mplstyle": r"#[^\n]*",
}


def content_names() -> set[str]:
    """Return the names of all scenes, methods and classes of methods."""
    names = {path.stem for path in (ROOT / "scenes").glob("*.py")}
    for path in (ROOT / "methods").glob("*/method.py"):
        names.add(path.parent.name)
        tree = ast.parse(path.read_text(encoding="utf-8"))
        names |= {node.name for node in tree.body if isinstance(node, ast.ClassDef)}
    return names - HOMONYMS


def words(source: str) -> Iterator[str]:
    """Yield the words of a Python file outside comments and docstrings."""
    nodes = list(ast.walk(ast.parse(source)))
    prose = {id(node.value) for node in nodes if isinstance(node, ast.Expr)}
    for node in nodes:
        if isinstance(node, ast.Constant) and id(node) in prose:
            continue
        for _, value in ast.iter_fields(node):
            if isinstance(value, str):
                yield value
            elif isinstance(value, list):
                yield from (item for item in value if isinstance(item, str))


def engine_text(path: Path) -> str:
    """Return the text of an engine file without comments and docstrings."""
    source = path.read_text(encoding="utf-8")
    if path.suffix == ".py":
        return "\n".join(words(source))
    return re.sub(COMMENTS[path.suffix], "", source, flags=re.DOTALL)


def mentions(text: str, names: set[str]) -> set[str]:
    """Return the `names` that `text` contains as words or as parts of identifiers."""
    return {n for n in names if re.search(rf"(?<![A-Za-z0-9]){re.escape(n)}(?![A-Za-z0-9])", text)}


def imports(path: Path) -> Iterator[str]:
    """Yield the modules that a Python file imports; "." for a relative import."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            yield "." if node.level else str(node.module)


def engine_files() -> list[Path]:
    return sorted(p for p in ENGINE.rglob("*") if p.suffix in (".py", *COMMENTS))


def content_files() -> list[Path]:
    return sorted(path for kind in CONTENT for path in (ROOT / kind).rglob("*.py"))


def relative(path: Path) -> str:
    return path.relative_to(ROOT).as_posix()


def test_names_are_found_only_in_code() -> None:
    names = {"glass", "Glass"}
    prose = '"""Of glass."""\nx = 1  # glass\n"""Of Glass."""\n'
    assert not mentions("\n".join(words(prose)), names)
    for code in ("glass = 1", "render_glass()", "a.glass", "def f(glass): ...", "x['the glass']"):
        assert mentions("\n".join(words(code)), names) == {"glass"}, code
    assert not mentions("glasses eyeglass", names)


@pytest.mark.parametrize(
    "path", [path for path in engine_files() if ADAPTERS not in path.parents], ids=relative
)
def test_the_engine_names_no_method_and_no_scene(path: Path) -> None:
    found = mentions(engine_text(path), content_names())
    assert not found, f"{relative(path)} names {', '.join(sorted(found))}"


@pytest.mark.parametrize("path", content_files(), ids=relative)
def test_plugins_import_no_other_plugins(path: Path) -> None:
    foreign = {name for name in imports(path) if name.partition(".")[0] not in ALLOWED}
    assert not foreign, f"{relative(path)} imports {', '.join(sorted(foreign))}"


@pytest.mark.parametrize("path", engine_files(), ids=relative)
def test_the_engine_imports_no_plugins(path: Path) -> None:
    if path.suffix == ".py":
        assert not {name.partition(".")[0] for name in imports(path)} & {*CONTENT, "tests", "."}


@pytest.mark.parametrize("path", sorted((ROOT / "methods").rglob("*.glsl")), ids=relative)
def test_shaders_include_only_files_of_their_method_and_of_the_engine(path: Path) -> None:
    for name in re.findall(r'#include\s+"([^"]+)"', path.read_text(encoding="utf-8")):
        folder, _, file = name.rpartition("/")
        places = {"": path.parent, "oitbench": ENGINE / "gl" / "shaders"}
        assert (places.get(folder, ENGINE / "method" / "kits" / folder) / file).is_file(), name


def test_the_list_command_imports_no_large_package() -> None:
    code = (
        "import sys\nfrom oitbench.cli import group\n"
        "group.main(['list'], standalone_mode=False)\n"
        f"print('loaded:', *[name for name in {HEAVY} if name in sys.modules])\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True, timeout=60
    )
    assert done.stdout.splitlines()[-1] == "loaded:"

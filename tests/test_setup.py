"""The wheel is complete: an installation without the checkout lists plugins and renders."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import sysconfig
import venv
import zipfile
from collections.abc import Sequence
from pathlib import Path

import pytest

from oitbench.places import KINDS, own_folder

ROOT = own_folder()


def call(arguments: Sequence[str | Path], folder: Path) -> str:
    """Run a command in a folder, without the tests' module path; return its output."""
    done = subprocess.run(
        [str(argument) for argument in arguments],
        cwd=folder,
        env={name: value for name, value in os.environ.items() if name != "PYTHONPATH"},
        capture_output=True,
        text=True,
        timeout=300,
    )
    assert done.returncode == 0, f"{arguments}\n{done.stdout}\n{done.stderr}"
    return done.stdout


def shipped(folder: Path) -> set[str]:
    """Return the files below `folder` that belong to the project."""
    paths = (path for path in folder.rglob("*") if path.is_file())
    return {p.relative_to(folder).as_posix() for p in paths if "__pycache__" not in p.parts}


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("wheel")
    options = ("--wheel", "--no-isolation", "--outdir", folder)
    call([sys.executable, "-m", "build", *options, ROOT], folder)
    (built,) = folder.glob("*.whl")
    return built


@pytest.fixture(scope="module")
def installed(wheel: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the `bin` folder of an environment that has the wheel.

    Dependencies and pip come from the environment of the tests. Its path files are not read, so
    the checkout is not found.
    """
    folder = tmp_path_factory.mktemp("environment")
    venv.create(folder, with_pip=False)
    programs = folder / "bin"
    (site,) = folder.glob("lib/python*/site-packages")
    borrowed = {sysconfig.get_path(name) for name in ("purelib", "platlib")}
    (site / "borrowed.pth").write_text("\n".join(sorted(borrowed)) + "\n", encoding="utf-8")
    # The installation of the checkout is visible too; it must stay as it is.
    install = ("install", "--quiet", "--no-deps", "--no-index", "--ignore-installed")
    call([programs / "python", "-m", "pip", *install, wheel], folder)
    return programs


def test_the_wheel_contains_engine_and_plugins(wheel: Path) -> None:
    names = {name for name in zipfile.ZipFile(wheel).namelist() if ".dist-info/" not in name}
    expected = {f"oitbench/{name}" for name in shipped(ROOT / "oitbench")}
    for kind in KINDS:
        expected |= {f"oitbench/collection/{kind}/{name}" for name in shipped(ROOT / kind)}
    expected.add("oitbench/collection/CITATION.cff")
    assert names == expected


def test_the_wheel_lists_the_methods_of_the_checkout(installed: Path, tmp_path: Path) -> None:
    where = call(
        [installed / "python", "-c", "import oitbench; print(oitbench.__file__)"], tmp_path
    )
    assert Path(where.strip()).is_relative_to(installed.parent)
    listed = json.loads(call([installed / "oitbench", "list", "--json"], tmp_path))
    here = {path.parent.name for path in (ROOT / "methods").glob("*/method.py")}
    assert {entry["name"] for entry in listed["methods"]} == here
    broken = [e for kind in listed.values() for e in kind if "cannot be loaded" in e["title"]]
    assert not broken


def test_the_wheel_renders(installed: Path, tmp_path: Path) -> None:
    from oitbench.image import files as images

    scene, method = "layer_stack[count=2,palette=gray]", "alpha_blend"
    render: list[str | Path] = [installed / "oitbench", "render", scene, method, "--size", "32x32"]
    call([*render, "-o", "picture.png"], tmp_path)
    call([*render, "-o", "picture.exr"], tmp_path)
    assert (tmp_path / "picture.png").read_bytes().startswith(b"\x89PNG")
    # Two layers of coverage 0.5 and radiance 0.5 over a background of 0.25.
    picture = images.read_exr(tmp_path / "picture.exr")
    assert picture.shape == (32, 32, 3)
    assert abs(picture - (0.5 * 0.75 + 0.25 * 0.25)).max() < 1e-3

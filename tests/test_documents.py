"""The pages say what is: links lead somewhere, verbs exist, commands and examples run."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path

import pytest

from oitbench.cli import VERBS
from oitbench.plugins import own_folder

ROOT = own_folder()
PAGES = sorted(ROOT.glob("*.md"))
FENCED = re.compile(r"^```(?P<kind>\w+)\n(?P<text>.*?)^```$", re.MULTILINE | re.DOTALL)
FILE = re.compile(r"`(?P<name>[\w./]+)`:\n\n\Z")


@dataclass(frozen=True)
class Block:
    """A fenced block: its language, its text, and the file that the line before it names."""

    kind: str
    text: str
    file: str | None


def blocks(page: str) -> Iterator[Block]:
    text = (ROOT / page).read_text(encoding="utf-8")
    for match in FENCED.finditer(text):
        named = FILE.search(text, 0, match.start())
        yield Block(match["kind"], match["text"], named["name"] if named else None)


def commands(page: str) -> list[str]:
    """Return the commands of a page, which stand behind a `$`."""
    consoles = [block.text for block in blocks(page) if block.kind == "console"]
    return [line.removeprefix("$ ") for text in consoles for line in text.splitlines()]


def anchors(page: Path) -> set[str]:
    headings = re.findall(r"^#+ (.*)$", page.read_text(encoding="utf-8"), re.MULTILINE)
    return {re.sub(r"[^\w -]", "", heading.lower()).replace(" ", "-") for heading in headings}


def call(command: str, folder: Path, cache: Path) -> None:
    """Run one line of a page as a reader would, with this environment's programs first."""
    programs = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    done = subprocess.run(
        command,
        shell=True,
        cwd=folder,
        env={**os.environ, "PATH": programs, "XDG_CACHE_HOME": str(cache)},
        capture_output=True,
        text=True,
        timeout=300,
    )
    assert done.returncode == 0, f"$ {command}\n{done.stdout}\n{done.stderr}"


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_links_lead_somewhere(page: Path) -> None:
    for target in re.findall(r"\]\(([^)\s]+)\)", page.read_text(encoding="utf-8")):
        if "://" in target:
            continue
        name, _, anchor = target.partition("#")
        linked = ROOT / name if name else page
        assert linked.exists(), f"{page.name} links to {target}"
        assert not anchor or anchor in anchors(linked), f"{page.name} links to {target}"


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_pages_name_files_that_exist(page: Path) -> None:
    text = page.read_text(encoding="utf-8")
    for name in re.findall(r"`((?:oitbench|methods|scenes|reports|tests)/[\w./]+)`", text):
        assert (ROOT / name).exists(), f"{page.name} names {name}"


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_verbs_exist(page: Path) -> None:
    text = page.read_text(encoding="utf-8")
    told = set(re.findall(r"(?:^\$ |`)oitbench ([a-z][a-z-]*)", text, re.MULTILINE))
    assert told <= set(VERBS), f"{page.name} names {sorted(told - set(VERBS))}"


def test_the_readme_names_every_verb() -> None:
    told = re.findall(r"^\| `oitbench ([a-z-]+)", (ROOT / "README.md").read_text(), re.MULTILINE)
    assert sorted(told) == sorted(VERBS)


def test_the_readme_names_scripts_that_can_be_run() -> None:
    scripts = {line for line in commands("README.md") if line.startswith("./")}
    assert scripts == {"./reproduce.sh", "./test.sh"}
    for name in (*scripts, ".ci/run"):
        assert os.access(ROOT / name, os.X_OK), name
        subprocess.run(["bash", "-n", str(ROOT / name)], check=True)


def test_the_readme_asks_for_what_can_be_had(tmp_path: Path) -> None:
    """Plan what the page asks for, without rendering it."""
    from oitbench.matrix.plan import plan_matrix

    (line,) = [line for line in commands("README.md") if line.startswith("oitbench run")]
    asked = {
        option: re.findall(rf"--{option} '?([^\s']+)'?", line) for option in ("scene", "method")
    }
    planned = plan_matrix(asked["scene"], asked["method"], out=tmp_path)
    assert len(planned.cells) == 3 * 3


def test_the_readmes_python_runs(tmp_path: Path) -> None:
    (example,) = [block.text for block in blocks("README.md") if block.kind == "python"]
    (tmp_path / "example.py").write_text(
        example.replace("size=(256, 256)", "size=(32, 32)"), encoding="utf-8"
    )
    call("python example.py", tmp_path, tmp_path / "cache")
    assert (tmp_path / "glass_bars.png").is_file()
    assert (tmp_path / "trial" / "cells.jsonl").is_file()


def test_the_walk_through_works(tmp_path: Path) -> None:
    """Do what CONTRIBUTING.md says, in an empty folder: files are written, commands are run."""
    work = tmp_path / "work"
    work.mkdir()
    for block in blocks("CONTRIBUTING.md"):
        if block.file is not None:
            (work / block.file).write_text(block.text, encoding="utf-8")
        elif block.kind == "console":
            for line in block.text.splitlines():
                assert line.startswith("$ "), line
                call(line.removeprefix("$ "), work, tmp_path / "cache")
    written = {path.name for path in work.iterdir()}
    assert {"glass_bars.png", "panes.png", "trial", "mine"} <= written
    page = (work / "trial" / "report" / "index.html").read_text(encoding="utf-8")
    for name in ("depth_average[power=0]", "weighted_blended", "errors.csv"):
        assert name in page
    assert (work / "mine" / "reference" / "manifest.json").is_file()


@pytest.mark.skipif(find_spec("ruff") is None, reason="needs ruff")
def test_the_walk_throughs_python_is_formatted(tmp_path: Path) -> None:
    for block in blocks("CONTRIBUTING.md"):
        if block.kind == "python" and block.file is not None:
            path = tmp_path / block.file.replace("/", "_")
            path.write_text(block.text, encoding="utf-8")
            options = ("--config", str(ROOT / "pyproject.toml"), str(path))
            for verb in (("format", "--check"), ("check", "--select=F,I")):
                ruff = (sys.executable, "-m", "ruff", *verb, *options)
                done = subprocess.run(ruff, capture_output=True, text=True)
                assert done.returncode == 0, done.stdout + done.stderr

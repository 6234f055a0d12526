"""Links, commands, tables and examples of the documents are correct."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest

from oitbench.cli import VERBS
from oitbench.gl.device import Device
from oitbench.method import demand_table
from oitbench.method.demands import default_demands
from oitbench.method.promises import PROMISES
from oitbench.places import own_folder
from oitbench.report import markdown
from oitbench.results.records import Results
from oitbench.scoring.metric import load_metric
from oitbench.stability import overview
from oitbench.truths import TRUTHS
from tests.helpers import collection
from tests.report.made_up import FACTS, finished

ROOT = own_folder()
PAGES = sorted(ROOT.glob("*.md"))
FENCED = re.compile(r"^```(?P<kind>\w+)\n(?P<text>.*?)^```$", re.MULTILINE | re.DOTALL)
FILE = re.compile(r"`(?P<name>[\w./]+)`:\n\n\Z")


@dataclass(frozen=True)
class Block:
    """A fenced block: its language, its text, and the file named in the line above it."""

    kind: str
    text: str
    file: str | None


def blocks(page: str) -> Iterator[Block]:
    text = (ROOT / page).read_text(encoding="utf-8")
    for match in FENCED.finditer(text):
        named = FILE.search(text, 0, match.start())
        yield Block(match["kind"], match["text"], named["name"] if named else None)


def commands(page: str) -> list[str]:
    """Return the commands of a page, which follow a `$`."""
    consoles = [block.text for block in blocks(page) if block.kind == "console"]
    return [line.removeprefix("$ ") for text in consoles for line in text.splitlines()]


def anchors(page: Path) -> set[str]:
    headings = re.findall(r"^#+ (.*)$", page.read_text(encoding="utf-8"), re.MULTILINE)
    return {re.sub(r"[^\w -]", "", heading.lower()).replace(" ", "-") for heading in headings}


def call(command: str, folder: Path, cache: Path) -> None:
    """Run one line of a page in a shell, with the programs of this environment first."""
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
def test_links_have_targets(page: Path) -> None:
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
        assert "NAME" in name or (ROOT / name).exists(), f"{page.name} names {name}"


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_commands_exist(page: Path) -> None:
    text = page.read_text(encoding="utf-8")
    named = set(re.findall(r"(?:^\$ |`)oitbench ([a-z][a-z-]*)", text, re.MULTILINE))
    assert named <= set(VERBS), f"{page.name} names {sorted(named - set(VERBS))}"


def test_the_readme_names_every_command() -> None:
    named = re.findall(r"^\| `oitbench ([a-z-]+)", (ROOT / "README.md").read_text(), re.MULTILINE)
    assert sorted(named) == sorted(VERBS)


def test_scripts_in_the_readme_are_executable() -> None:
    scripts = {line for line in commands("README.md") if line.startswith("./")}
    assert scripts == {"./reproduce.sh", "./test.sh"}
    for name in (*scripts, ".ci/run"):
        assert os.access(ROOT / name, os.X_OK), name
        subprocess.run(["bash", "-n", str(ROOT / name)], check=True)


@pytest.mark.parametrize(("number", "cells"), [(0, 25 * 4), (1, 3 * 3)])
def test_runs_in_the_readme_can_be_planned(number: int, cells: int, tmp_path: Path) -> None:
    from oitbench.matrix.plan import plan_matrix

    line = [line for line in commands("README.md") if line.startswith("oitbench run")][number]
    scenes, methods, presets = (
        re.findall(rf"--{option} '?([^\s']+)'?", line) for option in ("scene", "method", "preset")
    )
    planned = plan_matrix(scenes, methods, (presets or ["quick"])[0], out=tmp_path)
    assert len(planned.cells) == cells


def table(page: str, name: str) -> list[list[str]]:
    """Return the cells of the table between the comments `name` and `/name` of a page."""
    text = (ROOT / page).read_text(encoding="utf-8")
    found = re.search(rf"<!-- {name} -->\n(.*?)<!-- /{name} -->", text, re.DOTALL)
    assert found is not None
    return rows_of(found[1])


def rows_of(text: str) -> list[list[str]]:
    lines = [line for line in text.splitlines() if line.startswith("|")]
    return [[cell.strip() for cell in line.strip("|").split(" | ")] for line in lines]


def test_the_table_of_promises_equals_that_of_the_code() -> None:
    rows = rows_of((ROOT / "CONVENTIONS.md").read_text(encoding="utf-8"))
    found = {row[0]: row[1] for row in rows if row[0].strip("`") in PROMISES}
    assert found == {f"`{name}`": sentence for name, sentence in PROMISES.items()}


def test_the_table_of_methods_equals_that_of_the_command(
    device: Device, overviews: dict[str, overview.Overview]
) -> None:
    expected = rows_of(overview.table(list(overviews.values())))
    found = table("README.md", "methods")
    if device.software:
        assert found == expected
    else:  # numbers differ on other machines
        assert [row[0] for row in found[1:]] == [row[0] for row in expected[1:]]
        assert found[0] == expected[0]


def test_the_table_of_classes_equals_what_methods_declare() -> None:
    found = {name: default_demands(kind()) for name, kind in collection().methods.items()}
    assert table("README.md", "classes") == rows_of(demand_table.table(found))


@pytest.mark.parametrize(
    ("name", "place", "number"),
    # Table 1 of `quick` has the scenes that exact compositing does not rank; there are none here.
    [("quick", 0, 0), ("quick", 2, 1), ("quick", 3, 2), ("lit", 0, 1)],
)
def test_tables_of_results_have_the_layout_of_the_command(
    name: str, place: int, number: int, tmp_path: Path
) -> None:
    """Compare table `place` of the page with table `number` that the command prints."""
    found = split(table("README.md", name))[place]
    methods = [cell.strip("`") for cell in found[0] if cell.startswith("`")]
    made = [finished(tmp_path, row[0], method, 0.1) for row in found[2:] for method in methods]
    results = Results(tmp_path, tuple(made), FACTS)
    expected = split(rows_of(markdown.tables(results)))[number]
    assert [row[0] for row in found] == [row[0] for row in expected]
    assert found[0] == expected[0]
    assert [list(map(shape, row)) for row in found] == [list(map(shape, row)) for row in expected]


def split(rows: list[list[str]]) -> list[list[list[str]]]:
    """Return the tables in a list of rows; each starts with the heading "scene"."""
    starts = [place for place, row in enumerate(rows) if row[0] == "scene"]
    return [rows[a:b] for a, b in zip(starts, [*starts[1:], len(rows)], strict=True)]


def shape(cell: str) -> str:
    """Return a cell without its digits; errors keep their number of decimals, times do not.

    Which truth ranks a scene, which methods are best, and whether a truth has noise are results.
    """
    if cell in TRUTHS:
        return "TRUTH"
    cell = re.sub(r"[\d.]+ ms", "TIME", cell.replace("**", "").replace("–", "0.0000"))
    return re.sub(r"\d", "0", cell)


def test_the_python_example_of_the_readme_runs(tmp_path: Path) -> None:
    (example,) = [b.text for b in blocks("README.md") if b.kind == "python" and b.file is None]
    (tmp_path / "example.py").write_text(
        example.replace("size=(256, 256)", "size=(32, 32)"), encoding="utf-8"
    )
    call("python example.py", tmp_path, tmp_path / "cache")
    assert (tmp_path / "glass_bars.png").is_file()
    assert (tmp_path / "trial" / "cells.jsonl").is_file()


def test_the_metric_of_the_readme_is_one(tmp_path: Path) -> None:
    (block,) = [b for b in blocks("README.md") if b.kind == "python" and b.file is not None]
    path = tmp_path / str(block.file)
    path.write_text(block.text, encoding="utf-8")
    metric = load_metric(path)
    black, gray = np.zeros((2, 2, 3), np.float32), np.full((2, 2, 3), 0.5, np.float32)
    assert metric.value(black, gray, 0.0) == 0.5
    assert (metric.name, metric.facts.higher_is_better) == ("mae_lin", False)


def test_the_tutorial_works(tmp_path: Path) -> None:
    """Follow CONTRIBUTING.md in an empty folder: write the files, run the commands."""
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
    assert {"glass_bars.png", "panes.png", "stability", "trial", "mine"} <= written
    page = (work / "trial" / "report" / "index.html").read_text(encoding="utf-8")
    for name in ("depth_average[power=0]", "weighted_blended", "errors.csv"):
        assert name in page
    assert (work / "mine" / "reference" / "manifest.json").is_file()


@pytest.mark.skipif(find_spec("ruff") is None, reason="needs ruff")
def test_the_python_files_of_the_tutorial_are_formatted(tmp_path: Path) -> None:
    for block in blocks("CONTRIBUTING.md"):
        if block.kind == "python" and block.file is not None:
            path = tmp_path / block.file.replace("/", "_")
            path.write_text(block.text, encoding="utf-8")
            options = ("--config", str(ROOT / "pyproject.toml"), str(path))
            for verb in (("format", "--check"), ("check", "--select=F,I")):
                ruff = (sys.executable, "-m", "ruff", *verb, *options)
                done = subprocess.run(ruff, capture_output=True, text=True)
                assert done.returncode == 0, done.stdout + done.stderr

"""Later runs in a folder: what is kept, what is done again, and what is said about it."""

from __future__ import annotations

import re
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import msgspec
import pytest

from oitbench.image.stored import StoredImage
from oitbench.matrix import plan
from oitbench.matrix.cell import Cell
from oitbench.matrix.plan import plan_matrix
from oitbench.matrix.resume import Resume, describe
from oitbench.matrix.run import Summary, run_matrix
from oitbench.results.schema import Fingerprints, Record, Renderer, Status
from oitbench.results.store import CELLS, RUN, Store, read_cells
from tests.damage import cut
from tests.helpers import write_method
from tests.made_up import FINGERPRINTS, changed, record
from tests.plugins import misbehaving

GL = Renderer("softly")


def cell_of(item: Record, **fields: Any) -> Cell:
    cell = Cell(item.scene, item.method, item.size)
    return msgspec.structs.replace(cell, **fields)


def redone(
    folder: Path,
    item: Record,
    current: Fingerprints | None = FINGERPRINTS,
    gl: Renderer = GL,
    force: bool = False,
    **fields: Any,
) -> str | None:
    """Return why a cell with that record is run again, or None; its image exists."""
    (folder / "images").mkdir(exist_ok=True)
    (folder / "images" / "a.exr").write_bytes(b"a")
    # The digest of the letter a.
    digest = "ca978112ca1bbdcafac231b39a23dc4da786eff8147c4e72b9807785afee48bb"
    if item.outcome is not None:
        item = changed(item, "outcome.images.color", StoredImage("images/a.exr", digest, 1))
    with Store.open(folder) as store:
        store.append(item)
        cell = cell_of(item, **fields)
        reasons = Resume(store, gl, force).redone([cell], lambda cells: [current] * len(cells))
    return reasons.get(cell)


def test_a_cell_of_the_same_content_is_kept(tmp_path: Path) -> None:
    assert redone(tmp_path, record()) is None


@pytest.mark.parametrize(
    ("path", "name"),
    [
        ("scene", "the scene"),
        ("method", "the method"),
        ("engine", "the engine"),
        ("metrics", "the metrics"),
        ("truths.exact", "the truth by exact compositing"),
        ("truths.matched", "the truth by matched tracing"),
    ],
)
def test_a_change_of_content_is_named(path: str, name: str, tmp_path: Path) -> None:
    assert redone(tmp_path, record(), changed(FINGERPRINTS, path, "new")) == f"{name} changed"


@pytest.mark.parametrize(
    ("fields", "name"),
    [
        ({"seed": 2}, "the seed"),
        ({"permutations": 16}, "the number of permutations"),
        ({"truths": ("exact",)}, "the choice of truths"),
    ],
)
def test_a_change_of_settings_is_named(fields: dict[str, Any], name: str, tmp_path: Path) -> None:
    assert redone(tmp_path, record(), **fields) == f"{name} changed"


def test_several_changes_are_named_together(tmp_path: Path) -> None:
    current = changed(changed(FINGERPRINTS, "scene", "new"), "method", "new")
    driver = Renderer("softly", version="next")
    found = redone(tmp_path, record(), current, driver)
    assert found == "the scene and the method and the driver changed"


@pytest.mark.parametrize(
    ("status", "kept"),
    [
        ("ok", True),
        ("unstable", True),
        ("suspect", True),
        ("skipped", True),
        ("failed", False),
        ("timeout", False),
    ],
)
def test_unfinished_cells_are_tried_again(status: Status, kept: bool, tmp_path: Path) -> None:
    assert (redone(tmp_path, record(status=status)) is None) == kept


def test_another_limit_of_layers_redoes_what_was_skipped(tmp_path: Path) -> None:
    def again(status: Status, after: int | None) -> str | None:
        return redone(tmp_path, record(status=status, most_layers=2), most_layers=after)

    assert again("skipped", 2) is None
    assert again("skipped", None) == "the limit of layers changed"
    assert again("ok", None) is None


def test_forced_and_new_cells_need_no_reason(tmp_path: Path) -> None:
    assert redone(tmp_path, record(), force=True) == ""
    assert redone(tmp_path, record(), effects="none") == ""


def test_a_cell_that_cannot_be_identified_is_run_again(tmp_path: Path) -> None:
    message = "its scene or its method cannot be loaded"
    assert redone(tmp_path, record(), None) == message
    assert redone(tmp_path, record(fingerprints=None)) == message


def test_cells_with_the_same_reason_share_a_line() -> None:
    cells = [Cell("s", method, (8, 8)) for method in "abc"] + [Cell("s", "a", (8, 8), seed=2)]
    reasons = ["x changed", "x changed", "y changed", "x changed"]
    lines = list(describe(dict(zip(cells, reasons, strict=True))))
    assert lines == ["redone: s a, b: x changed", "redone: s c: y changed"]
    assert list(describe({cells[0]: ""})) == []


class World:
    """A collection and a results folder that change between runs."""

    def __init__(self, folder: Path) -> None:
        self.plugins, self.out = misbehaving(folder / "plugins"), folder / "out"
        # Equal pictures would share a file.
        self.edit("restless", "default_rng(count)", "default_rng(count + 1)")
        self.shade("1.0")

    def shade(self, alpha: str) -> None:
        """Write the shader of the method `mine`."""
        folder = self.plugins / "methods" / "mine"
        shutil.rmtree(folder, ignore_errors=True)
        write_method(
            folder,
            '(Gather("draw.glsl", writes={"color": ADD}),)',
            members="expresses = Effect.COVERAGE",
            draw=f"void gather(Fragment fragment) {{ color = {alpha} * premultiplied(fragment); }}",
        )

    def edit(self, name: str, old: str, new: str) -> None:
        """Change the file of a scene."""
        path = self.plugins / "scenes" / f"{name}.py"
        text = path.read_text()
        assert old in text
        path.write_text(text.replace(old, new))

    def run(self, **options: Any) -> tuple[Summary, list[str]]:
        """Run four cells; return the summary and the lines about cells that are done again."""
        given: dict[str, Any] = {"preset": "guard", "size": (8, 8), "ssaa": 1, **options}
        scenes, methods = ["calm", "restless"], ["mine", "weighted_sum"]
        matrix = plan_matrix(scenes, methods, out=self.out, collections=[self.plugins], **given)
        lines: list[str] = []
        return run_matrix(matrix, on_line=lines.append), lines

    def records(self) -> dict[tuple[str, str], Record]:
        cells = read_cells(self.out / CELLS).values()
        return {(item.scene, item.method): item for item in cells}

    def image(self) -> Path:
        """The picture of one cell, which no other cell shares."""
        outcome = self.records()["restless", "mine"].outcome
        assert outcome is not None
        return self.out / outcome.images["color"].path


@pytest.fixture(scope="module")
def world(tmp_path_factory: pytest.TempPathFactory) -> World:
    made = World(tmp_path_factory.mktemp("world"))
    summary, lines = made.run()
    assert (summary.statuses, summary.kept, lines) == ({"ok": 4}, 0, [])
    return made


Change = Callable[[World], Any]
CHANGES: dict[str, tuple[Change, list[str]]] = {
    "nothing": (lambda world: None, []),
    "comments": (lambda world: world.edit("calm", '"""A scene for tests."""', "# prose"), []),
    "the scene": (
        lambda world: world.edit("restless", "uniform(1, 9", "uniform(2, 9"),
        [r"redone: restless mine, weighted_sum: the scene changed"],
    ),
    "the shader": (
        lambda world: world.shade("0.5"),
        [rf"redone: {scene} mine: the method changed" for scene in ("calm", "restless")],
    ),
    "a missing image": (
        lambda world: world.image().unlink(),
        [r"redone: restless mine: \S*color-\w+\.exr cannot be read \(No such file or directory\)"],
    ),
    "a torn image": (
        lambda world: cut(world.image(), 5),
        [r"redone: restless mine: \S*color-\w+\.exr is damaged"],
    ),
    "damaged run facts": (lambda world: (world.out / RUN).write_text("{"), []),
}


@pytest.mark.parametrize("name", CHANGES)
def test_what_changed_is_done_again_and_named(name: str, world: World) -> None:
    change, patterns = CHANGES[name]
    before = world.records()
    change(world)
    summary, lines = world.run()
    assert len(lines) == len(patterns), lines
    for line, pattern in zip(sorted(lines), patterns, strict=True):
        assert re.fullmatch(pattern, line)
    named = sum(line.count(",") + 1 for line in lines)
    assert (summary.kept, sum(summary.statuses.values())) == (4 - named, named)
    after = world.records()
    assert after.keys() == before.keys()
    assert {item.status for item in after.values()} == {"ok"}
    same = sum(after[key] == before[key] for key in after)
    assert same == 4 - named
    assert world.run()[0].kept == 4


def test_the_guard_preset_does_not_stand_in_for_another(world: World) -> None:
    summary, lines = world.run(seed=1, preset="quick")
    assert summary.statuses == {"ok": 4}
    assert lines == [
        f"redone: {scene} mine, weighted_sum: the choice of truths changed"
        for scene in ("calm", "restless")
    ]


def test_a_scene_that_cannot_be_built_any_more_fails(tmp_path: Path) -> None:
    world = World(tmp_path)
    world.run()
    world.edit("restless", "pass", "raise ValueError('unwell')")
    summary, lines = world.run()
    assert (summary.kept, summary.statuses) == (2, {"failed": 2})
    assert lines == [
        "redone: restless mine, weighted_sum: its scene or its method cannot be loaded"
    ]
    assert [item.scene for item in summary.troubled] == ["restless"] * 2
    assert summary.exit_code == 1
    assert "unwell" in summary.troubled[0].reason
    assert "its earlier result stays" in summary.troubled[0].reason
    world.edit("restless", "raise ValueError('unwell')", "pass")
    assert world.run()[0].kept == 4


@pytest.mark.parametrize(
    ("text", "force"),
    [("this is no Python", False), ("this is no Python", True), ("while True: pass", False)],
)
def test_a_method_that_cannot_be_loaded_loses_no_earlier_result(
    text: str, force: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(plan, "LOAD_SECONDS", 3.0)
    world = World(tmp_path)
    world.run(preset="quick")
    before = world.records()
    path = world.plugins / "methods" / "mine" / "method.py"
    well = path.read_text()
    path.write_text(text)
    summary, _ = world.run(preset="quick", force=force)
    assert summary.statuses["failed"] == 2
    assert [item.method for item in summary.troubled] == ["mine"] * 2
    assert all(str(path) in item.reason for item in summary.troubled)
    assert summary.exit_code == 1
    for scene in ("calm", "restless"):
        assert world.records()[scene, "mine"] == before[scene, "mine"]
        assert world.records()[scene, "weighted_sum"].status == "ok"
    path.write_text(well)
    summary, lines = world.run(preset="quick")
    assert (summary.kept, summary.statuses, lines) == (4, {}, [])


@pytest.mark.parametrize("crashes", [False, True])
def test_a_changed_method_that_fails_replaces_its_earlier_result(
    crashes: bool, tmp_path: Path
) -> None:
    world = World(tmp_path)
    world.run()
    world.shade("nonsense")
    if crashes:
        path = world.plugins / "methods" / "mine" / "method.py"
        text = path.read_text()
        path.write_text(text.replace("return Plan", "import os; os._exit(7); return Plan"))
    summary, lines = world.run()
    assert len(lines) == summary.statuses["failed"] == 2
    assert world.records()["calm", "mine"].status == "failed"

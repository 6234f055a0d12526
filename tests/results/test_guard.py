"""Pictures, metrics and counts are the committed ones, and a broken method is a regression.

After an intended change of a picture, a metric or a count, or with a new method, rewrite the
committed values with `python -m tests.guard`.
"""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from oitbench.effects import Effect, names
from oitbench.errors import UsageError
from oitbench.places import own_folder
from oitbench.results import baseline
from oitbench.results import comparison as regression
from oitbench.results.baseline import Snapshot
from oitbench.results.store import CELLS, read_cells
from tests import guard
from tests.helpers import collection
from tests.pictures import committed
from tests.pictures.branches import branches, reached
from tests.pictures.cells import Cell, cells, combinations, running, values
from tests.pictures.render import Pictures, pictures, shaders
from tests.pictures.scenes import SCENES

BY_OTHERS = {"oitbench/gl/shaders/probe.glsl": "tests/measure/test_visibility.py"}
"""Shaders that no picture uses, and the tests that guard them."""


@pytest.fixture(scope="module")
def drawn() -> Pictures:
    """The pictures of all cells; they take half a minute."""
    return pictures(cells(collection()))


def test_every_picture_is_the_committed_one(drawn: Pictures) -> None:
    found = committed.differences(drawn, committed.read())
    assert not found, "\n".join(f"{name} {line}" for name, line in found.items())


def test_every_branch_of_every_shader_is_reached(drawn: Pictures) -> None:
    root = own_folder()
    every = [path for path in shaders(root) if path.relative_to(root).as_posix() not in BY_OTHERS]
    missed = branches(root, every) - drawn.branches
    assert not missed, "\n".join(f"{name}:{line}: no cell gets here" for name, line in missed)
    used = frozenset[str]().union(*drawn.files.values())
    assert not {path.relative_to(root).as_posix() for path in every} - used
    assert all((root / test).is_file() for test in BY_OTHERS.values())


def test_branches_of_a_source() -> None:
    text = "#define A 1\n#ifdef A\n#if A == 2 || !defined(B)\n#else\n#endif\n#elif A\n#else\n#endif"
    places = [("file", number) for number in range(1, 9)]
    assert {number for _, number in reached(text, places)} == {2, 3}


def test_every_parameter_value_of_every_method_is_guarded() -> None:
    every = [(cell, collection().expand_methods([cell.method])[0]) for cell in cells(collection())]
    for name, kind in collection().methods.items():
        run = [method for _, method in every if method.name == name]
        for key, parameter in kind.parameters.items():
            missing = {*values(parameter)} - {method.values[key] for method in run}
            assert not missing, f"{name}: no cell has {key}={missing}"


def test_every_effect_is_guarded_with_and_without_it() -> None:
    shown, left_out = Effect.NONE, Effect.NONE
    requests = {name: build().effects for name, build in SCENES.items()}
    for cell in cells(collection()):
        (method,) = collection().expand_methods([cell.method])
        effects = running(cell, method, requests[cell.scene])
        shown |= effects
        left_out |= requests[cell.scene] & method.shows & ~effects
    assert not names(~shown)
    assert not names(~left_out & ~Effect.COVERAGE)


def test_every_pair_of_values_occurs() -> None:
    parameters = collection().methods["phenomenological"].parameters
    found = combinations(parameters)
    for first in parameters:
        for second in parameters:
            for a in values(parameters[first]):
                for b in values(parameters[second]):
                    if first != second:
                        assert any(item[first] == a and item[second] == b for item in found)


def test_a_new_method_has_cells_and_must_be_committed() -> None:
    name = str(Cell("lists", "new"))
    now = Pictures("softly", {name: (0.5,)})
    (line,) = committed.differences(now, Pictures("softly", {})).values()
    assert line == "is not committed; run python -m tests.guard"
    (line,) = committed.differences(Pictures("softly", {}), now).values()
    assert line == "is no cell any more"


@pytest.mark.parametrize(
    ("renderer", "factor", "differs"),
    [("softly", 1.000005, 0), ("softly", 1.0001, 1), ("other", 1.0001, 0), ("other", 1.5, 1)],
)
def test_tolerances(renderer: str, factor: float, differs: int) -> None:
    now = Pictures(renderer, {"a": (0.5 * factor, 0.25)})
    before = Pictures("softly", {"a": (0.5, 0.25)})
    assert len(committed.differences(now, before)) == differs


def _null(content: Any) -> None:
    name = next(iter(content["cells"]))
    content["cells"][name] = [None] * len(content["cells"][name])


def _all_skipped(content: Any) -> None:
    content["cells"] = dict.fromkeys(content["cells"], committed.SKIPPED)


def _short(content: Any) -> None:
    next(iter(content["cells"].values())).pop()


@pytest.mark.parametrize(
    "change",
    [
        _null,
        _all_skipped,
        _short,
        lambda content: content["cells"].clear(),
        lambda content: content.pop("cells"),
        lambda content: content.update(format=0),
        lambda content: content["cells"].update(more=None),
        lambda content: content["cells"].update(more="failed"),
    ],
)
def test_committed_pictures_that_prove_nothing_are_refused(
    tmp_path: Path, change: Callable[[Any], None]
) -> None:
    content = json.loads(committed.FILE.read_bytes())
    change(content)
    path = tmp_path / "pictures.json"
    path.write_text(json.dumps(content), encoding="utf-8")
    with pytest.raises(UsageError, match=r"pictures\.json"):
        committed.read(path)


@pytest.mark.parametrize("means", [{}, {"a": None}, {"a": (float("nan"),)}])
def test_no_such_pictures_are_written(tmp_path: Path, means: dict[str, Any]) -> None:
    with pytest.raises(UsageError):
        committed.write(Pictures("softly", means), tmp_path / "pictures.json")
    assert not list(tmp_path.iterdir())


def test_every_method_reproduces_the_baseline(tmp_path: Path) -> None:
    guard.run(tmp_path)
    before = guard.sound(baseline.read(guard.BASELINE), guard.BASELINE)
    now = guard.sound(baseline.read(tmp_path), tmp_path)
    comparison = regression.compare_snapshots(now, before)
    assert comparison.passed, "\n".join(map(str, comparison.regressions))
    assert not comparison.additions, "commit the new cells: python -m tests.guard"


@pytest.mark.parametrize("field", ["status", "exact.rmse_lin", "fragments"])
def test_a_baseline_that_proves_nothing_is_refused(field: str) -> None:
    snapshot = baseline.read(guard.BASELINE)
    with pytest.raises(UsageError, match="has no cell"):
        guard.sound(Snapshot(snapshot.renderer, {}), guard.BASELINE)
    cell, row = next(iter(snapshot.rows.items()))
    damaged = {**row, field: "failed" if field == "status" else None}
    with pytest.raises(UsageError, match=r"baseline\.json: "):
        guard.sound(Snapshot(snapshot.renderer, {cell: damaged}), guard.BASELINE)


def test_the_committed_files_name_no_machine() -> None:
    for path in (guard.BASELINE, committed.FILE):
        text = path.read_text(encoding="utf-8")
        assert len(text) < 1_000_000
        for word in ("method_ms", ".exr", str(Path.home()), str(own_folder())):
            assert word not in text, path


def test_a_broken_shader_is_a_regression(tmp_path: Path) -> None:
    """The broken resolve loses a twentieth of the coverage."""
    method = tmp_path / "broken"
    shutil.copytree(own_folder() / "methods" / "weighted_blended", method)
    resolve = method / "resolve.glsl"
    text = resolve.read_text(encoding="utf-8")
    broken = text.replace("1.0 - read_reveal()", "0.95 - read_reveal()")
    assert broken != text
    resolve.write_text(broken, encoding="utf-8")
    scenes = ("layer_stack", "smoke_ball[detail=0.1]")
    guard.run(tmp_path / "results", scenes, [str(method)])
    for record in read_cells(tmp_path / "results" / CELLS).values():
        assert record.time is None
        assert record.outcome is not None
        assert record.outcome.scores["matched"].reason == "left out of this run"
    now = baseline.read(tmp_path / "results")
    assert len(now.rows) == len(scenes)
    every = baseline.read(guard.BASELINE)
    sound = {cell: every.rows[cell.replace("broken", "weighted_blended")] for cell in now.rows}
    before = Snapshot(every.renderer, sound)
    comparison = regression.compare_snapshots(now, before)
    assert {item.cell for item in comparison.regressions} == set(now.rows)
    worse = {item.field for item in comparison.regressions if item.verdict == "worse"}
    assert {"exact.flip_ldr@67ppd", "exact.rmse_lin", "exact.rmse_transmittance"} <= worse

"""The results folder survives killed runs, odd values and wrong folders."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from oitbench.errors import UsageError
from oitbench.matrix import machine as environment
from oitbench.results import store
from oitbench.results.store import CELLS, RUN, CellKey, Store


def record(method: str = "m", **values: Any) -> dict[str, Any]:
    return {"scene": "s", "method": method, "variant": {"ssaa": 2}, "size": [8, 4], **values}


def test_later_lines_supersede_earlier_ones(tmp_path: Path) -> None:
    folder = tmp_path / "new" / "results"
    opened = Store.open(folder)
    opened.append(record("a", status="failed"))
    opened.append(record("b", status="ok"))
    opened.append(record("a", status="ok"))
    for other in (opened, Store.open(folder)):
        assert [(r["method"], r["status"]) for r in other.records()] == [("a", "ok"), ("b", "ok")]
    assert len((folder / CELLS).read_text().splitlines()) == 3
    opened.compact()
    assert len((folder / CELLS).read_text().splitlines()) == 2
    assert Store.open(folder).records() == opened.records()


def test_key_holds_scene_method_size_and_variant(tmp_path: Path) -> None:
    opened = Store.open(tmp_path)
    variants = [
        record(),
        record(size=[4, 8]),
        record(variant={"ssaa": 1}),
        record("n"),
        record() | {"scene": "t"},
    ]
    for each in variants:
        opened.append(each)
    assert len(opened.records()) == 5
    assert opened.find(CellKey.of(variants[2])) == variants[2]
    # The order of a variant's settings does not matter.
    one, other = record(variant={"a": 1, "b": 2}), record(variant={"b": 2, "a": 1})
    assert CellKey.of(one) == CellKey.of(other)
    assert opened.find(CellKey.of(one)) is None


@pytest.mark.parametrize(
    "tail", [b'{"scene": "s", "met', b"\x00\xff\x00", b'[1]\n"x"\n{}\n', b"\n"]
)
def test_damaged_lines_lose_no_others(
    tmp_path: Path, tail: bytes, caplog: pytest.LogCaptureFixture
) -> None:
    Store.open(tmp_path).append(record("before"))
    with (tmp_path / CELLS).open("ab") as file:
        file.write(tail)
    opened = Store.open(tmp_path)
    assert ("damaged" in caplog.text) == bool(tail.strip())
    opened.append(record("after"))
    assert [r["method"] for r in Store.open(tmp_path).records()] == ["before", "after"]


def test_no_line_holds_what_json_has_no_word_for(tmp_path: Path) -> None:
    values = {
        "nan": math.nan,
        "list": [np.float32(math.inf), np.int64(3), np.bool_(True)],
        "array": np.array([1.5, math.nan]),
        "path": Path("images") / "a.exr",
    }
    opened = Store.open(tmp_path)
    opened.append(record(odd=values))
    line = (tmp_path / CELLS).read_text()
    expected = {"nan": None, "list": [None, 3, True], "array": [1.5, None], "path": "images/a.exr"}
    assert json.loads(line, parse_constant=pytest.fail)["odd"] == expected
    assert opened.records()[0]["odd"] == expected
    with pytest.raises(TypeError, match="object cannot be stored"):
        opened.append(record(odd=object()))


def test_a_record_without_key_is_a_bug_and_writes_nothing(tmp_path: Path) -> None:
    opened = Store.open(tmp_path)
    with pytest.raises(KeyError):
        opened.append({"scene": "s"})
    assert not (tmp_path / CELLS).exists()


def test_run_facts(tmp_path: Path) -> None:
    opened = Store.open(tmp_path)
    opened.write_run({"gl": {"renderer": "one"}, "odd": math.nan})
    assert store.read_run(tmp_path / RUN) == {"gl": {"renderer": "one"}, "odd": None}
    # Without cells, nothing can be mixed up yet.
    opened.write_run({"gl": {"renderer": "two"}})
    opened.append(record())
    opened.write_run({"gl": {"renderer": "two"}, "seed": 1})
    with pytest.raises(UsageError, match="rendered by 'two', but this is 'one'"):
        opened.write_run({"gl": {"renderer": "one"}})
    assert sorted(path.name for path in tmp_path.iterdir()) == [CELLS, "images", RUN]


def test_damaged_run_facts_are_named(tmp_path: Path) -> None:
    (tmp_path / RUN).write_text("{")
    with pytest.raises(UsageError, match=r"run\.json is damaged"):
        store.read_run(tmp_path / RUN)


def test_foreign_and_unusable_folders_are_refused(tmp_path: Path) -> None:
    (tmp_path / "thesis.tex").touch()
    with pytest.raises(UsageError, match=r"holds something else \(thesis\.tex\)"):
        Store.open(tmp_path)
    with pytest.raises(UsageError, match="is no results folder"):
        Store.open(tmp_path / "thesis.tex")
    with pytest.raises(UsageError, match=r"thesis\.tex"):
        Store.open(tmp_path / "thesis.tex" / "results")
    assert not (tmp_path / CELLS).exists()


def test_results_folders_open_again(tmp_path: Path) -> None:
    Store.open(tmp_path).append(record())
    (tmp_path / "notes.txt").touch()
    (tmp_path / "report").mkdir()
    assert len(Store.open(tmp_path).records()) == 1


def test_image_paths_are_plain_and_distinct() -> None:
    labels = ["a[b=1]", "a_b=1_", "../a", "ä/b", "x" * 300]
    keys = [CellKey.of(record(label)) for label in labels]
    paths = [store.image_path(key, "color") for key in keys]
    assert len(set(paths)) == len(paths)
    for path in paths:
        assert path.isascii()
        assert Path(path).parent == Path("images")
        assert not set(path) & set('[]<>:"|?*% ')
        assert len(path) < 180


def test_environment_tells_where_a_run_was() -> None:
    gl = {"renderer": "llvmpipe (LLVM 15)", "version": "4.5 (Core Profile) Mesa 22.3.6"}
    facts = environment.collect(gl, argv=["oitbench", "run"], seed=3, methods=["b", "a"])
    assert facts["gl"]["software"] is True
    assert facts["mesa"] == "22.3.6"
    assert facts["methods"] == ["a", "b"]
    assert facts["packages"]["numpy"] == np.__version__
    assert facts["cpu"]["model"]
    json.dumps(store.sanitize(facts), allow_nan=False)
    assert not environment.is_software("NVIDIA H100/PCIe/SSE2")
    assert environment.collect(None, argv=[], seed=0)["gl"] is None


def test_git_state_needs_a_checkout(tmp_path: Path) -> None:
    assert environment.git_state(tmp_path) is None

"""The results folder: killed runs, damaged files, values without JSON and wrong folders."""

from __future__ import annotations

import json
import math
from pathlib import Path

import msgspec
import numpy as np
import pytest

from oitbench.errors import UsageError
from oitbench.gl.capabilities import is_software
from oitbench.matrix import machine
from oitbench.results import schema, store
from oitbench.results.records import Results
from oitbench.results.schema import Renderer, RunFacts
from oitbench.results.store import CELLS, RUN, Store
from tests.made_up import changed, failed, record


def test_later_lines_replace_earlier_ones(tmp_path: Path) -> None:
    folder = tmp_path / "new" / "results"
    opened = Store.open(folder)
    opened.append(failed("a"))
    opened.append(record("b"))
    opened.append(record("a"))
    for other in (opened, Store.open(folder)):
        assert [(r.method, r.status) for r in other.records()] == [("a", "ok"), ("b", "ok")]
    assert len((folder / CELLS).read_text().splitlines()) == 3
    opened.compact()
    assert len((folder / CELLS).read_text().splitlines()) == 2
    assert Store.open(folder).records() == opened.records()


def test_the_key_has_scene_method_size_and_settings(tmp_path: Path) -> None:
    opened = Store.open(tmp_path)
    cells = [
        record(),
        record(size=(4, 8)),
        record(ssaa=1),
        record(effects="-caustics"),
        record("n"),
        record(scene="t"),
    ]
    for each in cells:
        opened.append(each)
    opened.append(record(seed=2))
    assert len(opened.records()) == len(cells)
    assert opened.find(cells[2].key) == cells[2]
    assert opened.find(record("other").key) is None


@pytest.mark.parametrize(
    "tail", [b'{"scene": "s", "met', b"\x00\xff\x00", b'[1]\n"x"\n{}\n', b"\n"]
)
def test_damaged_lines_do_not_affect_other_lines(
    tmp_path: Path, tail: bytes, caplog: pytest.LogCaptureFixture
) -> None:
    Store.open(tmp_path).append(record("before"))
    with (tmp_path / CELLS).open("ab") as file:
        file.write(tail)
    opened = Store.open(tmp_path)
    assert ("damaged" in caplog.text) == bool(tail.strip())
    opened.append(record("after"))
    assert [r.method for r in Store.open(tmp_path).records()] == ["before", "after"]


def test_values_without_json_are_written_as_null(tmp_path: Path) -> None:
    opened = Store.open(tmp_path)
    opened.append(changed(record(), "outcome.scores.exact.metrics.x", math.nan))
    line = (tmp_path / CELLS).read_text()
    json.loads(line, parse_constant=pytest.fail)
    assert opened.records()[0].metric("exact", "x") is None
    assert Store.open(tmp_path).records() == opened.records()


def test_a_record_that_violates_the_schema_is_not_written(tmp_path: Path) -> None:
    opened = Store.open(tmp_path)
    with pytest.raises(msgspec.ValidationError):
        opened.append(record(ssaa="two"))
    with pytest.raises(TypeError):
        opened.append(record(seed=np.int64(3)))
    assert not (tmp_path / CELLS).exists()


OLD = '{"scene": "s", "method": "m", "size": [8, 4], "variant": {"ssaa": 2}, "status": "ok"}'


@pytest.mark.parametrize(("line", "version"), [(OLD, 0), ('{"schema": 99}', 99)])
def test_results_of_another_version_are_refused_in_one_line(
    tmp_path: Path, line: str, version: int
) -> None:
    (tmp_path / CELLS).write_text(line + "\n")
    message = rf"cells\.jsonl was written by another version of oitbench \(schema {version}"
    for read in (Store.open, Results.load):
        with pytest.raises(UsageError, match=message) as caught:
            read(tmp_path)
        assert "\n" not in str(caught.value)
    (tmp_path / CELLS).unlink()
    (tmp_path / RUN).write_text(line)
    with pytest.raises(UsageError, match=r"run\.json was written by another version"):
        store.read_run(tmp_path / RUN)


def test_the_schema_file_equals_that_of_the_code() -> None:
    assert schema.SCHEMA_FILE.read_text(encoding="utf-8") == schema.schema_text()


def test_the_schema_has_the_fields_of_written_records(tmp_path: Path) -> None:
    content = schema.json_schema()
    Store.open(tmp_path).append(record())
    written = json.loads((tmp_path / CELLS).read_text())
    assert set(written) == set(content["$defs"]["Record"]["properties"])
    assert set(written["outcome"]) == set(content["$defs"]["Outcome"]["properties"])


def facts(renderer: str, seed: int = 1) -> RunFacts:
    return RunFacts(gl=Renderer(renderer), seed=seed)


def test_run_facts_of_another_renderer_are_refused(tmp_path: Path) -> None:
    opened = Store.open(tmp_path)
    opened.write_run(facts("one"))
    assert store.read_run(tmp_path / RUN) == facts("one")
    # A folder without cells accepts another renderer.
    opened.write_run(facts("two"))
    opened.append(record())
    opened.write_run(facts("two", seed=2))
    with pytest.raises(UsageError, match="rendered by 'two', but this is 'one'"):
        opened.write_run(facts("one"))
    assert sorted(path.name for path in tmp_path.iterdir()) == [CELLS, "images", RUN]


def test_damaged_run_facts_are_refused(tmp_path: Path) -> None:
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
    keys = [record(label).key for label in labels]
    paths = [store.image_path(key, "color") for key in keys]
    assert len(set(paths)) == len(paths)
    for path in paths:
        assert path.isascii()
        assert Path(path).parent == Path("images")
        assert not set(path) & set('[]<>:"|?*% ')
        assert len(path) < 180


def test_facts_describe_the_machine() -> None:
    gl = Renderer("llvmpipe (LLVM 15)", version="4.5 (Core Profile) Mesa 22.3.6", software=True)
    found = machine.collect(gl, argv=["oitbench", "run"], seed=3, methods=["b", "a"])
    assert found.gl == gl
    assert found.mesa == "22.3.6"
    assert found.methods == ["a", "b"]
    assert found.packages["numpy"] == np.__version__
    assert found.cpu is not None
    assert found.cpu.model
    assert msgspec.json.decode(msgspec.json.encode(found), type=RunFacts) == found
    assert machine.collect(None, argv=[], seed=0).gl is None


def test_software_renderers_are_recognized_by_name() -> None:
    assert is_software("llvmpipe (LLVM 15)")
    assert not is_software("NVIDIA H100/PCIe/SSE2")


def test_git_state_needs_a_checkout(tmp_path: Path) -> None:
    assert machine.git_state(tmp_path) is None

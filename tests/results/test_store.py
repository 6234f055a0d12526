"""The results folder: killed runs, damaged files, values without JSON and wrong folders."""

from __future__ import annotations

import json
import math
import os
import signal
import subprocess
import sys
from pathlib import Path

import msgspec
import numpy as np
import pytest

from oitbench.errors import StorageError, UsageError
from oitbench.gl.capabilities import is_software
from oitbench.image import stored
from oitbench.image.files import image_channels
from oitbench.image.stored import StoredImage
from oitbench.matrix import machine
from oitbench.results import json_schema, store
from oitbench.results.checksum import seal
from oitbench.results.records import Results
from oitbench.results.schema import Renderer, RunFacts
from oitbench.results.store import CELLS, RUN, Store, read_cells
from tests.damage import flip_bit, largest_file
from tests.image.helpers import constant
from tests.made_up import changed, failed, record, write


def lines_of(folder: Path) -> list[str]:
    return (folder / CELLS).read_text().splitlines()


def test_later_lines_replace_earlier_ones(tmp_path: Path) -> None:
    folder = tmp_path / "new" / "results"
    with Store.open(folder) as opened:
        opened.append(failed("a"))
        opened.append(record("b"))
        opened.append(record("a"))
        found = opened.records()
        assert [(r.method, r.status) for r in found] == [("a", "ok"), ("b", "ok")]
        assert len(lines_of(folder)) == 3
        opened.compact()
    assert len(lines_of(folder)) == 2
    assert list(read_cells(folder / CELLS).values()) == found


def test_the_key_has_scene_method_size_and_settings(tmp_path: Path) -> None:
    cells = [
        record(),
        record(size=(4, 8)),
        record(ssaa=1),
        record(effects="-caustics"),
        record("n"),
        record(scene="t"),
    ]
    with Store.open(tmp_path) as opened:
        for each in cells:
            opened.append(each)
        opened.append(record(seed=2))
        assert len(opened.records()) == len(cells)
        assert opened.find(cells[2].key) == cells[2]
        assert opened.find(record("other").key) is None


@pytest.mark.parametrize(
    "tail", [b'{"scene": "s", "met', b"\x00\xff\x00", b'[1]\n"x"\n{}\n', b"[" * 100_000, b"\n"]
)
def test_damaged_lines_do_not_affect_other_lines(
    tmp_path: Path, tail: bytes, caplog: pytest.LogCaptureFixture
) -> None:
    write(tmp_path, [record("before")])
    with (tmp_path / CELLS).open("ab") as file:
        file.write(tail)
    with Store.open(tmp_path) as opened:
        assert caplog.text.count("damaged and skipped: line 2") == bool(tail.strip())
        opened.append(record("after"))
    assert [r.method for r in read_cells(tmp_path / CELLS).values()] == ["before", "after"]


def test_no_flipped_bit_of_a_cell_is_believed(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    """Each flip damages one line, or two if it hits the line break between them."""
    write(tmp_path, [record("a"), record("b"), record("c")])
    path = tmp_path / CELLS
    whole, before = path.read_bytes(), read_cells(path)
    flips = range(0, 8 * len(whole), 41)
    kept = []
    for number in flips:
        flip_bit(path, number)
        caplog.clear()
        cells = read_cells(path)
        assert all(before[key] == cell for key, cell in cells.items())
        assert caplog.text.count("damaged and skipped: line") == 1, number
        kept.append(len(cells))
        path.write_bytes(whole)
    assert set(kept) <= {1, 2}
    assert kept.count(2) > 0.9 * len(flips)


def test_no_flipped_bit_of_the_run_facts_is_believed(tmp_path: Path) -> None:
    write(tmp_path, [record()], facts("softly"))
    path = tmp_path / RUN
    whole = path.read_bytes()
    for number in range(0, 8 * len(whole) - 8, 7):
        flip_bit(path, number)
        assert store.read_run(path) is None, number
        path.write_bytes(whole)
    assert store.read_run(path) == facts("softly")


def test_values_without_json_are_written_as_null(tmp_path: Path) -> None:
    with Store.open(tmp_path) as opened:
        opened.append(changed(record(), "outcome.scores.exact.metrics.x", math.nan))
        json.loads((tmp_path / CELLS).read_text(), parse_constant=pytest.fail)
        (found,) = opened.records()
    assert found.metric("exact", "x") is None
    assert list(read_cells(tmp_path / CELLS).values()) == [found]


def test_a_record_that_violates_the_schema_is_not_written(tmp_path: Path) -> None:
    with Store.open(tmp_path) as opened:
        with pytest.raises(msgspec.ValidationError):
            opened.append(record(ssaa="two"))
        with pytest.raises(TypeError):
            opened.append(record(seed=np.int64(3)))
    assert not (tmp_path / CELLS).exists()


@pytest.mark.parametrize(
    "path",
    [
        "/etc/a.exr",
        "../a.exr",
        "images/../a.exr",
        "images/..",
        "a/b/c.exr",
        ".a",
        "",
        "a\n",
        "ä.exr",
    ],
)
def test_paths_that_leave_the_folder_are_damage(tmp_path: Path, path: str) -> None:
    image = StoredImage(path, "0" * 64, 1)
    content = changed(record("bad"), "outcome.images.color", image)
    line = seal(msgspec.json.encode(content)) + b"\n"
    write(tmp_path, [record("good")])
    with (tmp_path / CELLS).open("ab") as file:
        file.write(line)
    assert [r.method for r in read_cells(tmp_path / CELLS).values()] == ["good"]
    with Store.open(tmp_path) as opened, pytest.raises(msgspec.ValidationError):
        opened.append(content)


OLD = '{"scene": "s", "method": "m", "size": [8, 4], "variant": {"ssaa": 2}, "status": "ok"}'
FIRST = '{"scene": "s", "method": "m", "status": "ok", "schema": 1}'
NEWER = seal(b'{"schema": 99, "new": 1}').decode()


@pytest.mark.parametrize(("line", "version"), [(OLD, 0), (FIRST, 1), (NEWER, 99)])
def test_results_of_another_version_are_refused_in_one_line(
    tmp_path: Path, line: str, version: int
) -> None:
    (tmp_path / CELLS).write_text(line + "\n")
    message = rf"cells\.jsonl was written by another version of oitbench \(schema {version}"
    with pytest.raises(UsageError, match=message) as caught:
        Results.load(tmp_path)
    assert "\n" not in str(caught.value)
    with pytest.raises(UsageError, match=message), Store.open(tmp_path):
        pass
    (tmp_path / CELLS).unlink()
    (tmp_path / RUN).write_text(line)
    with pytest.raises(UsageError, match=r"run\.json was written by another version"):
        store.read_run(tmp_path / RUN)


def test_a_flipped_version_is_damage_and_no_other_version(tmp_path: Path) -> None:
    write(tmp_path, [record()])
    text = (tmp_path / CELLS).read_text()
    (tmp_path / CELLS).write_text(text.replace('"schema":6', '"schema":7'))
    assert read_cells(tmp_path / CELLS) == {}


def test_the_schema_file_equals_that_of_the_code() -> None:
    assert json_schema.SCHEMA_FILE.read_text(encoding="utf-8") == json_schema.schema_text()


def test_the_schema_has_the_fields_of_written_records(tmp_path: Path) -> None:
    content = json_schema.json_schema()
    write(tmp_path, [record()])
    written = json.loads((tmp_path / CELLS).read_text())
    assert set(written) == set(content["$defs"]["Record"]["properties"])
    assert set(written["outcome"]) == set(content["$defs"]["Outcome"]["properties"])
    run = json.loads((tmp_path / RUN).read_text())
    assert set(run) == set(content["$defs"]["RunFacts"]["properties"])


def facts(renderer: str, seed: int = 1) -> RunFacts:
    return RunFacts(gl=Renderer(renderer), seed=seed)


@pytest.mark.parametrize("run", [None, "{", '{"schema": 6}'], ids=["none", "damaged", "unsealed"])
def test_cells_of_another_renderer_are_refused_whatever_the_run_facts_say(
    tmp_path: Path, run: str | None
) -> None:
    write(tmp_path, [failed("unknown", gl=None), record()], facts("softly"))
    (tmp_path / RUN).unlink()
    if run is not None:
        (tmp_path / RUN).write_text(run)
    with Store.open(tmp_path) as opened:
        opened.check_renderer("softly")
        with pytest.raises(UsageError, match="rendered by 'softly', but this is 'hardly'"):
            opened.check_renderer("hardly")
    assert Results.load(tmp_path).renderer == "softly"


def test_run_facts_are_replaced(tmp_path: Path) -> None:
    with Store.open(tmp_path) as opened:
        opened.write_run(facts("one"))
        opened.write_run(facts("two", seed=2))
    assert store.read_run(tmp_path / RUN) == facts("two", seed=2)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["images", RUN]


@pytest.mark.parametrize("name", ["motion", "reference_check", "report", "stability", "visibility"])
def test_other_commands_may_have_written_to_the_folder_first(tmp_path: Path, name: str) -> None:
    (tmp_path / name).mkdir()
    with Store.open(tmp_path) as opened:
        assert opened.records() == []


def test_foreign_and_unusable_folders_are_refused(tmp_path: Path) -> None:
    (tmp_path / "thesis.tex").touch()
    for folder, message in (
        (tmp_path, r"holds something else \(thesis\.tex\)"),
        (tmp_path / "thesis.tex", "is no results folder"),
        (tmp_path / "thesis.tex" / "results", r"thesis\.tex"),
    ):
        with pytest.raises(UsageError, match=message), Store.open(folder):
            pass
    assert [path.name for path in tmp_path.iterdir()] == ["thesis.tex"]


def test_results_folders_open_again(tmp_path: Path) -> None:
    write(tmp_path, [record()])
    (tmp_path / "notes.txt").touch()
    (tmp_path / "report").mkdir()
    with Store.open(tmp_path) as opened:
        assert len(opened.records()) == 1


def test_a_second_run_in_one_folder_is_refused(tmp_path: Path) -> None:
    with Store.open(tmp_path):
        pattern = rf"is in use by process {os.getpid()} on .* since 2.* UTC; wait for it to end"
        with pytest.raises(UsageError, match=pattern) as caught, Store.open(tmp_path):
            pass
    assert "\n" not in str(caught.value)
    with Store.open(tmp_path):
        assert (tmp_path / "run.lock").read_text().startswith(f"process {os.getpid()} on ")
    assert not (tmp_path / "run.lock").exists()


def test_the_lock_of_a_killed_run_is_taken_over(tmp_path: Path) -> None:
    code = f"""
import os, signal
from oitbench.results.store import Store
with Store.open({str(tmp_path)!r}):
    os.kill(os.getpid(), signal.SIGKILL)
"""
    killed = subprocess.run([sys.executable, "-c", code], timeout=60)
    assert killed.returncode == -signal.SIGKILL
    assert (tmp_path / "run.lock").is_file()
    with Store.open(tmp_path):
        assert (tmp_path / "run.lock").read_text().startswith(f"process {os.getpid()} on ")
    assert not (tmp_path / "run.lock").exists()


def test_temporary_files_of_a_killed_run_are_removed(tmp_path: Path) -> None:
    (tmp_path / "images").mkdir()
    left = [tmp_path / ".cells.7.partial.jsonl", tmp_path / "images" / ".color.7.partial.exr"]
    for path in left:
        path.touch()
    with Store.open(tmp_path):
        assert not any(path.exists() for path in left)


def test_compaction_keeps_what_is_on_the_disk_and_removes_images_without_a_cell(
    tmp_path: Path,
) -> None:
    kept, foreign, lost = (
        stored.store(tmp_path, "images/color", image_channels(constant((value, 0, 0))))
        for value in (0.1, 0.2, 0.3)
    )
    with Store.open(tmp_path) as opened:
        opened.append(changed(record("ours"), "outcome.images.color", kept))
        with (tmp_path / CELLS).open("ab") as file:
            other = changed(record("theirs"), "outcome.images.color", foreign)
            file.write(seal(msgspec.json.encode(other)) + b"\n" + b"half a li")
        opened.compact()
    assert [r.method for r in read_cells(tmp_path / CELLS).values()] == ["ours", "theirs"]
    assert b"half" not in (tmp_path / CELLS).read_bytes()
    names = {path.name for path in (tmp_path / "images").iterdir()}
    assert names == {Path(image.path).name for image in (kept, foreign)}
    assert lost.path not in names


def test_a_full_disk_loses_no_cell(tmp_path: Path) -> None:
    path = tmp_path / CELLS
    with Store.open(tmp_path) as opened:
        opened.append(record("a"))
        whole = path.read_bytes()
        with (
            largest_file(len(whole) + 100),
            pytest.raises(StorageError, match=r"cells\.jsonl .*; free some space") as caught,
        ):
            opened.append(record("b"))
        assert "\n" not in str(caught.value)
        assert path.read_bytes() == whole
        assert [r.method for r in opened.records()] == ["a"]
        with largest_file(100), pytest.raises(StorageError):
            opened.compact()
        with largest_file(100), pytest.raises(StorageError):
            opened.write_run(facts("softly"))
        assert path.read_bytes() == whole
        opened.append(record("b"))
    assert [r.method for r in read_cells(path).values()] == ["a", "b"]


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

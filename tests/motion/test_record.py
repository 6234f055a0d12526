"""The file of `oitbench motion`, and its verdicts."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import pytest
from msgspec.structs import replace

from oitbench.errors import UsageError
from oitbench.motion import record
from oitbench.motion.record import CSV, FRAMES, JSON, Pop
from tests.motion import made_up


def test_what_is_written_can_be_read(tmp_path: Path) -> None:
    found = made_up.write(tmp_path)
    assert record.read(tmp_path / JSON) == found


def test_verdicts_compare_with_exact_compositing_and_the_display(tmp_path: Path) -> None:
    found = made_up.write(tmp_path)
    verdicts = {track.label: found.verdicts(track) for track in found.tracks}
    assert verdicts == {
        "calm": ["steady"],
        "leaping[sort=object]": ["pops"],
        "noisy, seeds fixed": ["steady"],
        "noisy, seeds per frame": ["flickers"],
        "shaking": ["flickers"],
    }


@pytest.mark.parametrize(
    ("popping", "exact", "pops"),
    [(0.1, 0.0, True), (0.1, 0.2, False), (0.003, 0.0, False), (0.005, 0.0, True)],
)
def test_a_pop_exceeds_exact_compositing_and_a_step_of_the_display(
    popping: float, exact: float, pops: bool
) -> None:
    assert Pop(0, (0, 0), popping, exact).pops is pops


def test_the_jump_that_is_shown_pops_if_any_does(tmp_path: Path) -> None:
    pops = Pop(0, (0, 0), 0.0045, 0.0038)
    exceeds = Pop(1, (0, 0), 0.0038, 0.0)
    assert (pops.pops, exceeds.pops) == (True, False)
    found = made_up.track(tmp_path, "sorted_over")
    assert replace(found, pops=[exceeds, pops]).worst_pop == pops
    assert replace(found, pops=[exceeds]).worst_pop == exceeds
    assert found.worst_pop is None


def test_the_table_has_a_row_for_each_frame(tmp_path: Path) -> None:
    found = made_up.write(tmp_path)
    with (tmp_path / CSV).open() as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == len(found.tracks) * made_up.COUNT
    assert (rows[0]["frame"], rows[0]["flip"], rows[0]["flicker_mean"]) == ("0", "0.1", "")
    assert (rows[1]["frame"], rows[1]["flip"], rows[1]["flicker_mean"]) == ("1", "", "0.01")
    assert rows[1]["exact_change"] == str(made_up.CHANGE)


def test_frames_of_an_earlier_run_are_removed(tmp_path: Path) -> None:
    found = made_up.write(tmp_path)
    (tmp_path / FRAMES / "old-0.exr").write_bytes(b"old")
    (tmp_path / FRAMES / "notes.txt").write_bytes(b"mine")
    record.write(tmp_path, found)
    assert not (tmp_path / FRAMES / "old-0.exr").exists()
    assert (tmp_path / FRAMES / "notes.txt").exists()
    assert (tmp_path / found.exact[0].path).exists()


def test_other_files_are_refused(tmp_path: Path) -> None:
    path = tmp_path / JSON
    with pytest.raises(UsageError, match="cannot be read"):
        record.read(path)
    path.write_text("[]")
    with pytest.raises(UsageError, match="holds no results of `oitbench motion`"):
        record.read(path)
    made_up.write(tmp_path)
    content = json.loads(path.read_text())
    path.write_text(json.dumps(content | {"schema": 99}))
    with pytest.raises(UsageError, match="schema 99"):
        record.read(path)
    outside = {"path": "../secret", "sha256": "0" * 64, "bytes": 1}
    path.write_text(json.dumps(content | {"exact": [outside]}))
    with pytest.raises(UsageError, match="holds no results"):
        record.read(path)

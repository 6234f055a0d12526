"""Merged results: what is kept, what is apart, and what is refused."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import msgspec
import pytest

import oitbench
from oitbench.choosing.choice import choose
from oitbench.errors import StorageError, UsageError
from oitbench.image import stored
from oitbench.results.merging import merge
from oitbench.results.records import Results, parts
from oitbench.results.schema import Fingerprints, Renderer, RunFacts
from oitbench.results.store import CELLS
from oitbench.results.times import Processor
from tests.damage import largest_file
from tests.made_up import FINGERPRINTS, failed, timed, write
from tests.scoring.helpers import read, score, write_metric, write_results

CARD = Renderer("Card 9000", "Vendor")
SOFT = Renderer("softly", software=True)


def facts(gl: Renderer = SOFT, cpu: str = "abacus", date: str = "", **fields: Any) -> RunFacts:
    return RunFacts(gl, 1, cpu=Processor(cpu, 2), date=date, **fields)


def content(folder: Path) -> dict[Path, bytes]:
    files = (path for path in folder.rglob("*") if path.is_file())
    return {path.relative_to(folder): path.read_bytes() for path in files}


def assert_intact(folder: Path) -> None:
    for record in read(folder):
        assert record.outcome is not None
        for image in record.outcome.images.values():
            stored.verify(folder, image)


def test_results_of_one_renderer_are_one_folder(tmp_path: Path) -> None:
    first = write_results(tmp_path / "a", ("mean",), facts(methods=["mean"], date="2026-02"))
    second = write_results(tmp_path / "b", ("peel",), facts(methods=["peel"], date="2026-01"))
    before = content(first), content(second)
    out = tmp_path / "merged"
    merged = merge([first, second], out)
    assert (merged.folders, merged.cells) == ({"softly, abacus": out}, 2)
    assert sorted(read(out), key=lambda r: r.method) == [*read(first), *read(second)]
    assert_intact(out)
    assert set(content(out)) == set(content(first)) | set(content(second))
    assert (content(first), content(second)) == before
    found = Results.load(out).facts
    assert (found.date, sorted(found.methods)) == ("2026-02", ["mean", "peel"])
    assert list(tmp_path.glob(".*")) == []


def test_times_of_different_renderers_stay_apart(tmp_path: Path) -> None:
    soft = write_results(tmp_path / "a", facts=facts(), time=timed(9.0))
    card = write_results(tmp_path / "b", facts=facts(CARD), time=timed(1.0))
    out = tmp_path / "merged"
    merged = merge([soft, card], out)
    names = {"softly, abacus": "softly-abacus", "Card 9000": "Card-9000"}
    assert merged.folders == {device: out / name for device, name in names.items()}
    assert merged.notes == []
    assert parts(out) == [out / "Card-9000", out / "softly-abacus"]
    assert read(out / "softly-abacus") == read(soft)
    assert read(out / "Card-9000") == read(card)
    assert_intact(out / "Card-9000")
    # Errors can be compared, and commands that need one renderer ask for it.
    assert oitbench.compare(*parts(out)).passed
    with pytest.raises(UsageError, match=r"merged holds results of several renderers; give one of"):
        Results.load(out)
    with pytest.raises(UsageError, match="share no axis"):
        choose([out])
    assert choose([out], renderer="card").renderer == "Card 9000"
    again = merge([out], tmp_path / "again")
    assert list(again.folders) == ["Card 9000", "softly, abacus"]


def test_all_parts_of_merged_results_are_scored(tmp_path: Path) -> None:
    folders = [
        write_results(tmp_path / name, facts=facts(gl)) for name, gl in (("a", SOFT), ("b", CARD))
    ]
    merge(folders, tmp_path / "merged")
    assert score(tmp_path / "merged", write_metric(tmp_path)).scored == 4


def test_a_software_renderer_on_another_processor_is_another_one(tmp_path: Path) -> None:
    folders = [
        write_results(tmp_path / cpu, facts=facts(cpu=cpu), time=timed(2.0))
        for cpu in ("Fast CPU", "Fast-CPU")
    ]
    merged = merge(folders, tmp_path / "merged")
    assert list(merged.folders) == ["softly, Fast CPU", "softly, Fast-CPU"]
    assert len(parts(tmp_path / "merged")) == 2
    cards = [
        write_results(tmp_path / f"card {cpu}", (cpu[:4],), facts(CARD, cpu))
        for cpu in ("some", "else")
    ]
    assert list(merge(cards, tmp_path / "cards").folders) == ["Card 9000"]


@pytest.mark.parametrize("reverse", [False, True])
def test_of_equal_cells_the_newest_finished_one_is_kept(tmp_path: Path, reverse: bool) -> None:
    old = write_results(tmp_path / "old", ("mean",), facts(date="2026-01"), seconds=1.0)
    write(old, [failed("peel", gl=SOFT)], facts(date="2026-01"))
    new = write_results(tmp_path / "new", ("mean",), facts(date="2026-02"), seconds=2.0)
    write(new, [failed("peel", "newer", gl=SOFT)], facts(date="2026-02"))
    broken = write(tmp_path / "broken", [failed("mean", gl=SOFT)], facts(date="2026-03"))
    folders = [old, new, broken]
    merged = merge(folders[::-1] if reverse else folders, tmp_path / "merged")
    mean, peel = read(tmp_path / "merged")
    assert (mean.status, mean.seconds, peel.reason) == ("ok", 2.0, "newer")
    assert any(line.startswith("3 cells are in several folders") for line in merged.notes)


def test_scenes_that_were_timed_apart_are_named(tmp_path: Path) -> None:
    folders = [
        write_results(tmp_path / name, (name,), facts(), time=timed(2.0)) for name in ("a", "b")
    ]
    (note,) = merge(folders, tmp_path / "merged").notes
    assert note.startswith(f"glass[count=4] at 8x6 was timed in {folders[0]} and in {folders[1]}")


def test_a_damaged_image_is_taken_from_another_folder_or_named(tmp_path: Path) -> None:
    folders = [write_results(tmp_path / name, (name,), facts(), time=None) for name in ("a", "b")]
    next((folders[0] / "images").glob("exact-*")).unlink()
    assert merge(folders, tmp_path / "merged").notes == [], "b has the same truth"
    assert_intact(tmp_path / "merged")


def test_what_is_lost_or_left_out_is_named(tmp_path: Path) -> None:
    folder = write_results(tmp_path / "a", facts=facts(), time=None)
    color = next((folder / "images").glob("color-*"))
    color.write_bytes(b"")
    for name in ("motion", "report"):
        (folder / name).mkdir()
    other = msgspec.structs.replace(FINGERPRINTS, scene="other")
    second = write_results(tmp_path / "b", ("third",), facts(), time=None, fingerprints=other)
    assert merge([folder, second], tmp_path / "merged").notes == [
        f"glass[count=4] is not the same in {folder} and {second}; compare its errors with care",
        f"{folder / 'motion'} is not merged; it stays there",
        f"{color} is damaged; it is not copied",
    ]


@pytest.mark.parametrize("part", ["engine", "metrics"])
def test_cells_of_different_versions_are_refused(tmp_path: Path, part: str) -> None:
    other: Fingerprints = msgspec.structs.replace(FINGERPRINTS, **{part: "other"})
    first = write_results(tmp_path / "a", facts=facts())
    second = write_results(tmp_path / "b", facts=facts(CARD), fingerprints=other)
    with pytest.raises(UsageError) as caught:
        merge([first, second], tmp_path / "merged")
    assert str(caught.value) == (
        f"{first} and {second} hold cells of different versions of the {part}; run all with one"
        " version"
    )
    assert not (tmp_path / "merged").exists()


def test_folders_that_cannot_be_used_are_refused(tmp_path: Path) -> None:
    folder = write_results(tmp_path / "a")
    newer = tmp_path / "newer"
    newer.mkdir()
    (newer / CELLS).write_text('{"schema": 99}\n')
    before = content(tmp_path)
    for folders, out, message in (
        ([folder], folder, "a is not empty; give a new folder"),
        ([folder], folder / CELLS, "is not empty"),
        ([folder], folder / "inside", "is inside of"),
        ([folder, newer], tmp_path / "out", "another version of oitbench"),
        ([folder, tmp_path / "none"], tmp_path / "out", "holds no cells.jsonl"),
    ):
        with pytest.raises(UsageError, match=message):
            merge(folders, out)
    assert content(tmp_path) == before


def test_a_full_disk_leaves_nothing_behind(tmp_path: Path) -> None:
    folder = write_results(tmp_path / "a")
    with largest_file(1000), pytest.raises(StorageError, match="free some space"):
        merge([folder], tmp_path / "merged")
    assert [path.name for path in tmp_path.iterdir()] == ["a"]

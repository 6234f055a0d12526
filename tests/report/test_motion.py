"""The section of methods in motion, and the clips."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest
from PIL import Image as Pictures

from oitbench.motion.record import FRAMES
from oitbench.report import Figure, Note, Table, clips, motion
from oitbench.report.motion import Footage
from oitbench.report.templates import environment
from tests.helpers import collection
from tests.motion import made_up
from tests.report.made_up import context, finished

build = collection().reports["motion"].build


def built(tmp_path: Path) -> list[object]:
    records = [finished(tmp_path, "fog", "calm", 0.1)]
    return list(build(context(tmp_path, records, tmp_path / "report")))


def test_each_folder_has_a_strip_a_plot_and_a_table(tmp_path: Path) -> None:
    made_up.write(tmp_path / "motion" / "fog")
    strip, plot, table = built(tmp_path)
    for figure in (strip, plot):
        assert isinstance(figure, Figure)
        assert figure.png.is_file()
        assert figure.pdf.is_file()
    assert isinstance(table, Table)
    assert "broken: no shader" in table.caption
    with table.csv.open() as file:
        rows = {row["method"] + row["seeds"]: row for row in csv.DictReader(file)}
    assert rows["leaping[sort=object]"]["verdict"] == "pops"
    assert rows["leaping[sort=object]"]["popping"] == "0.2"
    assert float(rows["calm"]["flip"]) == pytest.approx(0.15)
    assert float(rows["shaking"]["ratio"]) == pytest.approx(0.2 / made_up.CHANGE)
    assert rows["noisyper frame"]["rest"] == "0.02"


def test_the_page_shows_methods_that_its_run_does_not_know(tmp_path: Path) -> None:
    made_up.write(tmp_path / "motion")
    known = context(tmp_path, [finished(tmp_path, "fog", "glow", 0.1)], tmp_path / "report")
    page = (
        environment(known).get_template("section.html").render(artifacts=build(known), heading="")
    )
    assert "leaping[sort=object]" in page


def test_several_folders_are_shown_one_after_another(tmp_path: Path) -> None:
    for name in ("motion", "motion/fog"):
        made_up.write(tmp_path / name)
    found = built(tmp_path)
    assert len(found) == 6
    assert len({item.png for item in found if isinstance(item, Figure)}) == 4


def test_without_a_folder_a_note_names_the_command(tmp_path: Path) -> None:
    (note,) = built(tmp_path)
    assert isinstance(note, Note)
    assert "oitbench motion" in note.text


def test_a_damaged_frame_costs_only_its_folder(tmp_path: Path) -> None:
    for name in ("motion/a", "motion/b"):
        made_up.write(tmp_path / name)
    for path in (tmp_path / "motion" / "a" / FRAMES).glob("calm*"):
        path.write_bytes(b"damaged")
    note, *others = built(tmp_path)
    assert isinstance(note, Note)
    assert "damaged" in note.text
    assert len(others) == 3


def test_changes_are_in_excess_of_exact_compositing(tmp_path: Path) -> None:
    found = made_up.write(tmp_path)
    footage = Footage(tmp_path, found)
    own = footage.change(0)
    shown = [footage.frame(found.tracks[0], number) for number in (0, 1)]
    np.testing.assert_allclose(
        footage.change(0, shown), abs((shown[1] - shown[0]).mean(axis=-1) - own)
    )


def test_the_pair_of_a_short_path_stands_beside_its_change(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    lefts: dict[float, list[float]] = {}

    def draw(canvas: object, picture: object, left: float, top: float, width: float) -> None:
        lefts.setdefault(top, []).append(left)

    monkeypatch.setattr(motion, "draw_picture", draw)
    motion.write(Footage(tmp_path, made_up.write(tmp_path)), tmp_path / "out")
    for row in lefts.values():
        assert len(row) == made_up.COUNT + 3
        gaps = np.diff(sorted(row))
        # One place is free: that of the fourth frame that is evenly spaced.
        assert gaps.argmax() == made_up.COUNT - 1


@pytest.mark.parametrize("kind", ["webp", "gif"])
def test_clips_show_every_frame(tmp_path: Path, kind: str) -> None:
    made_up.write(tmp_path)
    written = clips.write(Footage.load(tmp_path), tmp_path / "clips", kind)
    assert len(written) == 5
    with Pictures.open(written[0]) as clip:
        assert getattr(clip, "n_frames", 1) == made_up.COUNT
        assert clip.width == 3 * 256 + 8

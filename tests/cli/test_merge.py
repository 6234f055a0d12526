"""`oitbench merge`, and the commands that take its folders."""

from __future__ import annotations

from pathlib import Path

from oitbench.results.schema import Renderer
from tests.cli.helpers import Call
from tests.made_up import FACTS, changed, timed
from tests.scoring.helpers import write_results


def test_the_folders_of_renderers_are_printed_and_reported(call: Call, tmp_path: Path) -> None:
    card = changed(FACTS, "gl", Renderer("Card 9000"))
    soft = write_results(tmp_path / "a", time=timed(9.0))
    other = write_results(tmp_path / "b", facts=card, time=timed(7.0))
    (soft / "motion").mkdir()
    out = tmp_path / "merged"
    answer = call("merge", soft, other, "-o", out)
    folders = {out / "softly": "softly", out / "Card-9000": "Card 9000"}
    lines = [*(f"{folder}: {name}" for folder, name in folders.items()), f"{out}: 4 cells"]
    assert (answer.code, answer.out.splitlines()) == (0, lines)
    assert answer.err == f"note: {soft / 'motion'} is not merged; it stays there\n"
    answer = call("report", out, "--section", "table")
    pages = [out / name / "report" / "index.html" for name in ("Card-9000", "softly")]
    assert (answer.code, answer.out.splitlines()) == (0, list(map(str, pages)))
    for page, median, foreign in zip(pages, ("7.0", "9.0"), ("9.0", "7.0"), strict=True):
        table = (page.parent / "table.csv").read_text(encoding="utf-8")
        assert f",{median}," in table
        assert f",{foreign}," not in table
    answer = call("report", out, "--section", "table", "--out", tmp_path / "pages")
    assert (tmp_path / "pages" / "softly" / "index.html").is_file()
    answer = call("report", out, "--markdown")
    assert "# Card-9000\n" in answer.out
    assert "# softly\n" in answer.out
    call("baseline", "save", out, tmp_path / "b.json").assert_refused("several renderers; give one")


def test_a_folder_that_is_in_use_is_refused(call: Call, tmp_path: Path) -> None:
    folder = write_results(tmp_path / "a")
    call("merge", folder, "-o", folder).assert_refused("is not empty; give a new folder")

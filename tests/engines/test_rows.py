"""Rows of an engine from outside: drawn, scored, timed, skipped, and lost one by one."""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path

import pytest

from oitbench.cli.report import command as report
from oitbench.cli.run import command
from oitbench.engines import record
from oitbench.engines.known import GROUP
from oitbench.engines.record import PEER, EngineRow
from oitbench.engines.run import Job, run
from oitbench.errors import UsageError
from oitbench.image import metrics
from oitbench.matrix.plan import plan_matrix
from oitbench.matrix.run import run_matrix
from oitbench.measure.rounds import Schedule
from oitbench.plugins import Collection
from oitbench.report import Note, Table
from oitbench.truths import EXACT
from tests.report.made_up import context, finished

STACK, FOGGY = "layer_stack[count=3]", "layer_stack[transmission=colored]"
ROUNDS = 6
ENTRY = "abacus-1.0.dist-info/entry_points.txt"


def job(folder: Path, engine: str, scenes: list[str]) -> Job:
    """Run the cells of some scenes, and return the job that adds rows to them."""
    matrix = plan_matrix(scenes, ["weighted_sum"], "guard", (12, 8), out=folder, ssaa=1)
    assert run_matrix(matrix).exit_code == 0
    keys = [cell.key for cell in matrix.cells]
    limits = matrix.timeout, matrix.memory_limit
    return Job([engine], keys, folder, matrix.plugins, Schedule(ROUNDS, 0.0), *limits)


def test_rows_of_an_engine_from_outside(tmp_path: Path, abacus: str) -> None:
    work = job(tmp_path, abacus, [STACK, FOGGY])
    shown: list[EngineRow] = []
    rows = {(row.place.scene, row.algorithm): row for row in run(work, shown.append)}
    assert list(rows.values()) == shown == record.read(tmp_path)

    blend = rows[STACK, "blend"]
    assert blend.label == "abacus:blend"
    assert blend.status == "ok"
    assert not blend.reason
    assert (blend.version, blend.renderer, blend.same_renderer) == ("1.0", "beads", False)
    assert blend.drawn is not None
    assert blend.peer_drawn is not None
    assert (tmp_path / blend.drawn.image.path).is_file()
    # Both draw the same blending, so they agree with each other, and are as far from the truth.
    error = blend.drawn.scores[EXACT][metrics.RMSE]
    assert error == pytest.approx(blend.peer_drawn.scores[EXACT][metrics.RMSE], abs=1e-3)
    assert error is not None
    assert error > 0.05
    assert blend.drawn.scores[PEER][metrics.RMSE] == pytest.approx(0, abs=1e-3)
    assert blend.ratio is not None
    assert len(blend.ratio.samples) == ROUNDS

    assert rows[STACK, "refuse"].status == "skipped"
    assert rows[STACK, "refuse"].reason == "the beads are too few"
    assert rows[STACK, "raise"].status == "failed"
    assert "a bead fell off" in rows[STACK, "raise"].reason
    assert rows[STACK, "end"].status == "failed"
    assert "ended with code 3" in rows[STACK, "end"].reason
    later = rows[STACK, "end_later"]
    assert (later.status, later.ratio) == ("ok", None)
    assert later.reason.startswith("not timed: the worker process ended with code 3")

    for name in ("blend", "end"):
        assert rows[FOGGY, name].status == "skipped"
        assert rows[FOGGY, name].reason == (
            f"{FOGGY}: it requests colored_transmission; engines draw emission and opacity alone"
        )


def test_rows_of_other_places_are_kept(tmp_path: Path, abacus: str) -> None:
    work = job(tmp_path, abacus, [STACK, FOGGY])
    run(replace(work, cells=work.cells[:1], schedule=Schedule(0, 0.0)))
    run(replace(work, cells=work.cells[1:], schedule=Schedule(0, 0.0)))
    rows = record.read(tmp_path)
    assert [row.place.scene for row in rows if row.algorithm == "blend"] == [STACK, FOGGY]
    assert [row.ratio for row in rows] == [None] * len(rows)
    assert {row.drawn.image.path for row in rows if row.drawn} <= {
        f"{record.FOLDER}/{path.name}" for path in (tmp_path / record.FOLDER).glob("*.exr")
    }
    # A picture that no row names any more is removed.
    (tmp_path / record.FOLDER / "old.exr").touch()
    record.write(tmp_path, rows)
    assert not (tmp_path / record.FOLDER / "old.exr").exists()


def test_an_adapter_that_cannot_be_loaded_costs_only_its_rows(tmp_path: Path, abacus: str) -> None:
    work = job(tmp_path, abacus, [STACK])
    package = next(Path(folder) for folder in sys.path if (Path(folder) / ENTRY).is_file())
    (package / ENTRY).write_text(
        f"[{GROUP}]\nabacus = abacus_engine:Abacus\nlost = lost_engine:E\n"
    )
    rows = run(replace(work, engines=["lost", "abacus"], schedule=Schedule(0, 0.0)))
    assert (rows[0].label, rows[0].status) == ("lost", "failed")
    assert "No module named 'lost_engine'" in rows[0].reason
    assert {row.algorithm: row.status for row in rows}["blend"] == "ok"


def test_without_a_finished_cell_there_is_no_truth(tmp_path: Path, abacus: str) -> None:
    work = job(tmp_path, abacus, [FOGGY])
    matrix = plan_matrix([STACK], ["alpha_blend"], "guard", (12, 8), effects=["none"])
    rows = run(replace(work, cells=[cell.key for cell in matrix.cells]))
    reasons = {row.reason for row in rows}
    assert reasons == {"no cell with all effects and the default shading has finished here"}


def test_the_report_lists_rows_beside_their_peers(tmp_path: Path, abacus: str) -> None:
    section = Collection.load().reports["engines"]
    (note,) = section.build(context(tmp_path / "a", [finished(tmp_path, "s", "m", 0.1)], tmp_path))
    assert isinstance(note, Note)
    work = job(tmp_path / "b", abacus, [STACK])
    run(work)
    (table,) = section.build(context(work.folder, [], tmp_path))
    assert isinstance(table, Table)
    rows = {
        row[1]: dict(zip([c.key for c in table.columns], row, strict=True)) for row in table.rows
    }
    assert rows["abacus:blend"]["flip_between"] == pytest.approx(0, abs=0.01)
    assert rows["abacus:blend"]["renderer"] == "beads (another)"
    assert rows["abacus:refuse"]["ratio"] is None


def test_the_page_names_peers_that_were_not_run(
    tmp_path: Path, abacus: str, capsys: pytest.CaptureFixture[str]
) -> None:
    work = job(tmp_path, abacus, [STACK])
    run(replace(work, schedule=Schedule(0, 0.0)))
    with pytest.raises(SystemExit) as end:
        report.main([str(tmp_path), "--section", "engines"], standalone_mode=False)
    assert end.value.code == 0
    assert "section left out" not in capsys.readouterr().err
    assert "abacus:blend" in (tmp_path / "report" / "index.html").read_text(encoding="utf-8")


def test_a_wrong_name_is_refused_before_anything_runs(tmp_path: Path, abacus: str) -> None:
    with pytest.raises(UsageError, match=r"unknown engine 'abbacus'; did you mean abacus\?"):
        command.main(["--engine", "abbacus", "--out", str(tmp_path / "no")], standalone_mode=False)
    assert not (tmp_path / "no").exists()

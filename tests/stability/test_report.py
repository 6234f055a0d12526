"""The report of the results."""

from __future__ import annotations

from pathlib import Path

from oitbench.gl.device import Device
from oitbench.report import Note, ReportContext, Table
from oitbench.results.records import Results
from oitbench.results.schema import Renderer, RunFacts
from oitbench.stability import files
from tests.helpers import collection
from tests.stability.helpers import examine


def test_tables_show_errors_and_marks(device: Device, tmp_path: Path) -> None:
    names = ("single_layer_exact", "colored_layer_exact", "two halves")
    found = examine(device, "weighted_blended", *names) + examine(device, "a_buffer", *names)
    gl = Renderer("llvmpipe")
    files.write(tmp_path / "stability", found, gl)
    facts = RunFacts(gl=gl, seed=1)
    report = collection().reports["stability"]
    identities, cases, every = report.build(
        ReportContext(Results(tmp_path, (), facts), tmp_path / "out")
    )
    assert isinstance(identities, Table)
    assert isinstance(cases, Table)
    assert [row[:3] for row in identities.rows] == [
        ("weighted_blended", "✓", "–"),
        ("a_buffer", "✓", "✓"),
    ]
    assert [row[1] for row in cases.rows] == ["0.17", "✓"]
    assert isinstance(every, Table)
    assert len(every.rows) == len(found)


def test_a_note_says_how_to_add_results(tmp_path: Path) -> None:
    facts = RunFacts(gl=None, seed=1)
    report = collection().reports["stability"]
    (note,) = report.build(ReportContext(Results(tmp_path, (), facts), tmp_path / "out"))
    assert isinstance(note, Note)
    assert "oitbench stability --out" in note.text

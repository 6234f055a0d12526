"""`oitbench stability`: exit codes and output."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from oitbench.cli import main
from oitbench.stability import suite
from tests.stability.helpers import CHECKS, writing


@pytest.fixture(autouse=True)
def few_checks(monkeypatch: pytest.MonkeyPatch) -> None:
    few = tuple(CHECKS[name] for name in ("opaque_unchanged", "single_layer_exact", "two halves"))
    monkeypatch.setattr(suite, "checks", lambda: few)


def run(monkeypatch: pytest.MonkeyPatch, *arguments: str) -> int:
    """Return the exit code of the command."""
    monkeypatch.setattr("sys.argv", ["oitbench", "stability", *arguments])
    with pytest.raises(SystemExit) as stop:
        main()
    assert isinstance(stop.value.code, int)
    return stop.value.code


def test_programs_get_results_and_an_exit_code(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    writing(tmp_path, "vec4(0.5)")
    for name, code in (("a_buffer", 0), (str(tmp_path / "writing"), 1)):
        options = ("--method", name, "--out", str(tmp_path), "--json")
        assert run(monkeypatch, *options) == code
        content = json.loads(capsys.readouterr().out)
        assert content["gl"]["renderer"]
        assert any(result["failed"] for result in content["results"]) == bool(code)


def test_readers_get_counts_and_faults_by_name(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    writing(tmp_path, "vec4(0.5)")
    names = ("a_buffer[node=compact]", str(tmp_path / "writing"))
    options = [part for name in names for part in ("--method", name)]
    assert run(monkeypatch, *options, "--out", str(tmp_path)) == 1
    lines = capsys.readouterr().out.splitlines()
    rows = [[cell.strip() for cell in line.split("│")[1:-1]] for line in lines if "│" in line]
    assert rows == [
        ["a_buffer[node=compact]", "2 of 2", "–", "1 of 1", "0"],
        ["writing", "1 of 2", "–", "0 of 1", "1"],
    ]
    fault, path = lines[-2:]
    assert fault.startswith("writing: breaks single_layer_exact (error 0.")
    assert path == str(tmp_path / "stability.json")

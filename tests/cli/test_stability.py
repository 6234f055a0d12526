"""`oitbench stability`: exit codes and output."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from oitbench.stability import suite
from tests.cli.helpers import Call
from tests.stability.helpers import CHECKS, writing


@pytest.fixture(autouse=True)
def few_checks(monkeypatch: pytest.MonkeyPatch) -> None:
    few = tuple(CHECKS[name] for name in ("opaque_unchanged", "single_layer_exact", "two halves"))
    monkeypatch.setattr(suite, "checks", lambda: few)


def test_json_output_has_all_results_and_failures_set_the_exit_code(
    call: Call, tmp_path: Path
) -> None:
    writing(tmp_path, "vec4(0.5)")
    for name, code in (("a_buffer", 0), (str(tmp_path / "writing"), 1)):
        answer = call("stability", "--method", name, "--out", tmp_path, "--json")
        assert answer.code == code
        content = json.loads(answer.out)
        assert content["gl"]["renderer"]
        assert any(result["failed"] for result in content["results"]) == bool(code)


def test_text_output_has_counts_and_failures_by_name(call: Call, tmp_path: Path) -> None:
    writing(tmp_path, "vec4(0.5)")
    names = ("a_buffer[node=compact]", tmp_path / "writing")
    options = [part for name in names for part in ("--method", name)]
    answer = call("stability", *options, "--out", tmp_path)
    assert answer.code == 1
    lines = answer.out.splitlines()
    rows = [[cell.strip() for cell in line.split("│")[1:-1]] for line in lines if "│" in line]
    assert rows == [
        ["a_buffer[node=compact]", "2 of 2", "–", "1 of 1", "0"],
        ["writing", "1 of 2", "–", "0 of 1", "1"],
    ]
    # The checks that break, each with its values.
    broken = [line.split() for line in lines if line.strip().startswith("writing ")]
    assert [words[1] for words in broken] == ["single_layer_exact", "two"]
    assert [" ".join(words[-2:]) for words in broken] == ["promise broken", "hard case"]
    expected, measured, allowed = map(float, broken[0][2:5])
    assert measured == 0.5
    assert abs(measured - expected) > allowed
    assert lines[-1] == str(tmp_path / "stability.json")

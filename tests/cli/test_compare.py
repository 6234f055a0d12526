"""`oitbench compare` and `oitbench baseline`: findings, exit codes and refused input."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from oitbench.image import metrics
from tests.cli.helpers import Call
from tests.results.helpers import ALPHA, exact, write_changed, write_run


@pytest.fixture
def before(tmp_path: Path) -> Path:
    return write_run(tmp_path / "before")


def test_a_baseline_is_saved_and_checked_under_its_default_name(
    call: Call, before: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    answer = call("baseline", "save", before)
    assert (answer.code, answer.out) == (0, "baseline.json: 2 cells\n")
    answer = call("baseline", "check", before)
    assert (answer.code, answer.out) == (0, "2 cells compared, 0 regressions, 0 improvements\n")
    assert call("compare", before, "baseline.json").code == 0
    write_changed(before, exact(metrics.RMSE, 0.06))
    answer = call("baseline", "check", "now", "baseline.json")
    assert answer.code == 1
    (line,) = [line for line in answer.out.splitlines() if metrics.RMSE in line]
    assert line.split() == ["worse", *ALPHA.split(), f"exact.{metrics.RMSE}", "0.05", "0.06"]
    assert "1 regression," in answer.out


def test_json_output_has_every_finding(call: Call, before: Path) -> None:
    now = write_changed(before, exact(metrics.SSIM, 0.99))
    answer = call("compare", now, before, "--json")
    assert answer.code == 0
    assert json.loads(answer.out) == {
        "passed": True,
        "cells": 2,
        "renderer": {"before": "softly", "now": "softly"},
        "differences": [
            {
                "cell": ALPHA,
                "field": f"exact.{metrics.SSIM}",
                "before": 0.9,
                "now": 0.99,
                "verdict": "better",
                "allowed": 0.001,
                "regression": False,
            }
        ],
    }
    answer = call("compare", before, now, "--json")
    assert answer.code == 1
    assert json.loads(answer.out)["passed"] is False


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ("", "is no baseline"),
        ("[1]", "is no baseline of format 4"),
        ('{"format": 2, "renderer": "a", "cells": {}}', "is no baseline of format 4"),
        ('{"format": 4, "cells": {}}', "lacks its renderer or its cells"),
        ('{"format": 4, "renderer": "a", "cells": []}', "lacks its renderer or its cells"),
        ('{"format": 4, "renderer": "a", "cells": {"x": {}}}', "the cell x is damaged"),
        (
            '{"format": 4, "renderer": "a", "cells": {"x": {"status": "ok", "exact.f": "1"}}}',
            "the cell x is damaged",
        ),
        (
            '{"format": 4, "renderer": "a", "cells": {"x": {"status": "ok", "exact.f": NaN}}}',
            "NaN is not a finite number",
        ),
    ],
)
def test_a_damaged_baseline_is_refused(
    call: Call, before: Path, content: str, message: str
) -> None:
    damaged = before.parent / "damaged.json"
    damaged.write_text(content)
    call("compare", before, damaged).assert_refused(message)


def test_paths_that_cannot_be_used_are_refused(call: Call, before: Path) -> None:
    empty = before.parent / "empty"
    empty.mkdir()
    for arguments, message in (
        (("compare", before, "no/such/file"), "no/such/file cannot be read"),
        (("compare", empty, before), "holds no cells.jsonl"),
        (("baseline", "save", empty), "holds no cells.jsonl"),
        (
            ("baseline", "save", before, before / "cells.jsonl" / "b.json"),
            "cannot be written",
        ),
        (("baseline", "check", before, empty / "b.json"), "cannot be read"),
        (("baseline", "sav", before), "sav"),
    ):
        call(*arguments).assert_refused(message)


def test_a_page_is_written_where_it_is_asked_for(call: Call, before: Path) -> None:
    now = write_changed(before, exact(metrics.RMSE, 0.06))
    answer = call("compare", now, before, "--html")
    assert answer.code == 1
    assert answer.out.splitlines()[0] == str(now / "compare" / "index.html")
    assert f"exact.{metrics.RMSE}" in (now / "compare" / "index.html").read_text(encoding="utf-8")
    answer = call("compare", now, before, "--html", "--json", "-o", before.parent / "page")
    assert json.loads(answer.out)["passed"] is False
    assert (before.parent / "page" / "index.html").is_file()


def test_options_of_the_page_need_the_page(call: Call, before: Path) -> None:
    call("compare", before, before, "-o", "page").assert_refused("add --html")
    call("compare", before, before, "--open").assert_refused("add --html")

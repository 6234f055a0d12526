"""The files of results."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import pytest

from oitbench.errors import UsageError
from oitbench.results.schema import Nonfinite, Renderer
from oitbench.stability import files
from oitbench.stability.result import BREAKS, DOES_NOT_APPLY
from tests.stability.helpers import made_up

RESULTS = [
    made_up("single_layer_exact", BREAKS, identity=True, promised=True, error=0.5, allowed=0.1),
    made_up("α = 0", nonfinite=Nonfinite(nan=2, negative=1), repeatable=False),
    made_up("scatter", DOES_NOT_APPLY, reason="not random", may_be_negative=True, in_mean=True),
]


def written(folder: Path) -> Path:
    files.write(folder, RESULTS, Renderer("llvmpipe", software=True))
    return folder / files.JSON


def test_results_survive_a_file(tmp_path: Path) -> None:
    assert files.read(written(tmp_path / "new" / "folder")) == RESULTS


def test_the_json_file_has_a_version_and_states_failures(tmp_path: Path) -> None:
    text = written(tmp_path).read_text(encoding="utf-8")
    content = json.loads(text)
    assert (content["schema"], content["gl"]["renderer"]) == (2, "llvmpipe")
    assert [row["failed"] for row in content["results"]] == [True, True, False]
    assert "α = 0" in text


def test_the_csv_file_holds_everything(tmp_path: Path) -> None:
    with (written(tmp_path).with_name(files.CSV)).open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    assert [row["check"] for row in rows] == [result.check for result in RESULTS]
    fields = {*type(RESULTS[0]).__struct_fields__, "nan", "inf", "negative", "failed"}
    assert {*rows[0]} == fields - {"nonfinite"}
    assert rows[0]["error"] == "0.5"
    assert [rows[1][key] for key in ("nan", "inf", "negative", "failed")] == ["2", "0", "1", "True"]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ('{"gl": {}, "findings": []}', "by another version of oitbench (schema 0, this one has 2)"),
        (
            '{"schema": 7, "results": []}',
            "by another version of oitbench (schema 7, this one has 2)",
        ),
        ('{"schema": 2, "gl": {"renderer": "x"}, "results": [1]}', "holds no results"),
        ("[]", "holds no results"),
        ("{", "holds no results"),
        ("\xff", "holds no results"),
    ],
)
def test_other_files_are_refused_in_one_line(tmp_path: Path, text: str, message: str) -> None:
    path = tmp_path / files.JSON
    path.write_text(text, encoding="latin-1")
    with pytest.raises(UsageError) as error:
        files.read(path)
    assert str(error.value).startswith(str(path))
    assert message in str(error.value)
    assert "\n" not in str(error.value)


def test_a_file_that_does_not_exist_is_refused(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match=r"stability\.json cannot be read: No such file"):
        files.read(tmp_path / files.JSON)


def test_a_folder_that_cannot_be_written_to_is_refused(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    with pytest.raises(UsageError, match="cannot be written"):
        written(tmp_path / "file")

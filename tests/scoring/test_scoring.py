"""Cells that are scored from their stored images: values, faults, and what is kept."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from oitbench.errors import DeclarationError, OitbenchError, UsageError
from oitbench.image import metrics
from oitbench.results.schema import Record
from oitbench.results.store import IMAGES
from oitbench.results.table import flat
from oitbench.scoring.folder import score_folder
from oitbench.scoring.metric import load_metric
from oitbench.truths import EXACT, MATCHED
from tests.damage import flip_bit
from tests.made_up import changed, failed, write
from tests.scoring.helpers import (
    EXPOSURE,
    MAE,
    opened,
    picture,
    read,
    score,
    write_cell,
    write_metric,
    write_results,
)


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    return write_results(tmp_path / "results")


def values(record: Record, name: str = "mae_lin") -> list[float | None]:
    return [record.metric(truth, name) for truth in (EXACT, MATCHED)]


def test_a_metric_of_a_file_is_measured_against_every_truth(folder: Path, tmp_path: Path) -> None:
    before = read(folder)
    findings = score(folder, write_metric(tmp_path))
    assert (findings.scored, findings.lines) == (2, [])
    for number, (old, new) in enumerate(zip(before, read(folder), strict=True)):
        image = picture(3 + number)
        assert values(new) == [float(np.abs(image - picture(seed)).mean()) for seed in (1, 2)]
        assert flat(new)["matched.mae_lin"] == values(new)[1]
        outcome = new.outcome
        assert outcome is not None
        facts = outcome.custom["mae_lin"]
        assert (facts.higher_is_better, facts.tolerance) == (False, 1e-3)
        assert facts.relative_tolerance == 0.5
        kept = changed(new, "outcome.custom", {})
        for truth in (EXACT, MATCHED):
            found = dict(outcome.scores[truth].metrics)
            del found["mae_lin"]
            kept = changed(kept, f"outcome.scores.{truth}.metrics", found)
        assert kept == old


def test_the_metrics_of_the_suite_are_those_of_the_run(folder: Path) -> None:
    before = read(folder)
    files = {path: path.read_bytes() for path in (folder / IMAGES).iterdir()}
    assert score(folder, built_in=True).scored == 2
    assert read(folder) == before
    assert {path: path.read_bytes() for path in (folder / IMAGES).iterdir()} == files


def test_wrong_metrics_of_the_suite_are_replaced_and_others_are_kept(folder: Path) -> None:
    right = read(folder)
    wrong = [changed(r, f"outcome.scores.exact.metrics.{metrics.SSIM}", 9.0) for r in right]
    write(folder, wrong)
    score(folder, built_in=True)
    assert read(folder) == right


def test_a_changed_metric_is_measured_again_and_an_equal_one_is_current(
    folder: Path, tmp_path: Path
) -> None:
    path = write_metric(tmp_path)
    score(folder, path)
    first = read(folder)
    write_metric(tmp_path, MAE.replace('"""Mean absolute error."""', '"""Mean of all errors."""'))
    with opened(path) as scorer:
        assert all(scorer.is_current(record) for record in first)
    write_metric(tmp_path, MAE.replace(".mean()", ".max()"))
    with opened(path) as scorer:
        assert not any(scorer.is_current(record) for record in first)
        assert scorer.is_current(failed())
    score(folder, path)
    largest = [float(np.abs(picture(3) - picture(seed)).max()) for seed in (1, 2)]
    assert values(read(folder)[0]) == largest


@pytest.mark.parametrize("found", ["math.nan", "-math.inf", "np.float32('nan')"])
def test_values_that_are_not_finite_are_null(folder: Path, tmp_path: Path, found: str) -> None:
    text = MAE.replace("np.abs(test - reference).mean()", found)
    path = write_metric(tmp_path, f"import math\n{text}")
    assert load_metric(path).value(picture(1), picture(2), EXPOSURE) is None
    assert score(folder, path).lines == []
    assert values(read(folder)[0]) == [None, None]


def test_a_picture_with_nan_has_no_values_and_is_not_measured(tmp_path: Path) -> None:
    image = picture(3)
    image[0, 0, 0] = math.nan
    folder = tmp_path / "results"
    (folder / IMAGES).mkdir(parents=True)
    write(folder, [write_cell(folder, "mean", image, status="unstable")])
    path = write_metric(tmp_path, MAE.replace("return", "1 / 0 #"))
    assert score(folder, path, built_in=True).lines == []
    (record,) = read(folder)
    assert values(record) == values(record, metrics.RMSE) == [None, None]


@pytest.mark.parametrize(
    ("body", "message"),
    [
        ("return 1 / 0", "metric.py:12: ZeroDivisionError"),
        ("raise SystemExit(3)", "metric.py:12: SystemExit: 3"),
        ("return reference", "metric.py:11: measure returns ndarray; return a number"),
        ("return np.medain(test)", "did you mean median?"),
        ("import os; os._exit(3)", "metric.py: the worker process ended with code 3"),
        ("while True: pass", "took longer than 5 s while measuring bad"),
    ],
)
def test_a_metric_that_fails_costs_its_value_alone(
    folder: Path, tmp_path: Path, body: str, message: str
) -> None:
    good = write_metric(tmp_path, name="good.py")
    text = MAE.replace("mae_lin", "bad").replace("return np.abs(test - reference).mean()", body)
    bad = write_metric(tmp_path, text)
    before = read(folder)
    with opened(bad, good, timeout=5.0) as scorer:
        findings = score_folder(folder, scorer, built_in=False)
        (line,) = findings.lines
        assert line.startswith(f"bad: {tmp_path}")
        assert message in line
        assert line.endswith("no value in glass[count=4] mean, glass[count=4] peel")
        for old, new in zip(before, read(folder), strict=True):
            assert new.status == old.status == "ok"
            assert values(new, "bad") == [None, None]
            assert None not in values(new)
            outcome = new.outcome
            assert outcome is not None
            assert message in outcome.scores[EXACT].faults["bad"]
            # A fault may be that of the machine, so that the metric is tried again.
            assert not scorer.is_current(new)
    write_metric(tmp_path, text.replace(body, "return 0.5"))
    assert score(folder, bad).lines == []
    outcome = read(folder)[0].outcome
    assert outcome is not None
    assert outcome.scores[EXACT].faults == {}


def test_a_metric_that_writes_to_its_images_spoils_no_other(folder: Path, tmp_path: Path) -> None:
    text = MAE.replace("mae_lin", "greedy").replace(
        "return", "test[:] = 0; reference[:] = 1; return"
    )
    greedy = write_metric(tmp_path, text, "greedy.py")
    good = write_metric(tmp_path)
    score(folder, greedy, good)
    expected = float(np.abs(picture(3) - picture(1)).mean())
    assert values(read(folder)[0])[0] == expected


@pytest.mark.parametrize("damage", ["missing", "damaged"])
@pytest.mark.parametrize("kind", ["color", MATCHED])
def test_a_cell_with_a_damaged_image_keeps_its_numbers(
    folder: Path, tmp_path: Path, kind: str, damage: str
) -> None:
    before = read(folder)
    outcome = before[1].outcome
    assert outcome is not None
    path = folder / outcome.images[kind].path
    if damage == "missing":
        path.unlink()
    else:
        flip_bit(path, 8 * 500)
    findings = score(folder, write_metric(tmp_path), built_in=True)
    assert all(path.name in line and "keeps its numbers" in line for line in findings.damaged)
    spoiled = [1] if kind == "color" else [0, 1]  # Both cells have the same truth.
    assert len(findings.damaged) == len(spoiled)
    after = read(folder)
    assert [k for k in (0, 1) if after[k] == before[k]] == spoiled


def test_failed_cells_are_kept(folder: Path, tmp_path: Path) -> None:
    write(folder, [failed("broken")])
    assert score(folder, write_metric(tmp_path)).scored == 2
    assert read(folder)[-1] == failed("broken")


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('name = "mae_lin"', "", "defines no 'name'; every metric needs one"),
        ("higher_is_better = False", "", "defines no 'higher_is_better'"),
        ("def measure", "def measured", "defines no 'measure'"),
        ("False", "'no'", "higher_is_better is 'no'; give True or False"),
        ("1e-3", "-1", "tolerance is -1; give a number of at least 0"),
        ("0.5", "float('nan')", "relative_tolerance is nan; give a number"),
        ('"mae_lin"', '"a.b"', "name is 'a.b'; give a word"),
        ('"mae_lin"', '"=1"', "name is '=1'; give a word"),
        ('"mae_lin"', f'"{metrics.PSNR}"', "the suite has a metric 'psnr_srgb'; choose another"),
        ('"mae_lin"', f'"{metrics.TRANSMITTANCE}"', "the suite has a metric"),
        ("import numpy", "import nunpy", "metric.py:3: ModuleNotFoundError"),
        ("def", "df", "metric.py:11: SyntaxError"),
    ],
)
def test_a_file_that_is_no_metric_is_refused(
    tmp_path: Path, old: str, new: str, message: str
) -> None:
    path = write_metric(tmp_path, MAE.replace(old, new))
    with pytest.raises(DeclarationError) as caught, opened(path):
        pass
    assert str(caught.value).startswith(f"{path}")
    assert message in str(caught.value)


def test_files_that_cannot_be_used_are_refused(tmp_path: Path) -> None:
    first = write_metric(tmp_path, name="a.py")
    second = write_metric(tmp_path, name="b.py")
    for paths, message in (
        ([first, second], f"two metrics are named 'mae_lin': {first} and {second}; rename one"),
        ([tmp_path / "no.py"], "there is no such file"),
        ([write_metric(tmp_path, "import os; os._exit(2)", "c.py")], "c.py: the worker process"),
    ):
        with pytest.raises(OitbenchError) as caught, opened(*paths):
            pass
        assert message in str(caught.value)
    with pytest.raises(UsageError, match=r"holds no cells\.jsonl"):
        score(tmp_path / "nothing", first)
    assert not (tmp_path / "nothing").exists()


def test_a_metric_that_is_named_twice_is_one(tmp_path: Path) -> None:
    path = write_metric(tmp_path)
    with opened(path, path) as scorer:
        assert list(scorer.metrics) == ["mae_lin"]

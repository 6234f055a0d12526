"""The error of traced truths over the time of tracing."""

from __future__ import annotations

import math
from pathlib import Path

import msgspec
import numpy as np
import pytest

from oitbench.image import metrics, ties
from oitbench.image.files import Image
from oitbench.path_traced.references import storage
from oitbench.path_traced.references.storage import Reference, Rendering
from oitbench.report import tracing
from oitbench.results.schema import Fingerprints, Record, ReferenceFacts
from oitbench.truths import FULL, MATCHED
from tests.made_up import FINGERPRINTS
from tests.report.made_up import FLOOR, SIDE, context, finished

NOISE = 0.1


def rmse(image: Image, truth: Image) -> float:
    found = metrics.rmse(truth, image)
    assert found is not None
    return found


def noisy_parts() -> list[Image]:
    random = np.random.default_rng(3)
    clean = random.random((128, 128, 3))
    return [
        (clean + NOISE * random.standard_normal(clean.shape)).astype(np.float32)
        for _ in range(ties.PARTS)
    ]


@pytest.mark.parametrize("count", [1, 2, 4])
def test_the_error_is_that_of_the_mean_of_some_parts(count: int) -> None:
    found = tracing.error_of(count, noisy_parts(), rmse)
    assert found == pytest.approx(NOISE / math.sqrt(count), rel=0.02)


def test_the_noise_floor_continues_the_curve() -> None:
    parts = noisy_parts()
    half = tracing.error_of(4, parts, rmse)
    assert ties.noise_floor(parts, rmse) == pytest.approx(half / math.sqrt(2), rel=0.02)


def stored(folder: Path) -> tuple[Rendering, dict[str, tuple[Path, str]]]:
    """Return how a reference of eight noisy parts was rendered, and its place by its digest."""
    random = np.random.default_rng(4)
    rendering = Rendering(
        "panes", "matched", ["COVERAGE"], [], (SIDE, SIDE), 2, 4, ties.PARTS, 1, 1, "3", "f"
    )
    parts = tuple(
        (0.5 + NOISE * random.standard_normal((SIDE, SIDE, 3))).astype(np.float32)
        for _ in range(ties.PARTS)
    )
    storage.save(folder, Reference(rendering, {}, 16.0, parts))
    return rendering, {rendering.digest: (folder, rendering.key)}


def with_truths(cell: Record, matched: str) -> Record:
    fingerprints = msgspec.structs.replace(FINGERPRINTS, truths={MATCHED: matched, FULL: "q"})
    assert isinstance(fingerprints, Fingerprints)
    return msgspec.structs.replace(cell, fingerprints=fingerprints)


def test_stored_parts_are_measured_and_others_are_one_point(tmp_path: Path) -> None:
    rendering, places = stored(tmp_path / "reference")
    cell = finished(tmp_path, "panes", "murk", 0.3)
    for digest, count in ((rendering.digest, 4), ("another", 1)):
        shown = context(tmp_path, [with_truths(cell, digest)], tmp_path)
        (panel,) = shown.results.panels()
        matched, full = tracing.curves(shown, panel, places)
        assert (matched.truth, full.truth) == (MATCHED, FULL)
        assert len(matched.points) == count
        assert matched.points[-1] == full.points[-1] == (12.5, FLOOR)
        seconds, errors = zip(*matched.points, strict=True)
        assert seconds[0] == pytest.approx(12.5 / (8 if count > 1 else 1))
        assert list(errors) == sorted(errors, reverse=True)


def test_a_truth_without_noise_has_no_expected_line(tmp_path: Path) -> None:
    cell = finished(tmp_path, "panes", "murk", 0.3)
    assert cell.outcome is not None
    scores = dict(cell.outcome.scores)
    for truth in (MATCHED, FULL):
        facts = ReferenceFacts(2, 1, 1, truth == FULL, 2.0)
        scores[truth] = msgspec.structs.replace(scores[truth], reference=facts)
    cell = msgspec.structs.replace(
        cell, outcome=msgspec.structs.replace(cell.outcome, scores=scores)
    )
    shown = context(tmp_path, [cell], tmp_path)
    panels = shown.results.panels()
    matched, full = tracing.curves(shown, panels[0], {})
    assert matched.expected == ()
    first, last = full.expected
    assert first == pytest.approx((0.25, FLOOR * math.sqrt(8)))
    assert last == (2.0, FLOOR)
    figure = tracing.draw(shown, panels)
    assert figure is not None
    assert figure.png.is_file()


def test_results_without_traced_truths_have_no_figure(tmp_path: Path) -> None:
    shown = context(tmp_path, [finished(tmp_path, "a", "murk", 0.3, traced=False)], tmp_path)
    assert tracing.draw(shown, shown.results.panels()) is None

"""Ranks of methods, with ties."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from oitbench.image import metrics
from oitbench.image.ties import Errors
from oitbench.results.ranking import Ranking, ranking, truth_label
from oitbench.results.records import Results
from oitbench.truths import EXACT, MATCHED
from tests.report.made_up import FACTS, FLOOR, finished, unfinished, with_effects

COMMON = 0.01 * np.random.default_rng(1).standard_normal(8)
"""Noise that all methods share."""
OWN = 1e-3 * np.array([1, -1, 1, -1, 1, -1, 1, -1])


def errors(value: float, own: float = 0.0) -> Errors:
    """Return an error with common noise, and with noise of its own."""
    return Errors(value, list(value + COMMON + own * OWN))


def test_methods_that_do_not_clearly_differ_share_a_rank() -> None:
    # The standard error of a difference is √(7/8 · 8) · 10⁻³ = 2.6 · 10⁻³, so 6.2 · 10⁻³ is a tie.
    found = {"a": errors(0.1), "b": errors(0.106, 1), "c": errors(0.108, 1), "d": errors(0.2)}
    assert Ranking(MATCHED, found, FLOOR).ranks == {"a": "1=", "b": "1=", "c": "3", "d": "4"}
    assert Ranking(MATCHED, found, FLOOR).best == ["a", "b"]


def test_common_noise_hides_no_difference() -> None:
    found = {"a": errors(0.1), "b": errors(0.1001)}
    assert Ranking(MATCHED, found, 0.01).ranks == {"a": "1", "b": "2"}


def test_without_noise_only_equal_errors_tie() -> None:
    found = {"a": Errors(0.0), "b": Errors(0.0), "c": Errors(1e-9)}
    assert Ranking(EXACT, found, None).ranks == {"a": "1=", "b": "1=", "c": "3"}


def test_a_panel_is_ranked_by_its_own_truth_or_not_at_all(tmp_path: Path) -> None:
    cells = [
        finished(tmp_path, "plain", "glow", 0.2, traced=False),
        finished(tmp_path, "plain", "murk", 0.1, traced=False),
        unfinished("plain", "gone"),
        with_effects(tmp_path, "full", 0.1),
    ]
    plain, panes = Results(tmp_path, tuple(cells), FACTS).panels()
    found = ranking(plain, metrics.FLIP_LDR)
    assert (found.truth, list(found.errors), found.noise_floor) == (EXACT, ["murk", "glow"], None)
    assert truth_label(plain, EXACT) == "exact compositing"
    found = ranking(panes, metrics.FLIP_LDR)
    assert (found.truth, list(found.errors), found.noise_floor) == (MATCHED, ["full"], FLOOR)
    assert truth_label(panes, EXACT) == "exact compositing (compositing only)"
    assert truth_label(panes, MATCHED) == "matched tracing"


def test_exact_errors_never_stand_in_for_a_missing_truth(tmp_path: Path) -> None:
    diffuse = with_effects(tmp_path, "full", 0.1).outcome
    assert diffuse is not None
    cell = finished(
        tmp_path, "panes", "full", 0.1, traced=False, outcome={"effects": diffuse.effects}
    )
    (panel,) = Results(tmp_path, (cell,), FACTS).panels()
    assert panel.truth == MATCHED
    assert ranking(panel, metrics.FLIP_LDR).ranks == {}

"""Costs of cells that were not run, from those of others."""

from __future__ import annotations

import numpy as np
import pytest

from oitbench.matrix.cell import Cell
from oitbench.matrix.cost_model import CostModel

SCENES = {"light": 1.0, "heavy": 10.0, "middle": 3.0}
METHODS = {"cheap": 1.0, "dear": 4.0, "dear[k=8]": 8.0}


def cell(scene: str, method: str) -> Cell:
    return Cell(scene, method, (8, 8))


def cost(scene: str, method: str) -> float:
    return SCENES[scene] * METHODS[method]


def test_a_scene_and_a_method_that_were_seen_apart_are_predicted_together() -> None:
    pairs = [(scene, method) for scene in SCENES for method in METHODS]
    hidden = [("heavy", "dear[k=8]"), ("light", "dear")]
    model = CostModel([(cell(*pair), cost(*pair)) for pair in pairs if pair not in hidden])
    found = model.predict([cell(*pair) for pair in hidden])
    np.testing.assert_allclose(found, [cost(*pair) for pair in hidden], rtol=0.25)


def test_the_samples_themselves_add_up() -> None:
    pairs = [(cell(scene, method), cost(scene, method)) for scene in SCENES for method in METHODS]
    found = CostModel(pairs).predict([one for one, _ in pairs])
    assert found.sum() == pytest.approx(sum(SCENES.values()) * sum(METHODS.values()))


def test_an_unknown_variant_costs_what_its_method_costs() -> None:
    samples = [(cell("light", name), METHODS[name]) for name in ("cheap", "dear", "dear[k=8]")]
    cheap, dear = CostModel(samples).predict(
        [cell("light", "cheap[x=1]"), cell("light", "dear[k=2]")]
    )
    assert dear > 3 * cheap


def test_no_cost_is_no_number_that_is_not_finite() -> None:
    model = CostModel([(cell("light", "cheap"), 0.0), (cell("light", "dear"), 1.0)])
    assert np.isfinite(model.predict([cell("light", "cheap"), cell("other", "other")])).all()

"""The one truth that ranks the methods of a scene."""

from __future__ import annotations

import pytest

from oitbench.effects import SHADING, Effect, effects_of, names
from oitbench.truths import EXACT, MATCHED, ranking_truth, traced_effects

COMPOSITED = Effect.COVERAGE | Effect.COLORED_TRANSMISSION


@pytest.mark.parametrize(
    "effects", [Effect.NONE, Effect.COVERAGE, COMPOSITED, COMPOSITED | SHADING]
)
def test_compositing_ranks_what_it_and_shared_shading_express(effects: Effect) -> None:
    assert ranking_truth(effects) == EXACT


@pytest.mark.parametrize("beyond", [Effect.REFRACTION, Effect.DIFFUSION, Effect.VOLUME])
def test_any_effect_beyond_compositing_is_ranked_by_matched_tracing(beyond: Effect) -> None:
    assert ranking_truth(beyond) == MATCHED
    assert ranking_truth(COMPOSITED | SHADING | beyond) == MATCHED


def test_every_effect_is_compositing_shading_or_beyond() -> None:
    beyond = [effect for effect in Effect if ranking_truth(effect) == MATCHED]
    assert beyond == [Effect.REFRACTION, Effect.DIFFUSION, Effect.VOLUME]


def test_coverage_is_always_traced_if_it_is_requested() -> None:
    requested = Effect.COVERAGE | Effect.REFRACTION
    assert traced_effects(requested, ~Effect.REFRACTION) == Effect.COVERAGE
    assert traced_effects(requested, Effect.NONE) == Effect.COVERAGE
    assert traced_effects(Effect.SHADOWS, Effect.NONE) == Effect.NONE


def test_effects_have_names() -> None:
    effects = Effect.COVERAGE | Effect.VOLUME
    assert effects_of(names(effects)) == effects

"""Shots, renderings, expectations and the methods that a check applies to."""

from __future__ import annotations

import numpy as np
import pytest

from oitbench.stability import suite
from oitbench.stability.check import Expectation, Rendering, Shot
from oitbench.stability.identities import wall
from oitbench.stability.layers import random_lists, scene_of
from tests.helpers import method
from tests.stability.helpers import CHECKS


def test_a_shot_has_the_size_of_the_lists() -> None:
    scene = scene_of(random_lists(1, side=3))
    assert Shot(scene).pixels == (3, 3)
    assert Shot(scene, (5, 4)).pixels == (5, 4)
    with pytest.raises(ValueError, match="wall: a shot of a scene without lists needs a size"):
        _ = Shot(wall()).pixels


def test_images_have_three_channels() -> None:
    color, opaque = np.full((2, 3, 4), 0.25, np.float32), np.zeros((2, 3, 4), np.float32)
    one = Rendering(color, opaque)
    assert one.image.shape == one.opaque.shape == (2, 3, 3)
    assert (one.image == 0.25).all()
    assert not one.opaque.any()


def test_the_magnitude_is_at_least_one() -> None:
    small, large = (Expectation(np.zeros((1, 1, 3)), np.full((1, 1, 3), x)) for x in (0.1, -7.0))
    assert (small.magnitude, large.magnitude) == (1.0, 7.0)


def test_names_are_unique_and_described() -> None:
    assert len(CHECKS) == len(suite.checks())
    assert all(check.sentence for check in CHECKS.values())


@pytest.mark.parametrize(
    ("check", "name", "reason"),
    [
        ("colored_layer_exact", "alpha_blend", "does not show colored_transmission"),
        ("colored_layer_exact", "a_buffer", ""),
        ("resolution_independent", "alpha_blend", "neither refraction nor diffusion"),
        ("resolution_independent", "phenomenological", ""),
        ("scatter", "a_buffer", "not random"),
        ("scatter", "hashed_alpha", ""),
        ("crossing boxes", "stochastic[msaa=4]", "edges are antialiased"),
        ("crossing boxes", "stochastic", ""),
        ("3000 white walls", "depth_peeling", "3000 geometry passes"),
        ("3000 white walls", "a_buffer[resolve=iterative]", ""),
        ("two halves", "alpha_blend", ""),
    ],
)
def test_a_check_does_not_apply_to_every_method(check: str, name: str, reason: str) -> None:
    found = CHECKS[check].reason_to_skip(method(name))
    assert reason in found
    assert bool(found) == bool(reason)

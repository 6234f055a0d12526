"""Sprays: cards with empty borders, smooth edges, and tips that bend down."""

from __future__ import annotations

import numpy as np
import pytest

from oitbench.modeling.props.sprays import BORDER, Growth, Spray, bent_cards, frond, grass, twig
from oitbench.modeling.props.wire import mesh_fence


def spray_of(kind: str) -> Spray:
    random = np.random.default_rng(3)
    if kind == "twig":
        return twig(random, 60, (0.08, 0.13))
    return frond(random) if kind == "frond" else grass(random)


@pytest.mark.parametrize("kind", ["twig", "frond", "grass"])
def test_textures_have_an_empty_border_and_colors_where_they_cover(kind: str) -> None:
    spray = spray_of(kind)
    cover, color = spray.coverage.texels, spray.color.texels
    inner = cover[BORDER:-BORDER, BORDER:-BORDER]
    assert cover.sum() == inner.sum()
    assert cover.max() == 1
    assert 0.03 < cover.mean() < 0.5
    assert ((cover > 0) & (cover < 1)).any()
    assert (color[cover > 0.5].min(axis=1) > 0.02).all()
    assert (color[cover == 0] == 0).all()


def test_a_frond_is_symmetrical_and_tapers_to_its_tip() -> None:
    cover = spray_of("frond").coverage.texels
    assert np.abs(cover.sum(axis=1) - cover[:, ::-1].sum(axis=1)).max() < 1e-3
    rows = cover.sum(axis=1)
    assert rows[20:50].mean() < 0.5 * rows[120:170].mean()


def test_cards_stand_on_their_feet_and_bend_down() -> None:
    up = np.tile([0.0, 1.0, 0.0], (4, 1))
    upper = np.tile([0.0, 0.0, 1.0], (4, 1))
    feet = np.arange(12.0).reshape(4, 3)
    growth = Growth("kind", feet, up, upper, (0.1, 0.5), ((0, 0, 0),), spray_of("grass"), 0.3)
    cards = bent_cards(np.random.default_rng(0), growth, 1.0).positions.reshape(4, 6, 3)
    lowest = cards[..., 1].min(axis=1)
    np.testing.assert_allclose(lowest, feet[:, 1], atol=0.05)
    tips = np.take_along_axis(cards, cards[..., 1].argmax(axis=1)[:, None, None], axis=1)[:, 0]
    # The upper side is +z, so that the tip leaves it toward −z.
    assert (tips[:, 2] < feet[:, 2] - 0.05).all()


def test_wire_forms_diamonds() -> None:
    cover = mesh_fence().texels
    row = cover[130] > 0.5
    assert 20 < np.abs(np.diff(row.astype(int))).sum() < 90

"""Leaves: masks with an empty border, and cards in their places."""

from __future__ import annotations

import numpy as np
import pytest

from oitbench.modeling.props.leaves import (
    Plant,
    Shape,
    blossom,
    card_frames,
    colored_cards,
    lance,
    leaf_card,
    leaf_mask,
    lobed,
    ovate,
    place_leaves,
    trefoil,
)

PLANT = Plant("bush", (1, 2, 3), (0.5, 1, 0.5), ovate, (0.03, 0.06), 400, ((0, 1, 0),), hollow=0.4)


@pytest.mark.parametrize("shape", [ovate, lance, lobed, blossom, trefoil])
def test_a_leaf_fills_a_part_of_its_mask_inside_an_empty_border(shape: Shape) -> None:
    mask = leaf_mask(shape, 64).texels
    assert 0.2 < mask.mean() < 0.8
    assert mask[2:-2, 2:-2].sum() == mask.sum()
    assert set(np.unique(mask * 16)) <= set(range(17))
    # Every leaf is symmetric about its midrib.
    np.testing.assert_allclose(mask, mask[:, ::-1], atol=2 / 16)


def test_cards_point_to_their_tips() -> None:
    placed = card_frames([(1, 2, 3)], np.array([(0.0, 4, 0)]), np.array([(0.0, 1, 2)]), 0.5, 2.0)
    np.testing.assert_allclose(placed[0], [(0.5, 0, 0, 1), (0, 2, 0, 2), (0, 0, 0.5, 3)])


def test_leaves_are_in_the_outer_part_of_the_ellipsoid_and_hang() -> None:
    random = np.random.default_rng(1)
    leaves = place_leaves(PLANT, random, 1.0)
    reach = np.linalg.norm(leaves.places, axis=1)
    assert 0.4 <= reach.min() < 0.5
    assert 0.95 < reach.max() <= 1
    np.testing.assert_allclose(leaves.placements[:, :, 3].mean(axis=0), PLANT.center, atol=0.1)
    assert leaves.placements[:, 1, 1].mean() < -0.005
    assert ((leaves.shades >= 0) & (leaves.shades <= 1)).all()


def test_fewer_leaves_are_larger() -> None:
    few, many = (place_leaves(PLANT, np.random.default_rng(1), detail) for detail in (0.25, 1.0))
    assert len(many.shades) == 4 * len(few.shades)
    sizes = [np.linalg.norm(leaves.placements[:, :, 1], axis=1).mean() for leaves in (few, many)]
    assert sizes[0] == pytest.approx(2 * sizes[1], rel=0.1)


def test_cards_have_the_colors_of_their_leaves() -> None:
    plant = Plant("bush", (0, 0, 0), (1, 1, 1), ovate, (0.1, 0.1), 50, ((0, 0.2, 0), (0.4, 1, 0)))
    leaves = place_leaves(plant, np.random.default_rng(1), 1.0)
    cards = colored_cards(leaf_card(), leaves, plant)
    assert cards.albedo is not None
    albedo = cards.albedo.reshape(len(leaves.shades), -1, 3)
    np.testing.assert_allclose(
        albedo[..., 0], 0.4 * leaves.shades[:, None].repeat(12, 1), atol=1e-6
    )
    np.testing.assert_allclose(albedo[..., 2], 0)

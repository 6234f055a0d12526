"""The texture filter that both renderers share."""

from __future__ import annotations

import numpy as np
import pytest

from oitbench.scene import Material, Texture, Wrap
from oitbench.scene.texturing import (
    Images,
    constants_of,
    distinct_images,
    images_of,
    level_of_detail,
    lookup,
    premultiplied_pyramid,
    threshold_of,
)


def _random(*shape: int) -> Texture:
    return Texture(np.random.default_rng(3).random(shape).astype(np.float32))


def test_a_plain_material_has_no_textures() -> None:
    plain = Material(0.5, emission=(1, 2, 3))
    assert images_of(plain) == {}
    assert constants_of(plain) == ((1, 2, 3), 0.5)


def test_levels_halve_down_to_one_texel_even_for_wide_textures() -> None:
    pyramid = premultiplied_pyramid(Images(None, _random(2, 16)))
    assert [level.shape for level in pyramid] == [
        (2, 16, 4),
        (1, 8, 4),
        (1, 4, 4),
        (1, 2, 4),
        (1, 1, 4),
    ]


def test_emission_is_premultiplied_before_it_is_filtered() -> None:
    coverage, emission = _random(4, 4), _random(4, 4, 3)
    pyramid = premultiplied_pyramid(Images(emission, coverage))
    premultiplied = emission.texels * coverage.texels[..., None]
    np.testing.assert_allclose(pyramid[0][..., :3], premultiplied)
    np.testing.assert_allclose(pyramid[-1][0, 0, :3], premultiplied.mean(axis=(0, 1)), rtol=1e-6)
    np.testing.assert_allclose(pyramid[-1][0, 0, 3], coverage.texels.mean(), rtol=1e-6)


def test_constants_are_factors_on_textures_of_one() -> None:
    coverage, emission = _random(2, 2), _random(2, 2, 3)
    tinted, faint = Material(coverage, emission=(1, 2, 3)), Material(0.25, emission=emission)
    assert images_of(tinted) == {"emission": Images(None, coverage)}
    assert images_of(faint) == {"emission": Images(emission, None)}
    assert constants_of(tinted) == ((1, 2, 3), 1.0)
    assert constants_of(faint) == ((1, 1, 1), 0.25)
    first = premultiplied_pyramid(Images(None, coverage))[0]
    np.testing.assert_array_equal(first, np.repeat(coverage.texels[..., None], 4, axis=2))
    first = premultiplied_pyramid(Images(emission, None))[0]
    np.testing.assert_array_equal(first[..., :3], emission.texels)
    assert (first[..., 3] == 1).all()


def test_materials_of_other_constants_share_a_pair_of_textures() -> None:
    coverage = _random(2, 2)
    materials = [Material(coverage, emission=(float(k), 0, 0)) for k in range(3)]
    assert list(distinct_images(materials).values()) == [Images(None, coverage)]
    assert len(distinct_images([*materials, Material(_random(2, 2)), Material()])) == 2


def test_the_smaller_texture_of_a_pair_is_enlarged() -> None:
    emission = Texture(np.array([[0.0, 1.0]], dtype=np.float32))
    coverage = _random(3, 4)
    finest = premultiplied_pyramid(Images(emission, coverage))[0]
    np.testing.assert_array_equal(finest[..., 3], coverage.texels)
    # Centers of quarters, between the centers of halves: 0, 1/4, 3/4, 1.
    expected = coverage.texels * np.array([0, 0.25, 0.75, 1])
    np.testing.assert_allclose(finest[..., 0], expected, rtol=1e-6)
    around = (Wrap.REPEAT, Wrap.CLAMP)
    wrapped = Images(Texture(emission.texels, around), Texture(coverage.texels, around))
    expected = coverage.texels * np.array([0.25, 0.25, 0.75, 0.75])
    np.testing.assert_allclose(premultiplied_pyramid(wrapped)[0][..., 0], expected, rtol=1e-6)


@pytest.mark.parametrize("size", [(5, 3), (1, 7), (6, 10), (13, 1)])
def test_a_level_of_odd_sides_has_the_means_over_equal_areas(size: tuple[int, int]) -> None:
    texels = _random(*size).texels.astype(np.float64)
    pyramid = premultiplied_pyramid(Images(None, Texture(texels.astype(np.float32))))
    for level in pyramid[1:]:
        height, width = level.shape[:2]
        # Each texel as a block of equal ones, so that the blocks of both levels are whole.
        blocks = np.kron(texels, np.ones((height, width)))
        tall, wide = texels.shape
        parts = blocks.reshape(height, tall, width, wide)
        np.testing.assert_allclose(level[..., 3], parts.mean(axis=(1, 3)), rtol=1e-6)
        texels = level[..., 3].astype(np.float64)
    assert pyramid[-1].shape[:2] == (1, 1)
    assert len(pyramid) == int(np.log2(max(size))) + 1


def test_wraps_repeat_mirror_or_hold_the_edge() -> None:
    pyramid = premultiplied_pyramid(Images(None, _random(3, 5)))
    random = np.random.default_rng(4)
    inside, turns, zero = random.random((40, 2)), random.integers(-3, 4, (40, 2)), np.zeros(40)
    once = lookup(pyramid, inside, zero)
    repeated = Wrap.REPEAT, Wrap.REPEAT
    assert once.shape == (40, 4)
    np.testing.assert_allclose(
        lookup(pyramid, inside + turns, zero, repeated), lookup(pyramid, inside, zero, repeated)
    )
    folded = np.where(turns % 2 == 0, turns + inside, turns + 1 - inside)
    mirrored = lookup(pyramid, folded, zero, (Wrap.MIRROR, Wrap.MIRROR))
    np.testing.assert_allclose(mirrored, once)
    held = lookup(pyramid, [(-7.0, 0.5), (0.0, 0.5)], np.zeros(2), (Wrap.CLAMP, Wrap.REPEAT))
    np.testing.assert_array_equal(held[0], held[1])


def test_the_first_texel_follows_the_last_one_where_a_texture_repeats() -> None:
    pyramid = premultiplied_pyramid(
        Images(None, Texture(np.array([[2, 5, 8]], np.float32) / np.float32(8)))
    )
    wrap = Wrap.REPEAT, Wrap.CLAMP
    found = lookup(pyramid, [(0.0, 0.5), (1.0, 0.5), (1 / 6, 0.5), (0.05, 0.5)], np.zeros(4), wrap)
    np.testing.assert_allclose(8 * found[:, 3], [5, 5, 2, 2 + 0.35 * 6])


def test_each_property_has_a_pyramid_with_the_coverage() -> None:
    coverage, albedo, roughness = _random(4, 4), _random(2, 3, 3), _random(5, 5)
    leaf = Material(coverage, albedo=albedo, roughness=roughness, cutoff=0.5)
    assert images_of(leaf) == {
        "emission": Images(None, coverage, 0.5),
        "albedo": Images(albedo, coverage, 0.5),
        "roughness": Images(roughness, coverage, 0.5),
    }
    assert images_of(Material(albedo=albedo, cutoff=0.5)) == {"albedo": Images(albedo, None)}
    assert len(distinct_images([leaf, Material(coverage, albedo=albedo, cutoff=0.5)])) == 3
    assert len(distinct_images([leaf, Material(coverage, albedo=albedo)])) == 5


def test_a_cutoff_compares_with_the_factor_on_coverage() -> None:
    assert threshold_of(Material(_random(2, 2))) == 0
    assert threshold_of(Material(_random(2, 2), cutoff=0.25)) == 0.25
    assert threshold_of(Material(0.5, cutoff=0.25)) == 0.5
    assert threshold_of(Material(0.0, cutoff=0.25)) == np.inf
    assert constants_of(Material(0.5, cutoff=0.25)) == ((0, 0, 0), 1.0)


def _leaves(size: tuple[int, int], wrap: Wrap) -> Texture:
    """Return coverage of soft blobs, periodic."""
    random = np.random.default_rng(9)
    rows, columns = (np.arange(side) / side for side in size)
    total = np.zeros(size)
    for _ in range(12):
        row, column, width = random.random(3)
        down, across = (
            np.abs((axis - middle + 0.5) % 1 - 0.5)
            for axis, middle in ((rows, row), (columns, column))
        )
        total += np.exp(-(down[:, None] ** 2 + across**2) / (0.02 + 0.08 * width) ** 2)
    return Texture(np.minimum(total, 1).astype(np.float32), (wrap, wrap))


@pytest.mark.parametrize("wrap", [Wrap.CLAMP, Wrap.REPEAT])
@pytest.mark.parametrize("cutoff", [0.1, 0.5, 0.9])
def test_levels_keep_the_fraction_that_a_cutoff_leaves(cutoff: float, wrap: Wrap) -> None:
    coverage = _leaves((96, 75), wrap)
    emission = _random(96, 75, 3)
    color = Texture(emission.texels, coverage.wrap)
    places = np.random.default_rng(1).random((4000, 2))
    kept, plain = (
        premultiplied_pyramid(Images(color, coverage, limit)) for limit in (cutoff, None)
    )
    zero = np.zeros(len(places))
    shown = [
        [(lookup([level], places, zero, coverage.wrap)[:, 3] >= cutoff).mean() for level in pyramid]
        for pyramid in (kept, plain)
    ]
    assert 0.02 < shown[0][0] < 0.98
    # Levels down to 6 x 4 texels.
    np.testing.assert_allclose(shown[0][:5], shown[0][0], atol=0.03)
    assert abs(shown[1][4] - shown[1][0]) > 0.04
    for one, other in zip(kept, plain, strict=True):
        bright = one[..., 3] > 1e-3
        np.testing.assert_allclose(
            (one[..., :3] / one[..., 3:])[bright], (other[..., :3] / other[..., 3:])[bright],
            rtol=1e-4,
        )  # fmt: skip


def test_level_of_detail_follows_the_longer_side_and_stays_inside() -> None:
    dx = np.array([[4.0, 0], [0.1, 0], [0, 0], [3, 4], [1e9, 0]])
    dy = np.array([[0, 1.0], [0, 0.5], [0, 0], [2, 0], [0, 0]])
    expected = [2, 0, 0, np.log2(5), 4]
    np.testing.assert_allclose(level_of_detail(dx, dy, 5), expected)


def test_the_top_row_is_at_v_one() -> None:
    texels = np.zeros((4, 4), dtype=np.float32)
    texels[0, 3] = 1
    pyramid = premultiplied_pyramid(Images(None, Texture(texels)))
    found = lookup(pyramid, [(1.0, 1.0), (0.0, 1.0), (1.0, 0.0)], np.zeros(3))
    np.testing.assert_allclose(found[:, 3], [1, 0, 0])


def test_lookup_is_linear_between_centers_and_between_levels() -> None:
    pyramid = premultiplied_pyramid(Images(None, Texture(np.array([[0, 1]], dtype=np.float32))))
    between = lookup(pyramid, [(0.25, 0.5), (0.5, 0.5), (0.625, 0.5), (2.0, 0.5)], np.zeros(4))
    np.testing.assert_allclose(between[:, 3], [0, 0.5, 0.75, 1])
    np.testing.assert_allclose(lookup(pyramid, [(0.0, 0.5)], [0.5])[0, 3], 0.25)
    np.testing.assert_allclose(lookup(pyramid, [(0.0, 0.5)], [1.0])[0, 3], 0.5)

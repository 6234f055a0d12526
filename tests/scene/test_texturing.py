"""The texture filter that both renderers share."""

from __future__ import annotations

import numpy as np
import pytest

from oitbench.errors import SceneError
from oitbench.scene import Material, Texture
from oitbench.scene.texturing import (
    constants_of,
    distinct_images,
    images_of,
    level_of_detail,
    lookup,
    premultiplied_pyramid,
)


def _random(*shape: int) -> Texture:
    return Texture(np.random.default_rng(3).random(shape).astype(np.float32))


def test_a_plain_material_has_no_textures() -> None:
    plain = Material(0.5, emission=(1, 2, 3))
    assert images_of(plain) is None
    assert constants_of(plain) == ((1, 2, 3), 0.5)


def test_levels_halve_down_to_one_texel_even_for_wide_textures() -> None:
    pyramid = premultiplied_pyramid((None, _random(2, 16)))
    assert [level.shape for level in pyramid] == [
        (2, 16, 4),
        (1, 8, 4),
        (1, 4, 4),
        (1, 2, 4),
        (1, 1, 4),
    ]


def test_emission_is_premultiplied_before_it_is_filtered() -> None:
    coverage, emission = _random(4, 4), _random(4, 4, 3)
    pyramid = premultiplied_pyramid((emission, coverage))
    premultiplied = emission.texels * coverage.texels[..., None]
    np.testing.assert_allclose(pyramid[0][..., :3], premultiplied)
    np.testing.assert_allclose(pyramid[-1][0, 0, :3], premultiplied.mean(axis=(0, 1)), rtol=1e-6)
    np.testing.assert_allclose(pyramid[-1][0, 0, 3], coverage.texels.mean(), rtol=1e-6)


def test_constants_are_factors_on_textures_of_one() -> None:
    coverage, emission = _random(2, 2), _random(2, 2, 3)
    tinted, faint = Material(coverage, emission=(1, 2, 3)), Material(0.25, emission=emission)
    assert images_of(tinted) == (None, coverage)
    assert images_of(faint) == (emission, None)
    assert constants_of(tinted) == ((1, 2, 3), 1.0)
    assert constants_of(faint) == ((1, 1, 1), 0.25)
    first = premultiplied_pyramid((None, coverage))[0]
    np.testing.assert_array_equal(first, np.repeat(coverage.texels[..., None], 4, axis=2))
    first = premultiplied_pyramid((emission, None))[0]
    np.testing.assert_array_equal(first[..., :3], emission.texels)
    assert (first[..., 3] == 1).all()


def test_materials_of_other_constants_share_a_pair_of_textures() -> None:
    coverage = _random(2, 2)
    materials = [Material(coverage, emission=(float(k), 0, 0)) for k in range(3)]
    assert list(distinct_images(materials).values()) == [(None, coverage)]
    assert len(distinct_images([*materials, Material(_random(2, 2)), Material()])) == 2


def test_textures_of_different_sizes_are_refused() -> None:
    with pytest.raises(SceneError, match="2x4 and 4x4"):
        premultiplied_pyramid((_random(4, 2, 3), _random(4, 4)))


def test_level_of_detail_follows_the_longer_side_and_stays_inside() -> None:
    dx = np.array([[4.0, 0], [0.1, 0], [0, 0], [3, 4], [1e9, 0]])
    dy = np.array([[0, 1.0], [0, 0.5], [0, 0], [2, 0], [0, 0]])
    expected = [2, 0, 0, np.log2(5), 4]
    np.testing.assert_allclose(level_of_detail(dx, dy, 5), expected)


def test_the_top_row_is_at_v_one() -> None:
    texels = np.zeros((4, 4), dtype=np.float32)
    texels[0, 3] = 1
    pyramid = premultiplied_pyramid((None, Texture(texels)))
    found = lookup(pyramid, [(1.0, 1.0), (0.0, 1.0), (1.0, 0.0)], np.zeros(3))
    np.testing.assert_allclose(found[:, 3], [1, 0, 0])


def test_lookup_is_linear_between_centers_and_between_levels() -> None:
    pyramid = premultiplied_pyramid((None, Texture(np.array([[0, 1]], dtype=np.float32))))
    between = lookup(pyramid, [(0.25, 0.5), (0.5, 0.5), (0.625, 0.5), (2.0, 0.5)], np.zeros(4))
    np.testing.assert_allclose(between[:, 3], [0, 0.5, 0.75, 1])
    np.testing.assert_allclose(lookup(pyramid, [(0.0, 0.5)], [0.5])[0, 3], 0.25)
    np.testing.assert_allclose(lookup(pyramid, [(0.0, 0.5)], [1.0])[0, 3], 0.5)

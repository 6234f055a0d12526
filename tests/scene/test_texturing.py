"""The texture filter that both renderers share."""

from __future__ import annotations

import numpy as np
import pytest

from oitbench.errors import SceneError
from oitbench.scene import Material, Texture
from oitbench.scene.texturing import level_of_detail, lookup, premultiplied_pyramid


def _random(*shape: int) -> Texture:
    return Texture(np.random.default_rng(3).random(shape).astype(np.float32))


def test_a_plain_material_has_no_pyramid() -> None:
    assert premultiplied_pyramid(Material(0.5, emission=(1, 2, 3))) is None


def test_levels_halve_down_to_one_texel_even_for_wide_textures() -> None:
    pyramid = premultiplied_pyramid(Material(_random(2, 16)))
    assert pyramid is not None
    assert [level.shape for level in pyramid] == [
        (2, 16, 4),
        (1, 8, 4),
        (1, 4, 4),
        (1, 2, 4),
        (1, 1, 4),
    ]


def test_emission_is_premultiplied_before_it_is_filtered() -> None:
    coverage, emission = _random(4, 4), _random(4, 4, 3)
    pyramid = premultiplied_pyramid(Material(coverage, emission=emission))
    assert pyramid is not None
    premultiplied = emission.texels * coverage.texels[..., None]
    np.testing.assert_allclose(pyramid[0][..., :3], premultiplied)
    np.testing.assert_allclose(pyramid[-1][0, 0, :3], premultiplied.mean(axis=(0, 1)), rtol=1e-6)
    np.testing.assert_allclose(pyramid[-1][0, 0, 3], coverage.texels.mean(), rtol=1e-6)


def test_a_constant_fills_the_image() -> None:
    from_coverage = premultiplied_pyramid(Material(_random(2, 2), emission=(1, 2, 3)))
    from_emission = premultiplied_pyramid(Material(0.25, emission=_random(2, 2, 3)))
    assert from_coverage is not None
    assert from_emission is not None
    alpha = from_coverage[0][..., 3:]
    np.testing.assert_allclose(from_coverage[0][..., :3], alpha * [1, 2, 3], rtol=1e-6)
    np.testing.assert_allclose(from_emission[0][..., :3], 0.25 * _random(2, 2, 3).texels)
    assert (from_emission[0][..., 3] == 0.25).all()


def test_textures_of_different_sizes_are_refused() -> None:
    with pytest.raises(SceneError, match="2x4 and 4x4"):
        premultiplied_pyramid(Material(_random(4, 4), emission=_random(4, 2, 3)))


def test_level_of_detail_follows_the_longer_side_and_stays_inside() -> None:
    dx = np.array([[4.0, 0], [0.1, 0], [0, 0], [3, 4], [1e9, 0]])
    dy = np.array([[0, 1.0], [0, 0.5], [0, 0], [2, 0], [0, 0]])
    expected = [2, 0, 0, np.log2(5), 4]
    np.testing.assert_allclose(level_of_detail(dx, dy, 5), expected)


def test_the_top_row_is_at_v_one() -> None:
    texels = np.zeros((4, 4), dtype=np.float32)
    texels[0, 3] = 1
    pyramid = premultiplied_pyramid(Material(Texture(texels)))
    assert pyramid is not None
    found = lookup(pyramid, [(1.0, 1.0), (0.0, 1.0), (1.0, 0.0)], np.zeros(3))
    np.testing.assert_allclose(found[:, 3], [1, 0, 0])


def test_lookup_is_linear_between_centers_and_between_levels() -> None:
    pyramid = premultiplied_pyramid(Material(Texture(np.array([[0, 1]], dtype=np.float32))))
    assert pyramid is not None
    between = lookup(pyramid, [(0.25, 0.5), (0.5, 0.5), (0.625, 0.5), (2.0, 0.5)], np.zeros(4))
    np.testing.assert_allclose(between[:, 3], [0, 0.5, 0.75, 1])
    np.testing.assert_allclose(lookup(pyramid, [(0.0, 0.5)], [0.5])[0, 3], 0.25)
    np.testing.assert_allclose(lookup(pyramid, [(0.0, 0.5)], [1.0])[0, 3], 0.5)

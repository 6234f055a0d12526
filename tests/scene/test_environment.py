"""Means of an environment map against closed forms and quadrature."""

from __future__ import annotations

import math

import numpy as np
import pytest

from oitbench.scene import Material, Texture
from oitbench.scene.environment import (
    INCIDENCES,
    NODES,
    cosine_weight,
    lobe_fit,
    lobe_number,
    lobe_weight,
    mean_radiance,
    rough_lobes,
    weighted_means,
)
from tests.models import environment as model


def test_irradiance_of_a_linear_sky_has_its_closed_form() -> None:
    y = np.cos((np.arange(256) + 0.5) / 256 * math.pi)
    texels = np.broadcast_to((1 + 0.5 * y)[:, None, None], (256, 512, 3))
    table = weighted_means(texels, cosine_weight)
    expected = 1 + np.cos(np.linspace(0, math.pi, NODES)) / 3
    np.testing.assert_allclose(
        table, np.broadcast_to(expected[:, None, None], table.shape), rtol=1e-4
    )
    np.testing.assert_allclose(mean_radiance(texels), 1, rtol=1e-6)


def test_a_table_begins_straight_ahead_and_runs_to_the_right() -> None:
    texels = np.zeros((64, 128, 3))
    for channel, column in enumerate((64, 96, 0)):  # ahead, right, behind
        texels[31:33, column - 1 : column + 1, channel] = 1.0
    texels[31:33, -1, 2] = 1.0
    table = weighted_means(texels, lobe_weight(0.3))
    for channel, column in enumerate((0, 32, 64)):
        place = np.unravel_index(table[..., channel].argmax(), table.shape[:2])
        assert [int(one) for one in place] == [NODES // 2, column]


@pytest.mark.parametrize("shape", [(1, 1), (2, 4), (1, 4)])
def test_even_light_has_its_radiance_as_every_mean(shape: tuple[int, int]) -> None:
    texels = np.full((*shape, 3), (0.5, 1.0, 2.0))
    for weight in (cosine_weight, lobe_weight(0.4)):
        table = weighted_means(texels, weight)
        np.testing.assert_allclose(table, np.broadcast_to((0.5, 1.0, 2.0), table.shape), rtol=1e-12)


@pytest.mark.parametrize("roughness", [0.25, 0.5, 1.0])
def test_a_lobe_is_exact_along_the_normal(roughness: float) -> None:
    sky = model.sky()
    table = weighted_means(sky.texels.astype(np.float64), lobe_weight(roughness))
    right = table[NODES // 2, 32]
    d, radiance, solid = model.around(sky)
    weight = model.lobe((1, 0, 0), (1, 0, 0), d, 1.0, roughness) * solid
    np.testing.assert_allclose(right, weight @ radiance / weight.sum(), rtol=0.01)


@pytest.mark.parametrize("roughness", [0.3, 0.6, 1.0])
@pytest.mark.parametrize("place", [6, 32, 60])
def test_a_lobe_reflects_even_light_as_by_quadrature(roughness: float, place: int) -> None:
    fit = lobe_fit(roughness)[place]
    nv = place / (INCIDENCES - 1)
    v = np.array([math.sqrt(1 - nv * nv), nv, 0.0])
    white = Texture(np.ones((64, 128, 3), dtype=np.float32))
    d, _, solid = model.around(white)
    for reflectance in (0.04, 0.5):
        weight = model.lobe((0, 1, 0), v, d, reflectance, roughness) * solid
        assert reflectance * fit[0] + fit[1] == pytest.approx(weight.sum(), rel=0.01)
    lobe = model.lobe((0, 1, 0), v, d, 1.0, roughness) * solid
    middle = fit[2] * np.array([-v[0], v[1], 0]) + fit[3] * np.array([0, 1, 0])
    np.testing.assert_allclose(middle, lobe @ d, atol=0.01)


def test_lobes_belong_to_rough_surfaces_that_mirror() -> None:
    rough, smooth = Material(specular=0.04, roughness=0.5), Material(specular=0.04, roughness=0.0)
    matte, dust = Material(roughness=0.5), Material(specular=0.04, roughness=0.2, isotropic=True)
    fine = Material(specular=0.3, roughness=0.25)
    lobes = rough_lobes((rough, smooth, matte, dust, fine, rough))
    assert lobes == (0.25, 0.5)
    assert [lobe_number(one, lobes) for one in (rough, smooth, matte, dust, fine)] == [
        2, 0, 0, 0, 1,
    ]  # fmt: skip

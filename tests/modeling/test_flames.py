"""Light that is added: exact transmittance, pictures with an empty border."""

from __future__ import annotations

import numpy as np
import pytest

from oitbench.modeling.flames import added_light, flame, halo, plane, spark
from oitbench.scene import Texture

RAMP = ((1.0, 0.1, 0.0), (4.0, 3.0, 1.0))
LINE = np.stack([np.zeros(40), np.linspace(-0.5, 0.5, 40)], axis=1)
PICTURES = {
    "left flame": flame(-1.0, RAMP)[0],
    "right flame": flame(1.0, RAMP)[0],
    "spark": spark(),
    "halo": halo([LINE], 0.2),
}


@pytest.mark.parametrize("picture", PICTURES.values(), ids=PICTURES)
def test_pictures_are_fractions_with_an_empty_border(picture: Texture) -> None:
    texels = picture.texels
    assert texels.min() >= 0
    assert 0.5 < texels.max() <= 1
    assert np.count_nonzero(texels) == np.count_nonzero(texels[3:-3, 3:-3])


def test_added_light_hides_only_its_opacity() -> None:
    assert added_light(spark(), (1, 2, 3)).transmission == (1, 1, 1)
    assert added_light(spark(), (1, 2, 3), 0.25).transmission == (0.75, 0.75, 0.75)
    assert added_light(spark(), (1, 2, 3)).reflectance == 0


def test_a_flame_is_hottest_in_its_heart_and_narrow_at_its_tip() -> None:
    coverage, radiance = flame(1.0, RAMP)
    side = len(coverage.texels)
    heart, rim = coverage.texels > 0.8, (coverage.texels > 0) & (coverage.texels < 0.1)
    assert radiance.texels[heart].mean() > 2 * radiance.texels[rim].mean()
    wide = (coverage.texels > 0.05).sum(axis=1)
    assert wide[side // 8] < 0.6 * wide[3 * side // 4]


def test_flames_that_bend_differently_are_mirrored() -> None:
    left, right = (flame(bend, RAMP)[0].texels for bend in (-1.0, 1.0))
    np.testing.assert_allclose(left, right[:, ::-1], atol=1e-6)


def test_a_halo_falls_with_the_distance_from_its_line() -> None:
    x, y = plane()
    texels = halo([LINE], 0.2).texels
    level = np.abs(y[:, 0]) < 0.02
    row = texels[level][0]
    away = np.abs(x[0])
    near, far = (row[np.argmin(np.abs(away - at))] for at in (0.1, 0.3))
    assert far / near == pytest.approx(np.exp(-1) * ((0.92 - 0.3) / (0.92 - 0.1)) ** 0.5, rel=0.05)

"""Matched pictures that cannot be rendered."""

from __future__ import annotations

import pytest

from oitbench.errors import SceneError, UsageError
from oitbench.path_traced.matched.render import matched
from oitbench.scene import DirectionalLight, Material, Scene
from tests.path_traced.agreement import needs_mitsuba
from tests.path_traced.matched.scenes import ABOVE, floor

pytestmark = needs_mitsuba

MATTE = floor(Material(albedo=(1.0, 1.0, 1.0)))


def test_an_empty_picture_is_refused() -> None:
    with pytest.raises(UsageError, match="size 0x5"):
        matched(Scene("plane", ABOVE, (MATTE,)), (0, 5))


def test_light_that_single_precision_cannot_hold_is_refused() -> None:
    suns = tuple(DirectionalLight((0.1 * i, -1.0, 0.0), (3e38, 3e38, 3e38)) for i in range(4))
    with pytest.raises(SceneError, match="rays is not finite"):
        matched(Scene("bright", ABOVE, (MATTE,), lights=suns), (4, 4))

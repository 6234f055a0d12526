"""Effects that are left out of a matched picture: it equals that of a scene without their cause."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from oitbench.effects import Effect
from oitbench.path_traced.trace.surfaces import Surfaces
from oitbench.scene import Material, Object, Scene
from tests.path_traced.agreement import needs_mitsuba
from tests.path_traced.matched.scenes import ABOVE, PAPER, SUN, floor, image

pytestmark = needs_mitsuba

MATTE = floor(Material(albedo=PAPER))
TINTED = Material(transmission=(0.9, 0.6, 0.3))
GRAY = Material(transmission=(0.6, 0.6, 0.6))
DARK = Material(transmission=(0.5, 0.4, 0.2))


def _lid(material: Material) -> Object:
    """Return a surface that the camera does not see, between the floor and the sun."""
    return floor(material, 50.0, 5.0)


def _under(material: Material, left_out: Effect = Effect.NONE) -> Any:
    """Return the picture of a matte floor under a lid."""
    scene = Scene("lid", ABOVE, (MATTE, _lid(material)), lights=(SUN,))
    return image(scene, scene.effects & ~left_out)


def _bare() -> Any:
    return image(Scene("bare", ABOVE, (MATTE,), lights=(SUN,)))


def test_shadows() -> None:
    assert (_under(Material()) == 0).all()
    np.testing.assert_array_equal(_under(Material(), Effect.SHADOWS), _bare())
    both = Effect.SHADOWS | Effect.TRANSLUCENT_SHADOWS
    np.testing.assert_array_equal(_under(TINTED, both), _bare())


def test_opaque_surfaces_cast_no_translucent_shadows() -> None:
    np.testing.assert_array_equal(_under(TINTED, Effect.SHADOWS), _under(TINTED))


def test_without_translucent_shadows_half_of_the_light_decides() -> None:
    left_out = Effect.TRANSLUCENT_SHADOWS
    np.testing.assert_array_equal(_under(TINTED, left_out), _bare())
    assert (_under(DARK, left_out) == 0).all()
    assert (_under(DARK) > 0).all()


def test_without_colored_shadows_all_channels_lose_their_mean() -> None:
    gray = _under(GRAY)
    np.testing.assert_allclose(_under(TINTED, Effect.COLORED_SHADOWS), gray, rtol=1e-6)
    assert not np.allclose(_under(TINTED), gray, rtol=0.1)


def test_without_colored_transmission_layers_pass_their_mean() -> None:
    def seen(material: Material, left_out: Effect = Effect.NONE) -> Any:
        glow = floor(Material(emission=(1.0, 2.0, 3.0)))
        scene = Scene("seen", ABOVE, (glow, floor(material, 50.0, 1.0)))
        return image(scene, scene.effects & ~left_out)

    gray = seen(GRAY)
    np.testing.assert_allclose(seen(TINTED, Effect.COLORED_TRANSMISSION), gray, rtol=1e-6)
    assert not np.allclose(seen(TINTED), gray, rtol=0.1)


@pytest.fixture
def rays(monkeypatch: pytest.MonkeyPatch) -> Callable[[Scene, Effect], int]:
    """Return a function that counts the kinds of rays by which a scene is traced."""
    counts: list[None] = []
    intersect = Surfaces.intersect

    def counted(*arguments: Any, **options: Any) -> Any:
        counts.append(None)
        return intersect(*arguments, **options)

    monkeypatch.setattr(Surfaces, "intersect", counted)

    def count(scene: Scene, left_out: Effect = Effect.NONE) -> int:
        counts.clear()
        image(scene, scene.effects & ~left_out)
        return len(counts)

    return count


def test_shadows_that_do_not_run_have_no_rays(rays: Callable[..., int]) -> None:
    glow = rays(Scene("glow", ABOVE, (floor(Material(emission=PAPER)),)))
    lit = Scene("lit", ABOVE, (MATTE, _lid(TINTED)), lights=(SUN,))
    assert rays(lit) > glow
    assert rays(lit, Effect.SHADOWS | Effect.TRANSLUCENT_SHADOWS) == glow

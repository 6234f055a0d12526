"""Occlusion, diffusion and caustics in matched pictures."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from oitbench.effects import Effect
from oitbench.modeling.mesh import sphere
from oitbench.path_traced.matched.render import is_random, matched
from oitbench.scene import (
    DirectionalLight,
    EnvironmentLight,
    Floats,
    Material,
    Object,
    Scene,
)
from tests.path_traced.agreement import needs_mitsuba
from tests.path_traced.matched.scenes import ABOVE, PAPER, floor, image

pytestmark = needs_mitsuba

SKY = EnvironmentLight((1.0, 2.0, 3.0))
DOWN = DirectionalLight((0.0, -1.0, 0.0), (2.0, 3.0, 4.0))
MATTE = floor(Material(albedo=PAPER))
HEIGHT, RADIUS = 6.0, 10.0


def _under(ceiling: Material, ground: Material) -> Scene:
    """Return a ground under a wide ceiling, with occlusion."""
    objects = floor(ground), floor(ceiling, 500.0, HEIGHT)
    return Scene("occluded", ABOVE, objects, lights=(SKY,), ambient_occlusion=RADIUS)


@pytest.mark.parametrize("transmission", [0.0, 0.5])
def test_occlusion_ends_at_the_radius(transmission: float) -> None:
    # Of cosine-weighted directions, the part (h / r)² meets the ceiling beyond the radius.
    scene = _under(Material(transmission=(transmission,) * 3), Material(albedo=PAPER))
    found = matched(scene, (64, 64), 1, samples=8).mean(axis=(0, 1))
    beyond = (HEIGHT / RADIUS) ** 2
    opened = beyond + (1 - beyond) * transmission
    np.testing.assert_allclose(found, opened * np.multiply(PAPER, (1, 2, 3)), rtol=5e-3)


def test_occlusion_that_is_left_out_has_no_radius() -> None:
    scene = _under(Material(), Material(albedo=PAPER))
    found = image(scene, scene.effects & ~Effect.AMBIENT_OCCLUSION)
    expected = image(dataclasses.replace(scene, ambient_occlusion=0.0))
    np.testing.assert_array_equal(found, expected)


def test_mirrors_show_the_environment_alone() -> None:
    scene = _under(Material(), Material(specular=0.5, roughness=0.0))
    expected = image(dataclasses.replace(scene, ambient_occlusion=0.0))
    np.testing.assert_allclose(image(scene), expected, rtol=1e-6)


def _behind(pane: Material) -> Scene:
    """Return a pane over a ground that is bright on one side."""
    bright = dataclasses.replace(
        MATTE.mesh, positions=MATTE.mesh.positions + np.array([50.3, 0.1, 0])
    )
    objects = MATTE, Object("bright", bright, Material(emission=(1.0, 1.0, 1.0)))
    return Scene("behind", ABOVE, (*objects, floor(pane, 50.0, 2.0)), lights=(SKY,))


def test_diffusion_that_is_left_out_leaves_clear_glass() -> None:
    frosted = Material(transmission=(0.9, 0.6, 0.3), collimation=0.0)
    clear = dataclasses.replace(frosted, collimation=1.0)
    scene = _behind(frosted)
    expected = image(_behind(clear))
    found = image(scene, scene.effects & ~Effect.DIFFUSION)
    np.testing.assert_array_equal(found, expected)
    assert not np.allclose(image(scene), expected, rtol=1e-3)


def _ball(material: Material) -> Scene:
    ball = Object("ball", sphere((0.0, 9.0, 0.0), 2.0, 64, 32), material)
    return Scene("ball", ABOVE, (MATTE, ball), lights=(DOWN,))


GLASS = Material(transmission=(0.9, 0.6, 0.3), index=1.5, roughness=0.0, solid=True)


def test_caustics_that_are_left_out_leave_two_sheets() -> None:
    sheets = dataclasses.replace(GLASS, index=1.0, specular=0.04, solid=False)
    scene = _ball(GLASS)
    straight = image(scene, scene.effects & ~Effect.CAUSTICS)
    np.testing.assert_allclose(straight, image(_ball(sheets)), rtol=1e-5)
    bent = image(scene)
    assert not np.allclose(bent, straight, rtol=0.1)
    # A beam is bent even where lines of sight are not.
    again = image(scene, scene.effects & ~Effect.REFRACTION)
    np.testing.assert_allclose(again, bent, rtol=1e-5)


def test_refraction_and_diffusion_are_left_out_one_by_one() -> None:
    """Both are effects of one walk, in which the other one still runs."""
    frosted = Material(transmission=(0.9, 0.6, 0.3), collimation=0.0)
    clear = dataclasses.replace(frosted, collimation=1.0)
    sheets = dataclasses.replace(GLASS, index=1.0, specular=0.04, solid=False)

    def seen(pane: Material, ball: Material, left_out: Effect = Effect.NONE) -> Floats:
        low = Object("ball", sphere((0.0, 2.0, 1.0), 1.0, 64, 32), ball)
        scene = _behind(pane)
        scene = dataclasses.replace(scene, objects=(*scene.objects, low))
        return image(scene, scene.effects & ~left_out)

    without = seen(frosted, GLASS, Effect.DIFFUSION)
    np.testing.assert_array_equal(without, seen(clear, GLASS))
    without = seen(frosted, GLASS, Effect.REFRACTION)
    np.testing.assert_allclose(without, seen(frosted, sheets), rtol=1e-6)
    assert not np.allclose(without, seen(frosted, GLASS), rtol=0.01)


def test_parts_are_independent_and_repeat() -> None:
    def part(number: int) -> Floats:
        return np.asarray(
            matched(
                _behind(Material(transmission=(0.9, 0.6, 0.3), collimation=0.0)),
                (6, 5),
                1,
                part=number,
            )
        )

    np.testing.assert_array_equal(part(0), part(0))
    occluded = _under(Material(), Material(albedo=PAPER))
    one, other = (matched(occluded, (6, 5), 1, part=number) for number in (0, 1))
    assert (one != other).any()


def test_refraction_and_shadows_are_not_random() -> None:
    scene = _ball(GLASS)
    assert is_random(scene, scene.effects)
    assert not is_random(scene, scene.effects & ~Effect.CAUSTICS)


def test_faint_layers_get_few_shadow_rays_without_bias() -> None:
    # Without light of the environment, occlusion changes nothing but draws random numbers.
    smoke = Material(0.03, albedo=PAPER)
    layers = [floor(smoke, 50.0, 0.5 + 0.02 * number) for number in range(60)]
    shade = Object("shade", sphere((0.3, 3.0, 0.5), 0.4, 24, 12), Material())
    scene = Scene("smoke", ABOVE, (MATTE, *layers, shade), lights=(DOWN,), ambient_occlusion=1e-3)
    assert is_random(scene, scene.effects)
    exact = image(scene, scene.effects & ~Effect.AMBIENT_OCCLUSION)
    rough = matched(scene, (6, 5), 1).reshape(-1, 3)
    assert (np.abs(rough - exact) > 1e-4).any()
    mean = matched(scene, (6, 5), 1, samples=256).reshape(-1, 3)
    np.testing.assert_allclose(mean, exact, rtol=5e-3)

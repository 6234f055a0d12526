"""Alpha to coverage: identities of every driver, and a model of one driver's masks."""

from __future__ import annotations

import numpy as np
import pytest

from oitbench.errors import CapabilityError
from oitbench.gl.device import Device
from oitbench.measure import accounting
from oitbench.method.passes import Gather
from oitbench.method.storage import Target
from oitbench.modeling.mesh import quad
from oitbench.scene import Camera, Material, Mesh, Object, Scene
from tests.helpers import (
    BACKGROUND,
    GREEN,
    NOTHING,
    RED,
    WHITE,
    Layer,
    assert_order_independent,
    keeps_promises,
    opened,
    random_lists,
    render,
    scene_of,
    stack,
    step,
)
from tests.models.alpha_to_coverage import composite

NAME = "alpha_to_coverage"
SAMPLES = 4


@pytest.mark.parametrize("coverage", [0.0, 0.1, 0.25, 0.4, 0.5, 0.75, 0.9, 1.0])
def test_a_layer_covers_its_opacity_but_for_one_sample(device: Device, coverage: float) -> None:
    found = render(device, scene_of(stack([Layer(2.0, coverage, WHITE)]), NOTHING), NAME)
    levels = np.unique(found * SAMPLES)
    np.testing.assert_array_equal(levels, np.rint(levels))
    # Some drivers dither the masks of neighboring pixels.
    assert abs(found.mean() - coverage) < 1 / SAMPLES


def test_more_opacity_never_covers_less(device: Device) -> None:
    means = [
        render(device, scene_of(stack([Layer(2.0, o, WHITE)]), NOTHING), NAME).mean()
        for o in np.linspace(0, 1, 9)
    ]
    assert means == sorted(means)
    assert (means[0], means[-1]) == (0.0, 1.0)


def test_promises(device: Device) -> None:
    keeps_promises(device, NAME)


def test_the_order_of_the_draws_does_not_count(device: Device) -> None:
    with opened(device, scene_of(random_lists(9)), NAME) as frame:
        assert_order_independent(frame, 3)


def test_colors_do_not_depend_on_samples_that_others_have_taken(device: Device) -> None:
    # Slanted triangles that cross, whose colors vary over the surface.
    random = np.random.default_rng(5)
    objects = []
    for number in range(8):
        corners = random.uniform(-0.6, 0.6, (3, 3)) - [0, 0, 2]
        colors = random.uniform(0, 1, (3, 3)).astype(np.float32)
        mesh = Mesh(corners, np.array([[0, 1, 2]]), radiance=colors)
        material = Material(coverage=0.6, emission=WHITE)
        objects.append(Object(f"triangle {number}", mesh, material))
    scene = Scene("crossing", Camera((0, 0, 0), (0, 0, -1)), tuple(objects))
    with opened(device, scene, NAME, (32, 32)) as frame:
        assert_order_independent(frame, 6)


def test_layers_of_equal_opacity_transmit_as_much_as_one(device: Device) -> None:
    """The known failure: two halves should let a quarter pass."""
    pair = stack([Layer(2.0, 0.5, RED), Layer(3.0, 0.5, GREEN)])
    found = render(device, scene_of(pair, NOTHING), NAME).mean(axis=(0, 1))
    if device.software:
        assert found == pytest.approx([0.5, 0.0, 0.0])
    assert found[0] == pytest.approx(0.5)


def test_pictures_follow_the_masks_of_this_driver(device: Device) -> None:
    if "llvmpipe" not in device.renderer:
        pytest.skip("other drivers have other masks")
    lists = random_lists(7, seed=3)
    found = render(device, lists, NAME)
    expected = composite(lists, BACKGROUND, SAMPLES)
    np.testing.assert_allclose(found, expected, rtol=0, atol=2 * step(Target("rgba16f"), 1.0))


def test_opaque_surfaces_hide_what_is_behind_them(device: Device) -> None:
    sheet = Material(coverage=0.5, emission=WHITE)
    wall = Object("wall", quad((0, 0, -3), (9, 0, 0), (0, 9, 0)), Material(emission=RED))
    behind = Object("behind", quad((-2, 0, -4), (2, 0, 0.1), (0, 9, 0)), sheet)
    before = Object("before", quad((1, 0, -2), (1, 0, 0.1), (0, 9, 0)), sheet)
    scene = Scene("sheets", Camera((0, 0, 0), (0, 0, -1)), (wall, behind, before))
    found = render(device, scene, NAME, size=(24, 24))
    np.testing.assert_array_equal(found[:, :12], np.broadcast_to(np.array(RED), (24, 12, 3)))
    assert found[:, 13:].mean() > 0.5


def test_memory_is_the_depth_of_all_samples(device: Device) -> None:
    with opened(device, scene_of(random_lists(3)), NAME) as frame:
        frame.render()
        assert accounting.memory(frame).bits_per_pixel == 32 * SAMPLES
        drawn = [item.name for item in frame.plan.passes if isinstance(item, Gather)]
        terms = accounting.traffic(frame, frame.measure()).terms
        assert {t.resource for t in terms if t.pass_ in drawn} == {"color", "depth"}


def test_other_passes_have_no_masks(device: Device) -> None:
    """The state of one method must not stay for the next one."""
    lists = random_lists(4)
    expected = render(device, lists, "weighted_blended[msaa=4]")
    render(device, lists, NAME)
    np.testing.assert_array_equal(render(device, lists, "weighted_blended[msaa=4]"), expected)


def test_more_samples_than_the_driver_has_are_refused(device: Device) -> None:
    if device.limits["GL_MAX_SAMPLES"] >= 8:
        found = render(
            device, scene_of(stack([Layer(2.0, 0.125, WHITE)]), NOTHING), NAME + "[msaa=8]"
        )
        assert abs(found.mean() - 0.125) < 1 / 8
        return
    with pytest.raises(CapabilityError, match="GL_MAX_SAMPLES"):
        render(device, random_lists(1), f"{NAME}[msaa=8]")

"""Visibility curves: the fragments that a probe finds at a pixel, and the curves of methods."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from oitbench.errors import UsageError
from oitbench.gl.device import Device
from oitbench.gl.probe import probe
from oitbench.gl.uploaded_scene import UploadedScene
from oitbench.measure import visibility
from oitbench.measure.oracle import composite
from oitbench.report.visibility import extent, write
from oitbench.scene import Camera, FragmentLists
from oitbench.stability.layers import BLUE, GREEN, RED, Layer, stack
from tests.helpers import collection, method, opened, random_lists, scene_of

SIZE = (96, 80)
CAMERA = Camera((0, 0, 0), (0, 0, -1), near=0.1)
LAYERS = [Layer(4, 0.5, RED), Layer(2, 0.25, BLUE), Layer(3, 0.5, GREEN, (0.5, 0.5, 0.5))]


def one_pixel(*layers: Layer) -> FragmentLists:
    return stack(layers, 1)


@pytest.mark.parametrize("pixel", [(48, 40), (40, 30), (57, 50)])
def test_the_fragments_of_the_probe_composite_to_the_pixel(
    device: Device, pixel: tuple[int, int]
) -> None:
    scene = collection().build_scene("smoke_ball[detail=0.1]")
    with UploadedScene(device, scene) as uploaded:
        found = probe(uploaded, SIZE, pixel)
    with opened(device, scene, "a_buffer", SIZE) as frame:
        frame.render()
        row, column = pixel[1], pixel[0]
        behind = frame.read("opaque_color")[row, column, :3]
        assert len(found.z) == frame.complexity[SIZE[1] - 1 - row, column] > 1
        expected = frame.image()[row, column]
    np.testing.assert_allclose(composite(found, behind)[0, 0], expected, rtol=0, atol=1e-6)


def test_the_probe_keeps_the_order_of_the_draws(device: Device) -> None:
    lists = random_lists(40)
    with UploadedScene(device, scene_of(lists)) as uploaded:
        found = probe(uploaded, (16, 16), (3, 5))
    np.testing.assert_array_equal(found.z[:, 0, 0], lists.z[:, 5, 3])
    np.testing.assert_array_equal(found.coverage[:, 0, 0], lists.coverage[:, 5, 3])
    np.testing.assert_array_equal(found.radiance[:, 0, 0], lists.radiance[:, 5, 3])


def test_an_empty_pixel_has_no_fragments(device: Device) -> None:
    with UploadedScene(device, collection().build_scene("smoke_ball[detail=0.1]")) as uploaded:
        assert len(probe(uploaded, SIZE, (0, 0)).z) == 0


def test_the_exact_curve_is_the_product_of_nearer_transmittances() -> None:
    found = visibility.exact_curve(one_pixel(*LAYERS))[:, 0]
    # At 4, 2 and 3 m, and behind: transmittances 0.5, 0.75 and 0.75.
    assert found == pytest.approx([0.75 * 0.75, 1.0, 0.75, 0.5 * 0.75 * 0.75])


def test_exact_methods_have_the_exact_curve(device: Device) -> None:
    fragments = one_pixel(*LAYERS)
    exact = visibility.exact_curve(fragments)
    for name in ("a_buffer", "depth_peeling", "sorted_over"):
        found, noise = visibility.method_curve(device, method(name), fragments, CAMERA)
        np.testing.assert_allclose(found, exact, rtol=0, atol=4e-3)
        assert noise.max() == 0


def test_unsorted_blending_follows_the_order_of_the_draws(device: Device) -> None:
    found, _ = visibility.method_curve(device, method("alpha_blend"), one_pixel(*LAYERS), CAMERA)
    # The last draw is in front of all others, at any depth.
    assert found[:, 0] == pytest.approx([0.75 * 0.75, 0.75, 1.0, 0.28125], abs=2e-3)


def test_curves_have_gaps_at_layers_without_coverage(device: Device) -> None:
    fragments = one_pixel(Layer(1, 0.5), Layer(2, 0.0), Layer(3, 0.5))
    found, _ = visibility.method_curve(device, method("a_buffer"), fragments, CAMERA)
    for curve in (found, visibility.exact_curve(fragments)):
        assert np.isnan(curve[1]).all()
        assert curve[[0, 2, 3], 0] == pytest.approx([1.0, 0.5, 0.25], abs=1e-3)


def test_colored_glass_has_one_curve_per_channel(device: Device) -> None:
    fragments = one_pixel(Layer(1, 1.0, RED, (1.0, 0.5, 0.25)), Layer(2, 0.5))
    found, _ = visibility.method_curve(device, method("a_buffer"), fragments, CAMERA)
    assert found[1] == pytest.approx([1.0, 0.5, 0.25], abs=1e-3)


def test_curves_of_random_methods_are_averaged(device: Device) -> None:
    chosen = method("stochastic[correction=none]")
    fragments = one_pixel(Layer(1, 0.5), Layer(2, 0.5))
    found, noise = visibility.method_curve(device, chosen, fragments, CAMERA)
    assert (noise[1] > 0).all()
    assert abs(found[1] - 0.5).max() < 5 * noise[1].max()


@pytest.mark.parametrize("coverage", [1e-6, 0.0])
def test_the_axis_ends_at_the_last_change(coverage: float) -> None:
    fragments = one_pixel(Layer(1, 0.5), Layer(2, 0.5), Layer(1000, coverage))
    curve = visibility.exact_curve(fragments)
    curves = visibility.Curves("s", (0, 0), (1, 1), fragments, curve, {}, {}, {}, {}, {})
    first, last = extent(curves)
    assert first < 1
    assert 2 < last < 3


def test_a_folder_that_cannot_be_written_to_is_refused(tmp_path: Path) -> None:
    fragments = one_pixel(*LAYERS)
    curve = visibility.exact_curve(fragments)
    curves = visibility.Curves("s", (0, 0), (1, 1), fragments, curve, {}, {}, {}, {}, {})
    (tmp_path / "file").write_text("")
    with pytest.raises(UsageError, match="give -o DIR"):
        write(curves, tmp_path / "file")

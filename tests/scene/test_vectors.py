"""Frames along a direction."""

from __future__ import annotations

import numpy as np
import pytest

from oitbench.scene import Camera, Vector, as_vector, axes_along, opposite, unit


@pytest.mark.parametrize("back", [(0, 3, 0), (0, -1, 0), (1, 2, -2), (-0.2, 0, 5)])
@pytest.mark.parametrize("up", [None, (1, 0.3, 0.2)])
def test_axes_are_a_right_handed_frame_along_the_direction(back: Vector, up: Vector | None) -> None:
    axes = axes_along(back, up)
    np.testing.assert_allclose(axes @ axes.T, np.eye(3), atol=1e-12)
    assert np.linalg.det(axes) == pytest.approx(1)
    np.testing.assert_allclose(axes[2], np.asarray(back) / np.linalg.norm(back))
    if up is not None:
        assert axes[1] @ np.asarray(up) > 0
        assert axes[0] @ np.asarray(up) == pytest.approx(0)


def test_a_camera_looks_along_minus_z_with_y_up() -> None:
    camera = Camera(position=(1, 2, 3), target=(1, 2, -4))
    np.testing.assert_allclose(camera.axes, np.eye(3), atol=1e-12)
    np.testing.assert_allclose(camera.view_distance([(0, 0, 3), (5, 5, -7)]), [0, 10])


@pytest.mark.parametrize(
    ("view", "up", "expected"),
    [
        ((0, -1, 0), (0, 1, 0), (0, 0, -1)),
        ((0, 1, 0), (0, 1, 0), (0, 0, 1)),
        ((0, 0, -1), (0, 0, 1), (0, 1, 0)),
        ((0, 0, 1), (0, 0, 1), (0, -1, 0)),
        ((-2, 0, 0), (7, 0, 0), (0, 0, -1)),
        ((0, -5, 0), (1e-12, 5, 0), (0, 0, -1)),
    ],
)
def test_a_camera_that_looks_along_up_has_turned_there_from_the_horizon(
    view: Vector, up: Vector, expected: Vector
) -> None:
    axes = Camera((1, 2, 3), as_vector(np.add((1, 2, 3), view)), up).axes
    np.testing.assert_allclose(axes[1], expected, atol=1e-12)
    np.testing.assert_allclose(axes @ axes.T, np.eye(3), atol=1e-12)
    # A camera that has turned almost as far has nearly the same axes.
    horizon = -np.sign(np.dot(view, up)) * np.asarray(expected)
    nearly = as_vector(np.add((1, 2, 3), view) + 1e-6 * horizon)
    np.testing.assert_allclose(Camera((1, 2, 3), nearly, up).axes, axes, atol=1e-5)


@pytest.mark.parametrize("length", [1e-200, 1e200])
def test_directions_of_any_length_have_axes(length: float) -> None:
    expected = axes_along((1, 2, -2), (0, 1, 0))
    back, up = np.multiply((1, 2, -2), length), (0.0, length, 0.0)
    np.testing.assert_allclose(axes_along(back, up), expected, atol=1e-12)
    np.testing.assert_allclose(unit(back), expected[2], atol=1e-12)


def test_tuples_and_unit_vectors() -> None:
    assert as_vector(np.array([1, 2.5, -3], np.float32)) == (1.0, 2.5, -3.0)
    assert opposite((1, -2, 3)) == (-1, 2, -3)
    np.testing.assert_allclose(unit(np.array([[3.0, 0, 4], [0, 2, 0]])), [(0.6, 0, 0.8), (0, 1, 0)])

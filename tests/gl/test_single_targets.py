"""Targets with one sample per pixel in a multisampled frame."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from oitbench.errors import DeclarationError
from oitbench.gl.device import Device
from oitbench.modeling.mesh import quad
from oitbench.scene import WHITE, Camera, Material, Object, Scene
from tests.helpers import foreign_method, opened, write_method

TARGETS = '{"one": Target("r32f", single=True), "four": Target("r32f")}'
SEPARATE = """(
        Gather("one.glsl", writes={"one": ADD}),
        Gather("four.glsl", writes={"four": ADD}),
    )"""
TOGETHER = """(Gather("one.glsl", writes={"one": ADD, "four": ADD}),)"""
SHADERS = {name: f"void gather(Fragment fragment) {{ {name} = 1.0; }}" for name in ("one", "four")}


@pytest.fixture
def rotated() -> Scene:
    """A rotated pane, and a rotated wall that hides a part of it; their edges cross pixels."""
    pane = Object("pane", quad((0, 0, -4), (0.9, 0.3, 0), (-0.3, 0.9, 0)), Material(coverage=0.5))
    wall = Object("wall", quad((1, 0, -3), (0.8, 0.2, 0), (-0.1, 3, 0)), Material(emission=WHITE))
    return Scene("rotated", Camera((0, 0, 0), (0, 0, -1)), (pane, wall))


def test_a_single_target_counts_centers_and_other_targets_count_samples(
    device: Device, rotated: Scene, tmp_path: Path
) -> None:
    members = "sample_count = 4"
    folder = write_method(tmp_path / "counting", SEPARATE, TARGETS, members=members, **SHADERS)
    with opened(device, rotated, foreign_method(folder), (64, 64)) as frame:
        frame.render()
        one, four = frame.read("one")[..., 0], frame.read("four")[..., 0]
        centers = frame.complexity[::-1]
    np.testing.assert_array_equal(one, centers)
    assert set(np.unique(one)) == {0, 1}
    # Partly covered pixels, at the pane's edges and at the wall's.
    assert set(np.unique(four)) == {0, 0.25, 0.5, 0.75, 1}
    assert (abs(one - four) <= 0.75).all()


def test_passes_into_single_targets_read_the_opaque_depth_at_centers(
    device: Device, rotated: Scene, tmp_path: Path
) -> None:
    shaders = {
        name: f"void resolve() {{ {name} = read_opaque_depth(); }}" for name in ("one", "four")
    }
    passes = SEPARATE.replace("Gather", "Resolve").replace("writes", "reads=D, writes")
    folder = write_method(
        tmp_path / "reading",
        passes.replace("D,", '("opaque_depth",),'),
        TARGETS,
        members="sample_count = 4",
        **shaders,
    )
    with opened(device, rotated, foreign_method(folder), (64, 64)) as frame:
        frame.render()
        one, four = frame.read("one"), frame.read("four")
    with opened(device, rotated, "alpha_blend", (64, 64)) as frame:
        frame.render()
        np.testing.assert_array_equal(one, frame.read("opaque_depth"))
    assert len(np.unique(one)) == 2
    assert len(np.unique(four)) > 2


def test_a_pass_that_writes_single_and_other_targets_is_refused(
    device: Device, rotated: Scene, tmp_path: Path
) -> None:
    chosen = foreign_method(write_method(tmp_path / "mixed", TOGETHER, TARGETS, **SHADERS))
    refused = pytest.raises(DeclarationError, match="all targets or none must be single")
    with refused, opened(device, rotated, chosen, (8, 8)):
        pass

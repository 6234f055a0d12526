"""`oitbench render`: pictures, and refused input."""

from __future__ import annotations

from pathlib import Path

import pytest

from oitbench.image.files import read_exr
from tests.cli.helpers import NO_EGL, SMALL, Call, spawn

STACK = ("render", "layer_stack", "a_buffer")


def test_a_picture_has_the_requested_size(tmp_path: Path) -> None:
    out = tmp_path / "picture.exr"
    answer = spawn(*STACK, "-o", str(out), "--size", "24x16")
    assert answer.code == 0, answer.err
    image = read_exr(out)
    assert image.shape == (16, 24, 3)
    assert image.max() > 0.1


@pytest.mark.usefixtures("empty_folder")
@pytest.mark.parametrize(
    ("arguments", "message"), [((*STACK, "-o", "x.jpg"), ".jpg"), (STACK, "--out")]
)
def test_wrong_input_is_refused_and_nothing_is_written(
    call: Call, arguments: tuple[str, ...], message: str
) -> None:
    call(*arguments).assert_refused(message)


@pytest.mark.parametrize(
    ("scene", "message"),
    [
        ("poisoned", "background holds NaN or infinity"),
        ("raiser", "raiser.py:14: ValueError: the scene is unwell"),
    ],
)
def test_a_scene_that_cannot_be_built_is_refused(
    call: Call, plugins: Path, tmp_path: Path, scene: str, message: str
) -> None:
    out = ("-o", tmp_path / "x.exr", "--collection", plugins)
    call("render", scene, "alpha_blend", *out, *SMALL).assert_refused(message)


def test_an_error_in_a_shader_has_its_file_and_line(
    call: Call, plugins: Path, tmp_path: Path
) -> None:
    folder = plugins / "methods" / "broken"
    answer = call("render", "layer_stack", folder, "-o", tmp_path / "x.exr", *SMALL)
    answer.assert_refused(f"oitbench: {folder}/draw.glsl:2: error")


def test_a_frame_beyond_the_limit_of_the_driver_is_refused(call: Call, tmp_path: Path) -> None:
    answer = call(*STACK, "-o", tmp_path / "x.exr", "--size", "999999x1")
    answer.assert_refused("the driver's limit")


def test_without_egl_the_error_names_the_missing_package(tmp_path: Path) -> None:
    answer = spawn(*STACK, "-o", str(tmp_path / "x.exr"), **NO_EGL)
    answer.assert_no_driver()


def test_a_file_that_cannot_be_written_is_named(call: Call) -> None:
    answer = call("render", "layer_stack", "alpha_blend", "-o", "/proc/x.exr", *SMALL)
    answer.assert_refused("/proc/x.exr")

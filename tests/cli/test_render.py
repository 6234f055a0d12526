"""`oitbench render`: pictures, and refused input."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from PIL import Image as PngImage

from oitbench.image.files import read_exr, to_srgb
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


TARGETS = ("render", "chess[detail=0.1]", "phenomenological")


def test_targets_are_listed_and_nothing_is_written(call: Call, empty_folder: None) -> None:
    answer = call(*TARGETS, "--target", "list", "--size", "8x6")
    assert answer.code == 0, answer.err
    lines = [line.split() for line in answer.out.splitlines()]
    assert ["delta", "8x6", "rg8_snorm"] in lines
    assert not any(line[0] == "shadow_map" for line in lines)  # slices have none
    assert ["refraction", "8x6", "rg", "of", "delta,", "rg8_snorm"] in lines
    published = "--shading", "translucent=published"
    answer = call(*TARGETS, "--target", "list", "--size", "8x6", *published)
    lines = [line.split() for line in answer.out.splitlines()]
    assert ["shadow_map", "1024x1024", "3", "×", "r32f"] in lines


def test_a_target_is_written_raw_and_for_display(call: Call, tmp_path: Path) -> None:
    answer = call(*TARGETS, "--target", "beta", "-o", tmp_path / "x.exr", "--size", "24x16")
    assert answer.code == 0, answer.err
    raw = read_exr(tmp_path / "x.exr")
    assert raw.shape == (16, 24, 3)
    np.testing.assert_allclose(raw * 255, np.rint(raw * 255), atol=1e-4)
    names = ("--target", "beta,refraction")
    answer = call(*TARGETS, *names, "-o", tmp_path / "y.png", "--size", "24x16")
    assert answer.code == 0, answer.err
    assert f"{tmp_path}/y-refraction.png: refraction, rg of delta, rg8_snorm: gray 0" in answer.out
    with PngImage.open(tmp_path / "y-beta.png") as picture:
        assert picture.info["Description"] == "beta, rgb8: black 0, white 1, sRGB"
        shown = np.asarray(picture)
    np.testing.assert_array_equal(shown, np.rint(to_srgb(raw, 0.0) * 255))
    assert not (tmp_path / "y.png").exists()


def test_all_targets_are_written_at_any_setting_of_effects(call: Call, tmp_path: Path) -> None:
    arguments = ("--target", "all", "--effects=none", "-o", tmp_path / "x.png", "--size", "8x6")
    assert call(*TARGETS, *arguments).code == 0
    assert {path.stem for path in tmp_path.iterdir()} == {
        f"x-{name}"
        for name in (
            "accum", "accumulated", "beta", "color", "opaque_color", "opaque_depth",
            "transmittance",
        )
    }  # fmt: skip


@pytest.mark.parametrize(
    ("names", "message"),
    [
        ("diffusion", "needs DIFFUSION, which chess[detail=0.1] does not request"),
        ("bta", "unknown target 'bta'; did you mean beta"),
        (",", "cannot read targets"),
        ("beta,list", "give list alone"),
    ],
)
@pytest.mark.usefixtures("empty_folder")
def test_targets_that_do_not_exist_are_refused(call: Call, names: str, message: str) -> None:
    call(*TARGETS, "--target", names, "-o", "x.png", *SMALL).assert_refused(message)

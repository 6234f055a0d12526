"""Image files, the sRGB encoding and the box filter."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import OpenEXR
import pytest

from oitbench.atomic import replacing
from oitbench.errors import StorageError, UsageError
from oitbench.image import files as images
from tests.damage import largest_file
from tests.image.helpers import constant


def test_srgb_matches_the_standard() -> None:
    # IEC 61966-2-1: 18 % gray is encoded as 0.4614, and dark values are linear.
    encoded = images.to_srgb(constant((0.18, 0.001, 2.0)), 0.0)
    assert encoded[0, 0] == pytest.approx([0.461356, 0.01292, 1.0], abs=1e-5)
    assert images.to_srgb(constant((0.09, 0, 0)), 1.0)[0, 0, 0] == encoded[0, 0, 0]


@pytest.mark.parametrize("half", [False, True])
def test_exr_keeps_values_and_rows(tmp_path: Path, picture: images.Image, half: bool) -> None:
    stored = picture.astype(np.float16).astype(np.float32) if half else picture.copy()
    stored[0, 1], stored[2, 3] = np.nan, np.inf
    # A flipped view is not contiguous, and OpenEXR's binding would misread it.
    images.write_exr(tmp_path / "a" / "b.exr", stored[::-1], half=half)
    assert np.array_equal(images.read_exr(tmp_path / "a" / "b.exr"), stored[::-1], equal_nan=True)
    assert [path.name for path in (tmp_path / "a").iterdir()] == ["b.exr"]


def test_values_that_do_not_fit_a_half_float_are_refused(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="does not fit a half"):
        images.write_exr(tmp_path / "a.exr", constant((1e6, 0, 0)), half=True)


def test_missing_and_damaged_images_are_refused(tmp_path: Path, picture: images.Image) -> None:
    with pytest.raises(UsageError, match=r"no\.exr: there is no such image"):
        images.read_exr(tmp_path / "no.exr")
    path = tmp_path / "cut.exr"
    images.write_exr(path, picture)
    path.write_bytes(path.read_bytes()[:-500])
    with pytest.raises(UsageError, match=r"cut\.exr is not a readable OpenEXR image"):
        images.read_exr(path)


def test_flip_maps_keep_values_and_rows(tmp_path: Path, picture: images.Image) -> None:
    ldr, hdr = picture[..., 0], picture[::-1, ::2, 1].repeat(2, axis=1)
    path = tmp_path / "b.exr"
    images.write_channels(path, images.flip_channels(ldr, hdr))
    for stored, errors in zip(images.read_flip_maps(path), (ldr, hdr), strict=True):
        assert stored.dtype == np.float32
        np.testing.assert_array_equal(stored, errors.astype(np.float16).astype(np.float32))
    with OpenEXR.File(str(path)) as file:
        stored_types = {name: channel.pixels.dtype for name, channel in file.channels().items()}
    assert stored_types == {"ldr": np.float16, "hdr": np.float16}


def test_counts_stay_integers(tmp_path: Path, picture: images.Image) -> None:
    counts = np.arange(12).reshape(3, 4) + 2**31
    images.write_channels(tmp_path / "counts.exr", images.count_channels(counts))
    found = images.read_counts(tmp_path / "counts.exr")
    assert found.dtype == np.uint32
    np.testing.assert_array_equal(found, counts)
    images.write_exr(tmp_path / "picture.exr", picture)
    with pytest.raises(UsageError, match="no channel fragments"):
        images.read_counts(tmp_path / "picture.exr")


def test_flip_maps_and_images_are_distinguished(tmp_path: Path, picture: images.Image) -> None:
    images.write_exr(tmp_path / "image.exr", picture)
    with pytest.raises(UsageError, match=r"image\.exr has no channel ldr and hdr"):
        images.read_flip_maps(tmp_path / "image.exr")
    maps = images.flip_channels(picture[..., 0], picture[..., 1])
    images.write_channels(tmp_path / "maps.exr", maps)
    with pytest.raises(UsageError, match=r"has the channels .*, but RGB is needed"):
        images.read_exr(tmp_path / "maps.exr")
    with pytest.raises(UsageError, match="there is no such image"):
        images.read_flip_maps(tmp_path / "none.exr")
    for pair in ((picture, picture), (picture[..., 0], picture[1:, :, 0])):
        with pytest.raises(ValueError, match=r"both must be \(h, w\)"):
            images.flip_channels(*pair)


def test_a_full_disk_keeps_the_old_image(tmp_path: Path, picture: images.Image) -> None:
    path = tmp_path / "a.exr"
    images.write_exr(path, picture)
    for size in range(1, path.stat().st_size, 37):
        with largest_file(size), pytest.raises(StorageError, match="cannot be written"):
            images.write_exr(path, picture * np.float32(2))
        assert [item.name for item in tmp_path.iterdir()] == ["a.exr"]
    np.testing.assert_array_equal(images.read_exr(path), picture)


def test_a_failed_write_keeps_the_old_file_and_leaves_no_partial_one(tmp_path: Path) -> None:
    path = tmp_path / "a.txt"
    path.write_text("old")

    def fail() -> None:
        with replacing(path) as partial:
            partial.write_text("new")
            raise KeyError

    with pytest.raises(KeyError):
        fail()
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]


def test_an_image_in_a_file_instead_of_a_folder_is_refused(
    tmp_path: Path, picture: images.Image
) -> None:
    (tmp_path / "file").touch()
    with pytest.raises(UsageError, match="cannot be written"):
        images.write_exr(tmp_path / "file" / "a.exr", picture)


def test_png_marks_pixels_that_are_not_finite(tmp_path: Path) -> None:
    from PIL import Image

    picture = constant((0.5, 0.5, 0.5))
    picture[3, 4, 1] = np.nan
    images.write_png(tmp_path / "a.png", picture)
    levels = np.asarray(Image.open(tmp_path / "a.png"))
    assert levels[3, 4].tolist() == [255, 0, 255]
    assert levels[0, 0].tolist() == [128, 128, 128]


def test_box_downsample_averages_blocks() -> None:
    picture = np.arange(4 * 6 * 3, dtype=np.float32).reshape(4, 6, 3)
    small = images.box_downsample(picture, 2)
    assert small.shape == (2, 3, 3)
    assert small[1, 2] == pytest.approx(picture[2:4, 4:6].mean(axis=(0, 1)))
    with pytest.raises(ValueError, match="cannot be averaged"):
        images.box_downsample(picture, 4)

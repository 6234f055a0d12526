"""Pictures of other programs: PNG, JPEG, Radiance HDR and OpenEXR."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import OpenEXR
import pytest
from PIL import Image as Picture

from oitbench.errors import UsageError
from oitbench.image.files import to_srgb, write_exr
from oitbench.image.reading import read_image
from tests.importing.files import picture

HEAD = b"#?RADIANCE\n# made here\nFORMAT=32-bit_rle_rgbe\n\n"


def levels(*shape: int) -> Any:
    return np.random.default_rng(2).integers(0, 256, shape).astype(np.uint8)


@pytest.mark.parametrize("mode", ["RGB", "RGBA", "L", "LA"])
def test_png_is_srgb_with_linear_alpha(tmp_path: Path, mode: str) -> None:
    pixels = levels(5, 7, len(mode)).squeeze()
    Picture.fromarray(pixels, mode).save(tmp_path / "a.png")
    found = read_image(tmp_path / "a.png")
    assert found.dtype == np.float32
    wide = pixels.reshape(5, 7, -1)
    color = wide[..., :3] if mode.startswith("RGB") else np.repeat(wide[..., :1], 3, axis=2)
    np.testing.assert_allclose(255 * to_srgb(found[..., :3], 0), color, atol=1e-3)
    assert found.shape[2] == (4 if mode.endswith("A") else 3)
    if mode.endswith("A"):
        np.testing.assert_allclose(found[..., 3], wide[..., -1] / 255, rtol=1e-6)
    np.testing.assert_array_equal(read_image((tmp_path / "a.png").read_bytes()), found)


def test_palettes_and_sixteen_bits_are_read(tmp_path: Path) -> None:
    pixels = np.repeat(levels(4, 4, 1) // 64 * 64, 3, axis=2)
    Picture.fromarray(pixels).convert("P", palette=Picture.Palette.ADAPTIVE).save(
        tmp_path / "p.png"
    )
    np.testing.assert_allclose(255 * to_srgb(read_image(tmp_path / "p.png"), 0), pixels, atol=1e-3)
    deep = levels(4, 4).astype(np.uint16) * 257
    Picture.fromarray(deep).save(tmp_path / "d.png")
    found = 255 * to_srgb(read_image(tmp_path / "d.png"), 0)
    np.testing.assert_allclose(found, np.repeat(deep[..., None] / 257, 3, axis=2), atol=1e-3)


def test_jpeg_is_srgb(tmp_path: Path) -> None:
    pixels = np.full((8, 8, 3), (200, 100, 50), np.uint8)
    Picture.fromarray(pixels).save(tmp_path / "a.jpg", quality=100)
    np.testing.assert_allclose(255 * to_srgb(read_image(tmp_path / "a.jpg"), 0), pixels, atol=3)


def test_openexr_keeps_values_and_alpha(tmp_path: Path) -> None:
    image = np.random.default_rng(1).random((3, 5, 3)).astype(np.float32) * 1000
    write_exr(tmp_path / "a.exr", image)
    np.testing.assert_array_equal(read_image(tmp_path / "a.exr"), image)
    four = np.random.default_rng(1).random((3, 5, 4)).astype(np.float32)
    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
    OpenEXR.File(header, {"RGBA": four}).write(str(tmp_path / "b.exr"))
    np.testing.assert_array_equal(read_image(tmp_path / "b.exr"), four)
    OpenEXR.File(header, {"Y": four[..., 0].copy()}).write(str(tmp_path / "c.exr"))
    expected = np.repeat(four[..., :1], 3, axis=2)
    np.testing.assert_array_equal(read_image(tmp_path / "c.exr"), expected)
    with pytest.raises(UsageError, match="has 5x3 pixels; at most 14 are read"):
        read_image(tmp_path / "c.exr", 14)


def packed(rgbe: Any) -> bytes:
    """Return rows of Radiance pixels, each channel as runs of equal bytes and single ones."""
    rows = []
    for row in rgbe:
        parts = [bytes([2, 2, len(row) >> 8, len(row) & 255])]
        for channel in row.T:
            at = 0
            while at < len(channel):
                equal = at + 1
                while equal < min(len(channel), at + 127) and channel[equal] == channel[at]:
                    equal += 1
                run = equal - at
                parts.append(
                    bytes([128 + run, channel[at]]) if run > 2 else bytes([1, channel[at]])
                )
                at = equal if run > 2 else at + 1
        rows.append(b"".join(parts))
    return b"".join(rows)


@pytest.mark.parametrize("width", [5, 8, 300])
@pytest.mark.parametrize("pack", [True, False])
def test_radiance_pictures_have_a_shared_exponent(width: int, pack: bool) -> None:
    rgbe = levels(4, width, 4)
    rgbe[..., 3] = rgbe[..., 3] // 8 + 112
    rgbe[0, :4] = 0
    rgbe[1, :, :2] = 77
    pack = pack and width >= 8
    content = HEAD + b"-Y 4 +X %d\n" % width + (packed(rgbe) if pack else rgbe.tobytes())
    expected = (rgbe[..., :3] + 0.5) * 2.0 ** (rgbe[..., 3:].astype(float) - 136)
    expected[rgbe[..., 3] == 0] = 0
    np.testing.assert_allclose(read_image(content), expected, rtol=1e-6)


def test_a_black_row_of_a_radiance_picture_takes_few_bytes() -> None:
    content = HEAD + b"-Y 2 +X 400\n" + packed(np.zeros((2, 400, 4), np.uint8))
    assert (read_image(content) == 0).all()


WRONG = {
    "exr": bytes([0x76, 0x2F, 0x31, 0x01]) + b" and no more",
    "bomb": picture(30000, 30000, b""),
    "text": b"a text",
    "png": b"\x89PNG\r\n\x1a\n rest",
    "head": HEAD + b"+Y 2 +X 2\n" + bytes(16),
    "format": HEAD.replace(b"rgbe", b"xyze") + b"-Y 2 +X 2\n" + bytes(16),
    "short": HEAD + b"-Y 2 +X 2\n" + bytes(15),
    "lie": HEAD + b"-Y 90000 +X 2\n" + bytes(16),
    "run": HEAD + b"-Y 1 +X 8\n" + bytes([2, 2, 0, 8, 137, 1, *[0] * 40]),
    "empty run": HEAD + b"-Y 1 +X 8\n" + bytes([2, 2, 0, 8, 0, 1, *[0] * 40]),
    "row": HEAD + b"-Y 2 +X 8\n" + bytes([2, 2, 0, 8, *[136, 1] * 4, 2, 2, 0, 9, *[136, 1] * 8]),
}


@pytest.mark.parametrize("kind", WRONG)
def test_damaged_pictures_are_refused_in_one_line(tmp_path: Path, kind: str) -> None:
    (tmp_path / "x.hdr").write_bytes(WRONG[kind])
    with pytest.raises(UsageError, match=r"x\.hdr is no readable PNG, JPEG, HDR or OpenEXR") as one:
        read_image(tmp_path / "x.hdr")
    assert "\n" not in str(one.value)


def test_a_large_picture_is_refused_before_it_is_unpacked(tmp_path: Path) -> None:
    Picture.fromarray(levels(10, 10)).save(tmp_path / "a.png")
    with pytest.raises(UsageError, match="has 10x10 pixels; at most 99 are read"):
        read_image(tmp_path / "a.png", 99)
    with pytest.raises(UsageError, match="has 99999x99999 pixels"):
        read_image(HEAD + b"-Y 99999 +X 99999\n")
    with pytest.raises(UsageError, match=r"none\.png cannot be read: No such file"):
        read_image(tmp_path / "none.png")

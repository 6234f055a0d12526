"""Pixels and previews: nothing is lost where nothing may be, and pages stay small."""

from __future__ import annotations

import base64
import io
import json
import zlib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

from oitbench.report import pixels, previews


def unpacked(packed: dict[str, Any]) -> np.ndarray:
    """Return the numbers of a picture, decoded as the module describes it."""
    width, height, bits = (int(str(packed[key])) for key in ("width", "height", "bits"))
    octets = zlib.decompress(base64.b64decode(str(packed["data"])))
    planes = np.frombuffer(octets, np.uint8).reshape(-1, bits // 8, height, width)
    planes = np.cumsum(planes, axis=-1, dtype=np.uint8)
    numbers = np.zeros((planes.shape[0], height, width), int)
    for place in range(bits // 8):
        numbers = 256 * numbers + planes[:, place]
    return np.moveaxis(numbers, 0, 2)


@pytest.mark.parametrize("kind", [np.uint8, np.uint16])
@pytest.mark.parametrize("shape", [(3, 5), (3, 5, 3), (1, 1, 3)])
def test_packed_numbers_are_kept(kind: Any, shape: tuple[int, ...]) -> None:
    codes = np.random.default_rng(1).integers(0, np.iinfo(kind).max, shape, kind, endpoint=True)
    found = unpacked(pixels.pack(codes))
    assert (found.reshape(shape) == codes).all()


def test_radiance_keeps_what_is_not_finite_and_limits_what_is() -> None:
    values = np.array([[[1e9, -1e9, np.inf], [np.nan, 0.1, -np.inf]]], np.float32)
    found = pixels.radiance_codes(values).view(np.float16)
    assert found[0, 0].tolist() == [65504, -65504, np.inf]
    assert np.isnan(found[0, 1, 0])
    assert found[0, 1, 1:].tolist() == [np.float16(0.1), -np.inf]


def test_small_errors_stay_distinct() -> None:
    codes = pixels.error_codes(np.array([[0.0, 0.0001, 0.0058, 0.006, 1.0]], np.float32))
    assert len(set(codes[0].tolist())) == 5
    assert (codes[0, -1] / 255) ** 2 == 1


def test_no_name_ends_a_script(tmp_path: Path) -> None:
    path = tmp_path / "new" / "x.js"
    pixels.write(path, "</script><b>", {"0": np.zeros((1, 1, 3), np.uint8)})
    text = path.read_text(encoding="utf-8")
    assert "<" not in text
    name, _, rest = text.removeprefix(f"{pixels.FUNCTION}(").partition(", ")
    assert json.loads(name) == "</script><b>"
    assert json.loads(rest.removesuffix(");\n"))["0"]["bits"] == 8


def test_previews_are_as_large_as_their_room() -> None:
    noise = np.random.default_rng(2).random((300, 600, 3), dtype=np.float32)
    wide = previews.preview(noise, 10**9)
    small = previews.preview(noise, 4000)
    assert len(small) <= 4000 < len(wide)
    sizes = []
    for address in (wide, small):
        content = base64.b64decode(address.removeprefix("data:image/webp;base64,"))
        with Image.open(io.BytesIO(content)) as picture:
            sizes.append(picture.size)
    assert sizes[0] == (256, 128)
    assert sizes[1][0] < 256


def test_previews_of_the_largest_matrix_fit_into_the_page() -> None:
    count = 2 * 25 * (3 + 24)
    noise = np.random.default_rng(3).random((64, 64, 3), dtype=np.float32)
    assert (
        count * len(previews.preview(np.kron(noise, np.ones((8, 8, 1))), previews.room(count)))
        <= previews.CHARACTERS
        < 25e6
    )

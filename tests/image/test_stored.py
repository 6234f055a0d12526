"""Images that are named by their content."""

from __future__ import annotations

from pathlib import Path

import msgspec
import numpy as np
import pytest

from oitbench.errors import StorageError, UsageError
from oitbench.image import files, stored
from oitbench.image.stored import StoredImage
from tests.damage import cut, flip_bit, largest_file
from tests.image.helpers import constant


def keep(folder: Path, picture: files.Image) -> StoredImage:
    return stored.store(folder, "images/color", files.image_channels(picture))


def test_equal_pictures_share_a_file_and_others_have_their_own(
    tmp_path: Path, picture: files.Image
) -> None:
    first, same = keep(tmp_path, picture), keep(tmp_path, picture.copy())
    other = keep(tmp_path, np.nextafter(picture, np.float32(2)))
    assert first == same != other
    assert {path.name for path in (tmp_path / "images").iterdir()} == {
        Path(image.path).name for image in (first, other)
    }
    np.testing.assert_array_equal(files.read_exr(stored.verify(tmp_path, first)), picture)
    assert first.path == f"images/color-{first.sha256[:16]}.exr"
    assert first.bytes == (tmp_path / first.path).stat().st_size
    decoded = msgspec.json.decode(msgspec.json.encode(first), type=StoredImage)
    assert decoded == first


def test_damaged_and_missing_images_are_named(tmp_path: Path, picture: files.Image) -> None:
    image = keep(tmp_path, picture)
    path = tmp_path / image.path
    whole = path.read_bytes()
    for number in range(0, 8 * len(whole), 8 * len(whole) // 100):
        flip_bit(path, number)
        with pytest.raises(UsageError, match=rf"{image.path} is damaged"):
            stored.verify(tmp_path, image)
        path.write_bytes(whole)
    cut(path, 1)
    with pytest.raises(UsageError, match="is damaged"):
        stored.verify(tmp_path, image)
    path.unlink()
    with pytest.raises(UsageError, match=r"cannot be read \(No such file"):
        stored.verify(tmp_path, image)
    path.mkdir()
    with pytest.raises(UsageError, match=r"is damaged|cannot be read"):
        stored.verify(tmp_path, image)


@pytest.mark.parametrize("side", [8, 64])
def test_a_full_disk_leaves_no_part(side: int, tmp_path: Path) -> None:
    image = keep(tmp_path, constant((0.1, 0.2, 0.3)))
    noise = np.random.default_rng(1).random((side, side, 3), dtype=np.float32)
    files.write_exr(tmp_path / "noise.exr", noise)
    size = (tmp_path / "noise.exr").stat().st_size
    # OpenEXR does not notice that the last part of a file is lost.
    for limit in (0, 10, size // 2, size - 1):
        with largest_file(limit), pytest.raises(StorageError, match="free some space"):
            keep(tmp_path, noise)
    assert [path.name for path in (tmp_path / "images").iterdir()] == [Path(image.path).name]

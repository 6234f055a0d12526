"""Image files that are named by their content, so that no file ever stands for another."""

from __future__ import annotations

import hashlib
from pathlib import Path
from typing import Annotated

from msgspec import Meta, Struct

from oitbench.atomic import partial_file
from oitbench.errors import UsageError
from oitbench.image.files import Channels, write_channels

_NAMED = 16
"""Digits of the digest in a file's name."""
_NAME = r"(?!\.)[A-Za-z0-9%_.=,+@~-]+"

PlainPath = Annotated[str, Meta(pattern=rf"^({_NAME}/)?{_NAME}$(?!\n)")]
"""A relative path of plain names, at most one folder deep, so that it cannot leave its folder."""
Sha256 = Annotated[str, Meta(pattern=r"^[0-9a-f]{64}$(?!\n)")]


class StoredImage(Struct, frozen=True, forbid_unknown_fields=True):
    """An image file: its path below the folder of its owner, its SHA-256 digest and its size."""

    path: PlainPath
    sha256: Sha256
    bytes: Annotated[int, Meta(ge=1)]


def store(folder: Path, stem: str, channels: Channels) -> StoredImage:
    """Write an image file `STEM-DIGEST.exr`, and return what identifies it.

    Parameters
    ----------
    folder : Path
        The folder of the owner.
    stem : str
        Path below `folder` without suffix, as in `images/color`.
    channels : mapping of str to array
        From `files.image_channels` or `files.flip_channels`.

    Raises
    ------
    StorageError
        If the file cannot be written.
    """
    with partial_file(folder / f"{stem}.exr") as partial:
        write_channels(partial, channels)
        digest, size = _digest(partial), partial.stat().st_size
        stored = StoredImage(f"{stem}-{digest[:_NAMED]}.exr", digest, size)
        partial.replace(folder / stored.path)
    return stored


def verify(folder: Path, image: StoredImage) -> Path:
    """Return the file of an image if its content is the one that was stored.

    Raises
    ------
    UsageError
        If the file is missing or damaged. The message only names the file and the fault.
    """
    path = folder / image.path
    try:
        intact = path.stat().st_size == image.bytes and _digest(path) == image.sha256
    except OSError as error:
        raise UsageError(f"{path} cannot be read ({error.strerror})") from error
    if not intact:
        raise UsageError(f"{path} is damaged")
    return path


def _digest(path: Path) -> str:
    digest = hashlib.sha256()
    with path.open("rb") as file:
        while block := file.read(1 << 20):
            digest.update(block)
    return digest.hexdigest()

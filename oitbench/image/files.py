"""Image files, the display encoding and the box filter.

An image is an array of shape (h, w, 3), float32: linear Rec.709 radiance, top row first.
"""

from __future__ import annotations

import errno
import os
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from oitbench.atomic import FULL_DISK, replacing
from oitbench.errors import UsageError, printable

Image = npt.NDArray[np.float32]

Channels = Mapping[str, npt.NDArray[Any]]
"""Pixels of an OpenEXR file by channel; R, G and B are one entry."""

_LARGEST_HALF = float(np.finfo(np.float16).max)
_NONFINITE_COLOR = (1.0, 0.0, 1.0)
_MAP_CHANNELS, _COUNT_CHANNEL = ("ldr", "hdr"), "fragments"
_ZIP_ROWS = 16
"""Rows of each block of a ZIP-compressed OpenEXR file."""
_PROBE = 1 << 16
"""Bytes that a full disk does not take any more."""


def check(image: npt.ArrayLike, owner: str = "image") -> Image:
    """Return `image` as float32 if it has the shape and the type of an image.

    Parameters
    ----------
    image : array
        Must be (h, w, 3) of a floating-point type. Integers, RGBA and gray are refused, because a
        metric would silently take them for something else.
    owner : str
        Name of the image in error messages.

    Raises
    ------
    TypeError
        If the type is not floating point.
    ValueError
        If the shape is different, or the image is empty.
    """
    array = np.asarray(image)
    if array.dtype.kind != "f":
        raise TypeError(f"{owner} is {array.dtype}; linear images are float32")
    if array.ndim != 3 or array.shape[2] != 3 or array.size == 0:
        raise ValueError(f"{owner} has shape {array.shape}; images are (height, width, 3)")
    return array.astype(np.float32, copy=False)


def fits_half(values: npt.ArrayLike) -> bool:
    """Return whether half floats can represent all finite values without overflow."""
    array = np.asarray(values)
    finite = np.abs(array[np.isfinite(array)])
    return not finite.size or bool(finite.max() <= _LARGEST_HALF)


def read_exr(path: Path | str) -> Image:
    """Read the RGB channels of an OpenEXR file.

    Returns
    -------
    array, shape (h, w, 3), float32
        Linear values as stored. Half floats are widened, and an alpha channel is dropped.

    Raises
    ------
    UsageError
        If the file is missing, damaged, or has no RGB channels.
    """
    channels = read_channels(Path(path))
    pixels = channels.get("RGB", channels.get("RGBA"))
    if pixels is None:
        raise UsageError(
            f"{path} has the channels {', '.join(channels)}, but RGB is needed; render it again"
        )
    return np.ascontiguousarray(pixels[..., :3], dtype=np.float32)


def write_exr(path: Path | str, image: npt.ArrayLike, *, half: bool = False) -> None:
    """Write an image to a ZIP-compressed OpenEXR file; an existing file is replaced atomically.

    Parameters
    ----------
    path : path
        Missing folders are created.
    image : array, shape (h, w, 3)
        Linear values; NaN and infinity are kept.
    half : bool
        Store 16 instead of 32 bits for each channel.

    Raises
    ------
    StorageError
        If the file cannot be written.
    ValueError
        If a finite value does not fit a half float and `half` is set.
    """
    channels = image_channels(image, half=half)
    with replacing(Path(path)) as partial:
        write_channels(partial, channels)


def image_channels(image: npt.ArrayLike, *, half: bool = False) -> Channels:
    """Return the channels of a file that holds `image`; see `write_exr`."""
    pixels = check(image)
    if half and not fits_half(pixels):
        largest = np.abs(pixels[np.isfinite(pixels)]).max()
        raise ValueError(f"{largest:g} does not fit a half float; write float32")
    return {"RGB": pixels.astype(np.float16) if half else pixels}


def read_flip_maps(path: Path | str) -> tuple[Image, Image]:
    """Read two FLIP maps.

    Returns
    -------
    ldr, hdr : array, shape (h, w), float32
        FLIP errors of the displayed image and of HDR-FLIP, in [0, 1].

    Raises
    ------
    UsageError
        If the file is missing, damaged, or lacks a map.
    """
    channels = read_channels(Path(path))
    missing = [name for name in _MAP_CHANNELS if name not in channels]
    if missing:
        raise UsageError(
            f"{path} has no channel {' and '.join(missing)}, so it holds no FLIP maps; "
            "render it again"
        )
    ldr, hdr = (np.ascontiguousarray(channels[name], np.float32) for name in _MAP_CHANNELS)
    return ldr, hdr


def flip_channels(ldr: npt.ArrayLike, hdr: npt.ArrayLike) -> Channels:
    """Return the half-float channels `ldr` and `hdr` of a file that holds two FLIP maps.

    Parameters
    ----------
    ldr, hdr : array, shape (h, w)
        FLIP errors of the displayed image and of HDR-FLIP, in [0, 1].

    Raises
    ------
    ValueError
        If the maps are not two arrays of one size.
    """
    maps = [np.asarray(errors) for errors in (ldr, hdr)]
    if maps[0].ndim != 2 or maps[0].shape != maps[1].shape or not maps[0].size:
        raise ValueError(f"FLIP maps are {maps[0].shape} and {maps[1].shape}; both must be (h, w)")
    return {name: item.astype(np.float16) for name, item in zip(_MAP_CHANNELS, maps, strict=True)}


def read_counts(path: Path | str) -> npt.NDArray[np.uint32]:
    """Read the counts that `count_channels` describes, shape (h, w).

    Raises
    ------
    UsageError
        If the file is missing, damaged, or holds no counts.
    """
    pixels = read_channels(Path(path)).get(_COUNT_CHANNEL)
    if pixels is None or pixels.dtype != np.uint32:
        raise UsageError(f"{path} has no channel {_COUNT_CHANNEL} of integers; render it again")
    return np.ascontiguousarray(pixels)


def count_channels(counts: npt.ArrayLike) -> Channels:
    """Return the channel `fragments` of a file that holds a count for each pixel, (h, w)."""
    return {_COUNT_CHANNEL: np.asarray(counts).astype(np.uint32)}


def read_channels(path: Path) -> Channels:
    """Return all channels of an OpenEXR file."""
    import OpenEXR

    if not path.is_file():
        raise UsageError(f"{path}: there is no such image; render it again")
    try:
        with utf8_name(path, os.O_RDONLY) as name, OpenEXR.File(name) as file:
            return {name: channel.pixels for name, channel in file.channels().items()}
    except (RuntimeError, ValueError) as error:
        raise UsageError(f"{path} is not a readable OpenEXR image; render it again") from error


def write_channels(path: Path, channels: Channels) -> None:
    """Write a ZIP-compressed OpenEXR file; a failure may leave a part of it.

    Raises
    ------
    OSError
        If the file cannot be written.
    """
    import OpenEXR

    # The binding modifies the header, and silently misreads arrays that are not C-contiguous.
    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
    file = OpenEXR.File(header, {k: np.ascontiguousarray(v) for k, v in channels.items()})
    try:
        with utf8_name(path, os.O_RDWR | os.O_CREAT) as name:
            file.write(name)
    except RuntimeError as error:
        # OpenEXR knows the reason only as text.
        known = (code for code in FULL_DISK if os.strerror(code) in str(error))
        code = next(known, None)
        reason = (errno.EIO, str(error)) if code is None else (code, os.strerror(code))
        raise OSError(*reason) from error
    if not _is_whole(path.read_bytes(), next(iter(channels.values())).shape[0]):
        with path.open("ab") as file:  # The system names the reason when it refuses more.
            file.write(bytes(_PROBE))
            file.flush()
            os.fsync(file.fileno())
        raise OSError(errno.EIO, os.strerror(errno.EIO))


def _is_whole(content: bytes, rows: int) -> bool:
    """Return whether a ZIP-compressed OpenEXR file has all its blocks of rows.

    OpenEXR does not notice that its last write fails, which for small files is the only one. The
    layout is that of "OpenEXR File Layout": after the header comes a table with the place of each
    block, and each block begins with its first row and its size.
    """
    try:
        place = 8
        while content[place]:
            for _ in ("name", "type"):
                place = content.index(b"\0", place) + 1
            place += 4 + int.from_bytes(content[place : place + 4], "little")
        table = np.frombuffer(content, "<u8", -(-rows // _ZIP_ROWS), place + 1)
        ends = [int(at) + 8 + int.from_bytes(content[at + 4 : at + 8], "little") for at in table]
    except (IndexError, ValueError):
        return False
    return bool(table.all()) and max(ends) == len(content)


@contextmanager
def utf8_name(path: Path, flags: int) -> Iterator[str]:
    """Yield a name by which OpenEXR finds a file; it only takes names that are UTF-8."""
    if printable(str(path)) == str(path):
        yield str(path)
        return
    descriptor = os.open(path, flags, 0o666)
    try:
        yield f"/proc/self/fd/{descriptor}"
    finally:
        os.close(descriptor)


def to_srgb(linear: npt.ArrayLike, exposure: float) -> Image:
    """Return `linear` as it is displayed: times 2^exposure, clipped, sRGB-encoded.

    Parameters
    ----------
    linear : array
        Linear Rec.709 values.
    exposure : float
        Stops.

    Returns
    -------
    array of the same shape, float32 in [0, 1]
        NaN stays NaN, and infinities are clipped.

    References
    ----------
    IEC 61966-2-1.
    """
    with np.errstate(over="ignore", invalid="ignore"):
        values = np.asarray(linear)
        # Images are in single precision, which is fast and far finer than a display.
        single = values.dtype == np.float32
        scaled = values * (np.float32 if single else np.float64)(2.0**exposure)
        clipped = np.clip(scaled, 0.0, 1.0)
        toe = 12.92 * clipped
        curve = 1.055 * clipped ** (1 / 2.4) - 0.055
    encoded: Image = np.where(clipped <= 0.0031308, toe, curve).astype(np.float32)
    return encoded


def mark_nonfinite(srgb: npt.ArrayLike) -> Image:
    """Return a copy of `srgb` in which pixels that are not finite are magenta."""
    pixels = np.array(check(srgb), copy=True)
    bad = ~np.isfinite(pixels)
    if bad.any():
        pixels[bad.any(axis=-1)] = _NONFINITE_COLOR
    return pixels


def write_png(path: Path | str, srgb: npt.ArrayLike, text: str = "") -> None:
    """Write display values in [0, 1] as an 8-bit PNG; pixels that are not finite are magenta.

    Parameters
    ----------
    path : path
        Missing folders are created.
    srgb : array, shape (h, w, 3)
    text : str
        Description that is stored in the file.

    Raises
    ------
    UsageError
        If the file cannot be written.
    """
    from PIL import Image as Picture
    from PIL.PngImagePlugin import PngInfo

    levels = np.rint(np.clip(mark_nonfinite(srgb), 0, 1) * 255).astype(np.uint8)
    path, facts = Path(path), PngInfo()
    if text:
        facts.add_itxt("Description", text)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        Picture.fromarray(levels).save(path, pnginfo=facts)
    except OSError as error:
        raise UsageError(f"{path} cannot be written; choose another folder") from error


def box_downsample(image: npt.ArrayLike, factor: int) -> Image:
    """Average `image` over blocks of factor × factor pixels: a box filter.

    Parameters
    ----------
    image : array, shape (factor · h, factor · w, 3)
        Linear values.
    factor : int
        Side of a block in pixels, at least 1.

    Returns
    -------
    array, shape (h, w, 3), float32

    Raises
    ------
    ValueError
        If a side is not a multiple of `factor`.
    """
    pixels = check(image)
    height, width, channels = pixels.shape
    if factor < 1 or height % factor or width % factor:
        raise ValueError(f"{width}x{height} pixels cannot be averaged over blocks of {factor}")
    blocks = pixels.reshape(height // factor, factor, width // factor, factor, channels)
    with np.errstate(over="ignore", invalid="ignore"):
        averaged: Image = blocks.mean(axis=(1, 3), dtype=np.float64).astype(np.float32)
    return averaged

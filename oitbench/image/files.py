"""Images are [h, w, 3] float32, linear Rec.709 radiance, top row first; files, encoding, size."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import numpy.typing as npt

from oitbench.errors import UsageError

Image = npt.NDArray[np.float32]

_LARGEST_HALF = float(np.finfo(np.float16).max)
_NONFINITE_COLOR = (1.0, 0.0, 1.0)


def check(image: npt.ArrayLike, owner: str = "image") -> Image:
    """Return `image` as it is if it is an image of this suite, else raise.

    Parameters
    ----------
    image : array
        Must be [h, w, 3] of a floating-point type; integers, RGBA and grey are refused, because
        they would be scored in silence as something they are not.
    owner : str
        What the message calls the image.

    Raises
    ------
    TypeError
        For a type that is not floating point.
    ValueError
        For any other shape, or an empty image.
    """
    array = np.asarray(image)
    if array.dtype.kind != "f":
        raise TypeError(f"{owner} is {array.dtype}; linear images are float32")
    if array.ndim != 3 or array.shape[2] != 3 or array.size == 0:
        raise ValueError(f"{owner} has shape {array.shape}; images are (height, width, 3)")
    return array.astype(np.float32, copy=False)


def read_exr(path: Path | str) -> Image:
    """Read the RGB channels of an OpenEXR file.

    Returns
    -------
    array, shape (h, w, 3), float32
        Linear values as stored; half floats are widened and an alpha channel is left out.

    Raises
    ------
    UsageError
        If the file is missing, damaged, or has no RGB channels.
    """
    import OpenEXR

    path = Path(path)
    if not path.is_file():
        raise UsageError(f"{path}: there is no such image")
    try:
        with OpenEXR.File(str(path)) as file:
            channels = {name: channel.pixels for name, channel in file.channels().items()}
    except (RuntimeError, ValueError) as error:
        raise UsageError(f"{path} is not a readable OpenEXR image; render it again") from error
    pixels = channels.get("RGB", channels.get("RGBA"))
    if pixels is None:
        raise UsageError(f"{path} has channels {', '.join(channels)}; RGB is needed")
    return np.ascontiguousarray(pixels[..., :3], dtype=np.float32)


def write_exr(path: Path | str, image: npt.ArrayLike, *, half: bool = False) -> None:
    """Write `image` to a ZIP-compressed OpenEXR file; a file of that name is replaced at once.

    Parameters
    ----------
    path : path
        Folders on the way are made.
    image : array, shape (h, w, 3)
        Linear values; NaN and infinity are kept.
    half : bool
        Store 16 instead of 32 bits per channel.

    Raises
    ------
    UsageError
        If the place cannot be written to.
    ValueError
        If `half` cannot hold a finite value.
    """
    import OpenEXR

    pixels = check(image)
    if half:
        finite = np.abs(pixels[np.isfinite(pixels)])
        if finite.size and finite.max() > _LARGEST_HALF:
            raise ValueError(f"{path}: {finite.max():g} does not fit a half float; write float32")
        stored: npt.NDArray[np.float16] | Image = pixels.astype(np.float16)
    else:
        stored = pixels
    # The binding mutates the header, and silently misreads arrays that are not C-contiguous.
    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
    file = OpenEXR.File(header, {"RGB": np.ascontiguousarray(stored)})
    path = Path(path)
    partial = path.with_name(f".{path.stem}.{os.getpid()}.partial.exr")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        file.write(str(partial))
        os.replace(partial, path)
    except (OSError, RuntimeError) as error:
        raise UsageError(f"{path} cannot be written; choose another folder") from error


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
        NaN stays NaN; infinities are clipped.

    Notes
    -----
    The transfer function is that of IEC 61966-2-1.
    """
    with np.errstate(over="ignore", invalid="ignore"):
        scaled = np.asarray(linear, dtype=np.float64) * 2.0**exposure
        clipped = np.clip(scaled, 0.0, 1.0)
        toe = 12.92 * clipped
        curve = 1.055 * clipped ** (1 / 2.4) - 0.055
    encoded: Image = np.where(clipped <= 0.0031308, toe, curve).astype(np.float32)
    return encoded


def mark_nonfinite(srgb: npt.ArrayLike) -> Image:
    """Return a copy of `srgb` whose pixels that are not finite are magenta."""
    pixels = np.array(check(srgb), copy=True)
    pixels[~np.isfinite(pixels).all(axis=-1)] = _NONFINITE_COLOR
    return pixels


def write_png(path: Path | str, srgb: npt.ArrayLike) -> None:
    """Write display values in [0, 1] as an 8-bit PNG; pixels that are not finite become magenta.

    Raises
    ------
    UsageError
        If the place cannot be written to.
    """
    from PIL import Image as Picture

    levels = np.rint(np.clip(mark_nonfinite(srgb), 0, 1) * 255).astype(np.uint8)
    path = Path(path)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        Picture.fromarray(levels).save(path)
    except OSError as error:
        raise UsageError(f"{path} cannot be written; choose another folder") from error


def box_downsample(image: npt.ArrayLike, factor: int) -> Image:
    """Average `image` over blocks of factor × factor pixels, as a box filter does.

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
        If a side is no multiple of `factor`.
    """
    pixels = check(image)
    height, width, channels = pixels.shape
    if factor < 1 or height % factor or width % factor:
        raise ValueError(f"{width}x{height} pixels cannot be averaged over blocks of {factor}")
    blocks = pixels.reshape(height // factor, factor, width // factor, factor, channels)
    with np.errstate(over="ignore", invalid="ignore"):
        averaged: Image = blocks.mean(axis=(1, 3), dtype=np.float64).astype(np.float32)
    return averaged

"""Storing references: a folder with one manifest, and two images for each entry.

The mean is stored as half floats, the variance of that mean as float32: it would underflow in
halves.
"""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from oitbench.errors import UsageError
from oitbench.image import files as images
from oitbench.image.files import Image

MANIFEST = "manifest.json"

_VERSION = 1
_LARGEST_HALF = float(np.finfo(np.float16).max)


@dataclass(frozen=True, eq=False)
class Reference:
    """A path-traced image with all that it is known by.

    Parameters
    ----------
    scene : str
        Label, as `bottles[coverage=0.5]`.
    size : (int, int)
        Width and height in pixels.
    ssaa : int
        Side of the sub-pixel grid.
    spp : int
        Samples that were taken for each sub-pixel.
    seed : int
    mitsuba : str
        Version.
    fingerprint : str
        Of the scene that was rendered.
    noise_floor : mapping
        `flip_ldr@67ppd` and `rmse_lin` between the two halves.
    mean, variance : array, shape (h, w, 3), float32
        Linear radiance, and the variance of that mean.
    stale : bool
        Whether the scene has changed since; then the image must not be used as a truth.
    message : str
        One line for the user; empty if there is nothing to say.
    """

    scene: str
    size: tuple[int, int]
    ssaa: int
    spp: int
    seed: int
    mitsuba: str
    fingerprint: str
    noise_floor: Mapping[str, float | None]
    mean: Image
    variance: Image
    stale: bool = False
    message: str = ""

    @property
    def key(self) -> str:
        """The name of its entry and the beginning of its files' names."""
        return entry_key(self.scene, self.size)

    def facts(self) -> dict[str, Any]:
        """Return what the manifest holds of it."""
        names = ("scene", "size", "ssaa", "spp", "seed", "mitsuba", "fingerprint", "noise_floor")
        return {name: getattr(self, name) for name in names}


def entry_key(label: str, size: tuple[int, int]) -> str:
    """Return the name of an entry: `<label>@<w>x<h>`."""
    return f"{label}@{size[0]}x{size[1]}"


def read_manifest(folder: Path) -> dict[str, dict[str, Any]]:
    """Return the entries of a folder's manifest by name; empty if there is none.

    Raises
    ------
    UsageError
        If the manifest is damaged or of another version.
    """
    path = folder / MANIFEST
    try:
        manifest = json.loads(path.read_text(encoding="utf-8"))
        version, entries = manifest["version"], dict(manifest["references"])
    except (FileNotFoundError, NotADirectoryError):
        return {}
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise UsageError(
            f"{path} is damaged; restore it, or delete it and render its references again"
        ) from error
    if version != _VERSION:
        raise UsageError(f"{path} is of version {version}, not {_VERSION}; render it again")
    return entries


def save(folder: Path, reference: Reference) -> None:
    """Write a reference into `folder`, images first, so that the manifest never names less.

    Raises
    ------
    UsageError
        If the folder cannot be written to or its manifest is damaged.
    """
    entries = read_manifest(folder)
    half = bool(reference.mean.max() <= _LARGEST_HALF)
    images.write_exr(folder / f"{reference.key}.mean.exr", reference.mean, half=half)
    images.write_exr(folder / f"{reference.key}.variance.exr", reference.variance)
    entries[reference.key] = reference.facts()
    manifest = {"version": _VERSION, "references": dict(sorted(entries.items()))}
    text = json.dumps(manifest, indent=1, ensure_ascii=False, allow_nan=False) + "\n"
    partial = folder / f".{MANIFEST}.{os.getpid()}.partial"
    try:
        partial.write_text(text, encoding="utf-8")
        os.replace(partial, folder / MANIFEST)
    except OSError as error:
        raise UsageError(f"{folder} cannot be written to; choose another folder") from error


def read(folder: Path, label: str, size: tuple[int, int]) -> Reference | None:
    """Return a reference as it is stored in `folder`, or None; it may be stale.

    Raises
    ------
    UsageError
        If the manifest or an image is damaged or missing.
    """
    key = entry_key(label, size)
    entry = read_manifest(folder).get(key)
    if entry is None:
        return None
    mean = images.read_exr(folder / f"{key}.mean.exr")
    variance = images.read_exr(folder / f"{key}.variance.exr")
    shape = (size[1], size[0], 3)
    if mean.shape != shape or variance.shape != shape:
        raise UsageError(f"{folder}/{key}: its images are not {size[0]}x{size[1]}; render it again")
    try:
        facts: dict[str, Any] = {
            **{name: int(entry[name]) for name in ("ssaa", "spp", "seed")},
            **{name: str(entry[name]) for name in ("mitsuba", "fingerprint")},
            "noise_floor": dict(entry["noise_floor"]),
        }
    except (KeyError, TypeError, ValueError) as error:
        raise UsageError(f"{folder / MANIFEST}: {key} is damaged; render it again") from error
    return Reference(scene=label, size=size, mean=mean, variance=variance, **facts)

"""Where references are stored: a folder with one manifest, and two images for each entry.

The mean is stored in half floats, and its variance in float32, because the variance would underflow
in half floats.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from oitbench import json_text
from oitbench.atomic import replacing
from oitbench.errors import UsageError
from oitbench.image import files as images
from oitbench.image.files import Image

FOLDER = "reference"
"""The folder of a collection that holds its references."""
MANIFEST = "manifest.json"

_VERSION = 1


def reference_key(label: str, size: tuple[int, int]) -> str:
    """Return the name of a reference: `<label>@<w>x<h>`."""
    return f"{label}@{size[0]}x{size[1]}"


@dataclass(frozen=True)
class ReferenceInfo:
    """How a reference was rendered: its entry in the manifest.

    Parameters
    ----------
    scene : str
        Label, as in `bottles[coverage=0.5]`.
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
        Fingerprint of the scene that was rendered.
    noise_floor : dict of str to float or None
        `flip_ldr@67ppd` and `rmse_lin` between the two halves of the samples.
    """

    scene: str
    size: tuple[int, int]
    ssaa: int
    spp: int
    seed: int
    mitsuba: str
    fingerprint: str
    noise_floor: dict[str, float | None]

    @classmethod
    def parse(cls, entry: Mapping[str, Any]) -> ReferenceInfo:
        """Return the info of a manifest's entry.

        Raises
        ------
        KeyError, TypeError, ValueError
            If a field is missing or of another type.
        """
        width, height = entry["size"]
        floors = dict(entry["noise_floor"])
        return cls(
            scene=str(entry["scene"]),
            size=(int(width), int(height)),
            ssaa=int(entry["ssaa"]),
            spp=int(entry["spp"]),
            seed=int(entry["seed"]),
            mitsuba=str(entry["mitsuba"]),
            fingerprint=str(entry["fingerprint"]),
            noise_floor={
                str(name): None if value is None else float(value) for name, value in floors.items()
            },
        )

    @property
    def key(self) -> str:
        """The name of the entry, with which the names of its files begin."""
        return reference_key(self.scene, self.size)


@dataclass(frozen=True, eq=False)
class Reference:
    """A path-traced image with its variance.

    Parameters
    ----------
    info : ReferenceInfo
    mean, variance : array, shape (h, w, 3), float32
        Linear radiance, and the variance of that mean.
    stale : bool
        Whether the scene has changed since. A stale image must not be used as a reference.
    message : str
        One line for the user; empty if there is nothing to report.
    """

    info: ReferenceInfo
    mean: Image
    variance: Image
    stale: bool = False
    message: str = ""


def read_manifest(folder: Path) -> dict[str, ReferenceInfo]:
    """Return the entries of a folder's manifest by name; empty if there is no manifest.

    Raises
    ------
    UsageError
        If the manifest is damaged or of another version.
    """
    path = folder / MANIFEST
    try:
        manifest = json_text.loads(path.read_bytes())
        version, entries = manifest["version"], dict(manifest["references"])
    except (FileNotFoundError, NotADirectoryError):
        return {}
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise UsageError(
            f"{path} is damaged; restore it, or delete it and render its references again"
        ) from error
    if version != _VERSION:
        raise UsageError(
            f"{path} is of version {version}, not {_VERSION}; delete it and render its references "
            "again"
        )
    return {key: _parse(path, key, entry) for key, entry in entries.items()}


def _parse(path: Path, key: str, entry: Any) -> ReferenceInfo:
    try:
        info = ReferenceInfo.parse(entry)
    except (KeyError, TypeError, ValueError) as error:
        raise _damaged(path, key) from error
    if info.key != key:
        raise _damaged(path, key)
    return info


def _damaged(path: Path, key: str) -> UsageError:
    return UsageError(f"{path}: entry {key} is damaged; delete the entry and render it again")


def stored_precision(mean: Image) -> Image:
    """Return a mean rounded as `save` stores it: half floats if they can hold it."""
    return mean.astype(np.float16).astype(np.float32) if images.fits_half(mean) else mean


def save(folder: Path, reference: Reference) -> None:
    """Write a reference into `folder`.

    The images are written first, so that the manifest never names a missing one.

    Raises
    ------
    UsageError
        If the folder cannot be written to, or its manifest is damaged.
    """
    entries = read_manifest(folder)
    key, mean = reference.info.key, reference.mean
    images.write_exr(folder / f"{key}.mean.exr", mean, half=images.fits_half(mean))
    images.write_exr(folder / f"{key}.variance.exr", reference.variance)
    entries[key] = reference.info
    facts = {name: asdict(info) for name, info in sorted(entries.items())}
    manifest = {"version": _VERSION, "references": facts}
    text = json.dumps(manifest, indent=1, ensure_ascii=False, allow_nan=False) + "\n"
    with replacing(folder / MANIFEST) as partial:
        partial.write_text(text, encoding="utf-8")


def read(folder: Path, label: str, size: tuple[int, int]) -> Reference | None:
    """Return the reference of `folder` for a scene and a size, or None if there is none.

    Whether it still fits the scene is not checked.

    Raises
    ------
    UsageError
        If the manifest is damaged, or an image is damaged or missing.
    """
    key = reference_key(label, size)
    info = read_manifest(folder).get(key)
    if info is None:
        return None
    mean = images.read_exr(folder / f"{key}.mean.exr")
    variance = images.read_exr(folder / f"{key}.variance.exr")
    shape = (size[1], size[0], 3)
    if mean.shape != shape or variance.shape != shape:
        raise UsageError(f"{folder}/{key}: its images are not {size[0]}x{size[1]}; render it again")
    return Reference(info, mean, variance)

"""Where references are stored: a folder with one manifest, and the images of each entry.

A full reference is a mean with its variance. A matched one is a single picture if it is free of
noise, else all of its independent parts. Pictures are stored in half floats if these can hold them,
and the variance in float32, because it would underflow in half floats. Images are named by their
content. So a reference changes at the moment in which the manifest is replaced, and a reader finds
the old one or the new one.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal

import msgspec
import numpy as np
from msgspec import Struct

from oitbench import json_text
from oitbench.atomic import locked, remove_partial_files, replacing, writing
from oitbench.errors import SceneError, UsageError
from oitbench.filenames import file_name
from oitbench.image import files, stored
from oitbench.image.files import Image
from oitbench.image.stored import StoredImage
from oitbench.views import MAIN, seen, selection

FOLDER = "reference"
"""The folder of a collection that holds its references."""
MANIFEST = "manifest.json"

_VERSION = 3
_LOCK = ".lock"


def reference_key(
    label: str,
    size: tuple[int, int],
    truth: str,
    left_out: Iterable[str] = (),
    view: str = MAIN,
) -> str:
    """Return the name of a reference, as in `tumblers@above@256x256.matched-refraction`.

    Parameters
    ----------
    label : str
        The canonical label of the scene.
    size : (int, int)
        Width and height in pixels.
    truth : str
        MATCHED or FULL.
    left_out : iterable of str
        Names of effects that the scene requests and that do not run.
    view : str
        Not part of the name if it is the main one.
    """
    without = "".join(f"-{name.lower()}" for name in left_out)
    return f"{seen(label, view)}@{size[0]}x{size[1]}.{truth}{without}"


class Rendering(Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """How a reference was rendered; two equal renderings are one picture.

    Parameters
    ----------
    scene : str
        Label, as in `bottles[coverage=0.5]`.
    truth : str
        MATCHED or FULL.
    effects, left_out : list of str
        Effects that run, and those that the scene requests and that do not run.
    size : (int, int)
        Width and height in pixels.
    ssaa : int
        Side of the sub-pixel grid.
    spp : int
        Samples for each sub-pixel, of each part.
    parts : int
        Independent pictures; one if there is no noise, and for full path tracing.
    seed : int
    tracer : int
        Version of the path tracer, `path_traced.version.TRACER`.
    mitsuba : str
        Version of Mitsuba.
    fingerprint : str
        Fingerprint of the scene as seen from the view.
    view : str
        Name of the camera; not stored if it is the main one.
    jitter : bool
        Whether rays pass through their sub-pixels at random; stored if they do.
    """

    scene: str
    truth: Literal["matched", "full"]
    effects: list[str]
    left_out: list[str]
    size: tuple[int, int]
    ssaa: int
    spp: int
    parts: int
    seed: int
    tracer: int
    mitsuba: str
    fingerprint: str
    view: str = MAIN
    jitter: bool = False

    def __post_init__(self) -> None:
        if self.view == MAIN:
            # Defaults are left out where they are the same object, not where they are equal.
            msgspec.structs.force_setattr(self, "view", MAIN)

    @property
    def key(self) -> str:
        """The name of the reference in a manifest."""
        return reference_key(self.scene, self.size, self.truth, self.left_out, self.view)

    @property
    def digest(self) -> str:
        """A digest of everything but the label and the view's name: 32 hexadecimal digits."""
        content = msgspec.json.encode(msgspec.structs.replace(self, scene="", view=MAIN))
        return hashlib.sha256(content).hexdigest()[:32]


class ReferenceInfo(Struct, frozen=True, forbid_unknown_fields=True):
    """An entry of a manifest.

    Parameters
    ----------
    rendering : Rendering
    noise_floor : dict of str to float or None
        `flip_ldr@67ppd`, `flip_hdr@67ppd` and `rmse_lin` that the noise alone causes.
    seconds : float
        Wall-clock time of the rendering.
    parts : list of StoredImage
        Files beside the manifest: the mean, or all parts.
    variance : StoredImage, optional
        Of the mean of a full reference.
    """

    rendering: Rendering
    noise_floor: dict[str, float | None]
    seconds: float
    parts: list[StoredImage]
    variance: StoredImage | None = None

    @property
    def images(self) -> list[StoredImage]:
        """All files."""
        return self.parts if self.variance is None else [*self.parts, self.variance]


@dataclass(frozen=True, eq=False)
class Reference:
    """A traced picture, with what is known of its noise.

    Parameters
    ----------
    rendering : Rendering
    noise_floor : dict of str to float or None
        By metric, the error that the noise alone causes.
    seconds : float
        Wall-clock time of the rendering.
    parts : tuple of array, shape (h, w, 3), float32
        Linear radiance: independent pictures, whose mean is the truth.
    variance : array, shape (h, w, 3), float32, optional
        Variance of the mean, of a full reference.

    Raises
    ------
    SceneError
        If a part is not finite, the variance is not a finite number of at least zero, or an image
        has another size.
    """

    rendering: Rendering
    noise_floor: dict[str, float | None]
    seconds: float
    parts: tuple[Image, ...]
    variance: Image | None = None

    def __post_init__(self) -> None:
        owner = f"reference {self.rendering.key}"
        width, height = self.rendering.size
        if len(self.parts) != self.rendering.parts:
            raise SceneError(f"{owner}: it has {len(self.parts)} parts")
        images = [(_part_name(number, self.parts), p) for number, p in enumerate(self.parts)]
        if self.variance is not None:
            images.append(("variance", self.variance))
        for name, image in images:
            if image.shape != (height, width, 3):
                raise SceneError(f"{owner}: its {name} is not {width}x{height} pixels")
            if not np.isfinite(image).all():
                raise SceneError(f"{owner}: its {name} holds NaN or infinity")
        if self.variance is not None and (self.variance < 0).any():
            raise SceneError(f"{owner}: its variance is negative")

    @property
    def random(self) -> bool:
        """Whether the truth has noise."""
        return len(self.parts) > 1 or (self.variance is not None and bool(self.variance.any()))

    @property
    def mean(self) -> Image:
        """The truth: the mean of all parts."""
        if len(self.parts) == 1:
            return self.parts[0]
        total = np.stack(self.parts).sum(axis=0, dtype=np.float64)
        return np.asarray(total / len(self.parts), dtype=np.float32)


def _part_name(number: int, parts: Sequence[object]) -> str:
    return "mean" if len(parts) == 1 else f"part{number}"


def read_manifest(folder: Path) -> dict[str, ReferenceInfo]:
    """Return the entries of a folder's manifest by name, without damaged ones.

    Raises
    ------
    UsageError
        If the manifest as a whole is damaged or of another version.
    """
    parsed = {key: _parse(key, entry) for key, entry in _read_entries(folder).items()}
    return {key: info for key, info in parsed.items() if info is not None}


def _read_entries(folder: Path) -> dict[str, Any]:
    """Return the entries of a folder's manifest as they are; empty if there is no manifest."""
    path = folder / MANIFEST
    try:
        manifest = json_text.loads(path.read_bytes())
        version, entries = manifest["version"], dict(manifest["references"])
    except (FileNotFoundError, NotADirectoryError):
        return {}
    except (OSError, ValueError, KeyError, TypeError, RecursionError) as error:
        raise UsageError(
            f"{path} is damaged; restore it, or delete it and render its references again"
        ) from error
    if version != _VERSION:
        raise UsageError(
            f"{path} is of version {version}, not {_VERSION}; delete it and render its references "
            "again"
        )
    return entries


def _parse(key: str, entry: Any) -> ReferenceInfo | None:
    """Return an entry of a manifest; None if it is damaged."""
    try:
        fields = dict(entry)
        checksum = fields.pop("checksum")
        info = msgspec.convert(fields, ReferenceInfo)
    except (KeyError, TypeError, ValueError):
        return None
    return info if info.rendering.key == key and checksum == _checksum(info) else None


def _checksum(info: ReferenceInfo) -> str:
    return hashlib.sha256(msgspec.json.encode(info)).hexdigest()[:16]


def read(folder: Path, key: str) -> Reference | None:
    """Return the reference of `folder` with a name, or None if there is none.

    Whether it still fits the scene is not checked.

    Parameters
    ----------
    folder : Path
    key : str
        From `reference_key`.

    Raises
    ------
    UsageError
        If the manifest, the entry or an image is damaged, or an image is missing.
    """
    entries = _read_entries(folder)
    if key not in entries:
        return None
    info = _parse(key, entries[key])
    scene, _, view = key.rpartition("@")[0].partition("@")
    fix = f"restore it, or run 'oitbench reference {selection(scene, view or MAIN)}'"
    if info is None:
        raise UsageError(f"{folder / MANIFEST}: entry {key} is damaged; {fix}")
    try:
        read = [files.read_exr(stored.verify(folder, image)) for image in info.images]
        parts, variance = read[: len(info.parts)], read[len(info.parts) :]
        return Reference(
            info.rendering, info.noise_floor, info.seconds, tuple(parts), *variance[:1]
        )
    except (UsageError, SceneError) as error:
        raise UsageError(f"{error}; {fix}") from error


def stored_precision(reference: Reference) -> Reference:
    """Return a reference as it would be read after `save`."""
    parts = (
        part.astype(np.float16).astype(np.float32) if files.fits_half(part) else part
        for part in reference.parts
    )
    return replace(reference, parts=tuple(parts))


def save(folder: Path, reference: Reference) -> None:
    """Write a reference into `folder`, and remove images that no entry names any more.

    Raises
    ------
    UsageError
        If the folder cannot be written to, or its manifest is damaged.
    """
    key = reference.rendering.key
    stem = file_name(key)
    with writing(folder):
        folder.mkdir(parents=True, exist_ok=True)
    with locked(folder / _LOCK, wait=True):
        remove_partial_files(folder)
        entries = _read_entries(folder)
        parts, variance = reference.parts, None
        images = [files.image_channels(part, half=files.fits_half(part)) for part in parts]
        kept = [
            stored.store(folder, f"{stem}.{_part_name(number, parts)}", channels)
            for number, channels in enumerate(images)
        ]
        if reference.variance is not None:
            channels = files.image_channels(reference.variance)
            variance = stored.store(folder, f"{stem}.variance", channels)
        info = ReferenceInfo(
            reference.rendering, reference.noise_floor, reference.seconds, kept, variance
        )
        entries[key] = _entry(info)
        _write_entries(folder, entries)
        _remove_unnamed(folder, entries)


def adopt(folder: Path, key: str, rendering: Rendering) -> None:
    """Replace the rendering of an entry of `folder`, whose images stay.

    Raises
    ------
    UsageError
        If the entry is missing or damaged, or the manifest cannot be written.
    """
    with locked(folder / _LOCK, wait=True):
        entries = _read_entries(folder)
        info = _parse(key, entries.get(key))
        if info is None or rendering.key != key:
            raise UsageError(f"{folder / MANIFEST}: entry {key} is missing or damaged; render it")
        entries[key] = _entry(msgspec.structs.replace(info, rendering=rendering))
        _write_entries(folder, entries)


def _entry(info: ReferenceInfo) -> dict[str, Any]:
    return {**msgspec.to_builtins(info), "checksum": _checksum(info)}


def _write_entries(folder: Path, entries: Mapping[str, Any]) -> None:
    manifest = {"version": _VERSION, "references": dict(sorted(entries.items()))}
    text = json.dumps(manifest, indent=1, ensure_ascii=False, allow_nan=False) + "\n"
    with replacing(folder / MANIFEST) as partial:
        partial.write_text(text, encoding="utf-8")


def _remove_unnamed(folder: Path, entries: Mapping[str, Any]) -> None:
    """Remove the images of replaced references, also those that a killed process left."""
    infos = [_parse(key, entry) for key, entry in entries.items()]
    named = {image.path for info in infos if info for image in info.images}
    if None in infos:
        return  # The files of a damaged entry are unknown.
    with writing(folder):
        for kind in ("mean", "part?", "variance"):
            for path in folder.glob(f"*.{kind}-*.exr"):
                if path.name not in named:
                    path.unlink(missing_ok=True)

"""What `oitbench motion` found: its file, with every field, and the same as CSV."""

from __future__ import annotations

import csv
from pathlib import Path
from typing import Annotated, Final, Literal

import msgspec
from msgspec import Meta, Struct

from oitbench.atomic import replacing, writing
from oitbench.image.stored import StoredImage
from oitbench.method.families import OTHER
from oitbench.motion import metrics
from oitbench.results.documents import read_document
from oitbench.results.schema import Renderer
from oitbench.results.table import shielded
from oitbench.scene import Camera, Vector
from oitbench.views import seen

VERSION: Final = 1
JSON, CSV, FRAMES = "motion.json", "motion.csv", "frames"
Seeds = Literal["", "fixed", "per frame"]
FIXED: Final = "fixed"
PER_FRAME: Final = "per frame"
POPS, FLICKERS, STEADY = "pops", "flickers", "steady"
_HEADING = (
    "method", "seeds", "frame", "flip", "flicker_mean", "flicker_worst", "flicker_largest",
    "exact_change", "jump",
)  # fmt: skip


class _Typed(Struct, frozen=True, forbid_unknown_fields=True):
    """Base of all parts of the file."""


class CameraPlace(_Typed, frozen=True):
    """A camera of the path, in the scene's unit; angles are radians.

    `height` is that of the picture of an orthographic camera; null for a pinhole.
    """

    position: Vector
    target: Vector
    up: Vector
    fov_y: float
    height: float | None = None

    @classmethod
    def of(cls, camera: Camera) -> CameraPlace:
        """Return the place of a camera."""
        return cls(camera.position, camera.target, camera.up, camera.fov_y, camera.height)


class Pop(_Typed, frozen=True):
    """The jump of a block of pixels that is left after the step of the path was halved often.

    `transition` is the frame before it, and `block` its row and column. `popping` is the excess
    jump of the method, and `exact` the change of exact compositing there in the same step.
    """

    transition: Annotated[int, Meta(ge=0)]
    block: tuple[int, int]
    popping: float
    exact: float

    @property
    def pops(self) -> bool:
        """Whether exact compositing does not jump as far, and the jump is visible."""
        return self.popping > max(self.exact, metrics.VISIBLE)


class Track(_Typed, frozen=True):
    """One method of a `family` (see `oitbench.method.families`) along the path.

    `seeds` says whether random numbers are the same in all frames or others in each; empty for a
    method that has no seed. `flip` has a value for each frame. `flicker`, `worst`, `largest` and
    `jumps` have one for each transition: see `oitbench.motion.metrics`. `pops` are the transitions
    that were looked at closely; none if seeds change. `rest` is the mean change of pixels with a
    transparent fragment while the camera stands still and seeds change; null for other tracks.
    """

    method: str
    name: str
    seeds: Seeds
    frames: list[StoredImage]
    flip: list[float | None]
    flicker: list[float]
    worst: list[float]
    largest: list[float]
    jumps: list[float]
    pops: list[Pop] = []
    rest: float | None = None
    family: str = OTHER

    @property
    def label(self) -> str:
        """The method, and how its random numbers change if it has any."""
        return f"{self.method}, seeds {self.seeds}" if self.seeds else self.method

    @property
    def mean_flicker(self) -> float:
        """Mean excess change of all transitions."""
        return metrics.mean(self.flicker)

    @property
    def worst_flicker(self) -> float:
        """The worst excess change of all transitions, see `oitbench.motion.metrics.WORST`."""
        return max(self.worst, default=0.0)

    @property
    def worst_pop(self) -> Pop | None:
        """The jump that exceeds exact compositing's most, of those that pop if any does."""
        return max(self.pops, key=lambda pop: (pop.pops, pop.popping - pop.exact), default=None)


class MotionFile(_Typed, frozen=True):
    """A scene along a path, by exact compositing and by methods.

    `view` names the camera with which an orbit begins. `exposure` is in stops. `exact` are the
    pictures of exact compositing, and `change` is its mean change in each transition, over pixels
    with a transparent fragment. `failed` has reasons by the label of a method.
    """

    gl: Renderer
    scene: str
    size: tuple[int, int]
    ssaa: int
    exposure: float
    shading: str
    view: str
    path: list[CameraPlace]
    exact: list[StoredImage]
    change: list[float]
    tracks: list[Track]
    failed: dict[str, str] = {}
    schema: Literal[1] = VERSION

    @property
    def title(self) -> str:
        """The label of the scene with its view, unless that is the main one."""
        return seen(self.scene, self.view)

    @property
    def mean_change(self) -> float:
        """Mean change of exact compositing along the path."""
        return metrics.mean(self.change)

    def verdicts(self, track: Track) -> list[str]:
        """Return "pops" and "flickers", as far as they apply, or "steady"."""
        found = [POPS] if any(pop.pops for pop in track.pops) else []
        moving = track.mean_flicker > max(self.mean_change, metrics.VISIBLE)
        if moving or (track.rest or 0.0) > metrics.VISIBLE:
            found.append(FLICKERS)
        return found or [STEADY]


def write(folder: Path, found: MotionFile) -> None:
    """Write `motion.json` and `motion.csv`, and remove frames that they do not name.

    Raises
    ------
    StorageError
        The folder cannot be written to.
    """
    text = msgspec.json.format(msgspec.json.encode(found), indent=1)
    with replacing(folder / JSON) as partial:
        partial.write_bytes(text + b"\n")
    with (
        replacing(folder / CSV) as partial,
        partial.open("w", newline="", encoding="utf-8") as file,
    ):
        writer = csv.writer(file)
        writer.writerow(_HEADING)
        for track in found.tracks:
            for frame, flip in enumerate(track.flip):
                writer.writerow([*map(shielded, (track.method, track.seeds)), frame, flip,
                                 *_transition(found, track, frame - 1)])  # fmt: skip
    named = {image.path for track in found.tracks for image in track.frames}
    named |= {image.path for image in found.exact}
    with writing(folder / FRAMES):
        for path in (folder / FRAMES).glob("*.exr"):
            if f"{FRAMES}/{path.name}" not in named:
                path.unlink(missing_ok=True)


def _transition(found: MotionFile, track: Track, place: int) -> list[float | None]:
    """Return the numbers of the transition to a frame; the first frame has none."""
    series = (track.flicker, track.worst, track.largest, found.change, track.jumps)
    return [None if place < 0 else values[place] for values in series]


def find(results: Path) -> list[Path]:
    """Return the folders of films in the folder `motion` of a results folder."""
    place = results / "motion"
    return sorted(path.parent for path in (*place.glob(JSON), *place.glob(f"*/{JSON}")))


def read(path: Path) -> MotionFile:
    """Read a `motion.json`.

    Raises
    ------
    UsageError
        The file cannot be read, holds something else, or another version of the suite wrote it.
    """
    return read_document(path, MotionFile, VERSION, "motion")

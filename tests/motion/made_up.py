"""A made-up folder of `oitbench motion`."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from oitbench.image import files, stored
from oitbench.image.stored import StoredImage
from oitbench.motion import record
from oitbench.motion.record import (
    FIXED,
    FRAMES,
    PER_FRAME,
    CameraPlace,
    MotionFile,
    Pop,
    Seeds,
    Track,
)
from oitbench.results.schema import Renderer
from oitbench.scene import Camera

SIDE, COUNT = 16, 3
CHANGE = 0.05


def pictures(folder: Path, stem: str, level: float) -> list[StoredImage]:
    """Write frames that get brighter."""
    return [
        stored.store(
            folder,
            f"{FRAMES}/{stem}-{k}",
            files.image_channels(np.full((SIDE, SIDE, 3), level + 0.1 * k, np.float32)),
        )
        for k in range(COUNT)
    ]


def track(
    folder: Path,
    method: str,
    seeds: Seeds = "",
    flicker: float = 0.01,
    popping: float | None = None,
    rest: float | None = None,
) -> Track:
    """Return a track; `popping` is that of the first transition."""
    pops = [] if popping is None else [Pop(0, (1, 0), popping, 0.01)]
    series = [flicker] * (COUNT - 1)
    flips: list[float | None] = [0.1, None, 0.2]
    stem = method.partition("[")[0]
    frames = pictures(folder, f"{stem}{len(seeds)}", 0.3)
    return Track(method, stem, seeds, frames, flips, series, series, series, series, pops, rest)


def write(folder: Path) -> MotionFile:
    """Write a folder with one method of each verdict, and return what it holds."""
    folder.mkdir(parents=True, exist_ok=True)
    tracks = [
        track(folder, "calm", popping=0.0),
        track(folder, "leaping[sort=object]", popping=0.2),
        track(folder, "noisy", FIXED),
        track(folder, "noisy", PER_FRAME, rest=0.02),
        track(folder, "shaking", flicker=0.2),
    ]
    camera = CameraPlace.of(Camera((0, 0, 5)))
    found = MotionFile(
        Renderer("softly"), "fog", (SIDE, SIDE), 2, 0.0, "", "main", [camera] * COUNT,
        pictures(folder, "exact", 0.2), [CHANGE] * (COUNT - 1), tracks, {"broken": "no shader"},
    )  # fmt: skip
    record.write(folder, found)
    return found

"""Fragment lists for experiments: few layers, the same in every pixel or one list a column."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from oitbench.scene import BLACK, RGB, WHITE, Camera, FragmentLists, Scene

Array32 = npt.NDArray[np.float32]
SIDE = 16
"""Width and height in pixels of lists that say nothing else."""
BACKGROUND: RGB = (0.35, 0.6, 0.85)
RED: RGB = (1.0, 0.0, 0.0)
GREEN: RGB = (0.0, 1.0, 0.0)
BLUE: RGB = (0.0, 0.0, 1.0)


@dataclass(frozen=True)
class Layer:
    """One fragment: view distance in metres, coverage, radiance, transmission."""

    z: float
    coverage: float
    radiance: RGB = WHITE
    transmission: RGB = BLACK


def stack(layers: Sequence[Layer], width: int = SIDE, height: int = SIDE) -> FragmentLists:
    """Return the same list in every pixel, submitted in the order given."""
    shape = (len(layers), height, width)

    def spread(values: Sequence[Any]) -> Array32:
        rows = np.asarray(values, dtype=np.float32)
        return np.broadcast_to(rows[:, None, None], (*shape, *rows.shape[1:])).copy()

    return FragmentLists(
        spread([layer.z for layer in layers]),
        spread([layer.coverage for layer in layers]),
        spread([layer.radiance for layer in layers]),
        spread([layer.transmission for layer in layers]),
    )


def columns(lists: Sequence[Sequence[Layer]]) -> FragmentLists:
    """Return one row of pixels, the i-th of which holds the i-th list; all are of one length."""
    parts = [stack(layers, 1, 1) for layers in lists]
    return FragmentLists(
        *(
            np.concatenate([getattr(part, name) for part in parts], axis=2)
            for name in ("z", "coverage", "radiance", "transmission")
        )
    )


def random_lists(count: int, tinted: bool = False, seed: int = 1) -> FragmentLists:
    """Return planes at distinct distances, in random order, of random content in every pixel."""
    random = np.random.default_rng(seed)
    shape = (count, SIDE, SIDE)
    planes = random.permutation(np.linspace(2, 6, count, dtype=np.float32))
    z = np.broadcast_to(planes[:, None, None], shape).copy()
    transmission = np.zeros((*shape, 3), dtype=np.float32)
    if tinted:
        random.random(out=transmission, dtype=np.float32)
    return FragmentLists(
        z,
        random.uniform(0.2, 0.8, shape).astype(np.float32),
        random.random((*shape, 3), dtype=np.float32),
        transmission,
    )


def scene_of(lists: FragmentLists, background: RGB = BACKGROUND, near: float = 0.1) -> Scene:
    """Return a scene of nothing but `lists`; window depth is 1 − `near`/z."""
    camera = Camera(position=(0, 0, 0), target=(0, 0, -1), near=near)
    return Scene("lists", camera, lists=lists, background=background)

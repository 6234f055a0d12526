"""Fragment lists for experiments: the same list in all pixels, one per column, or random ones."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from oitbench.scene import BLACK, RGB, WHITE, Camera, FragmentLists, Scene

Array32 = npt.NDArray[np.float32]
SIDE = 16
"""Default width and height of fragment lists, in pixels."""
BACKGROUND: RGB = (0.35, 0.6, 0.85)
RED: RGB = (1.0, 0.0, 0.0)
GREEN: RGB = (0.0, 1.0, 0.0)
BLUE: RGB = (0.0, 0.0, 1.0)


@dataclass(frozen=True)
class Layer:
    """One fragment.

    Parameters
    ----------
    z : float
        View distance in meters.
    coverage : float
    radiance, transmission : RGB
    """

    z: float
    coverage: float
    radiance: RGB = WHITE
    transmission: RGB = BLACK


def stack(layers: Sequence[Layer], side: int = SIDE) -> FragmentLists:
    """Return lists with the same fragments in every pixel.

    Parameters
    ----------
    layers : sequence of Layer
        In order of submission.
    side : int
        Width and height in pixels.
    """
    shape = (len(layers), side, side)

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
    """Return one row of pixels; pixel i has the fragments of `lists[i]`, which are equally many."""
    parts = [stack(layers, 1) for layers in lists]
    return FragmentLists(
        *(
            np.concatenate([getattr(part, name) for part in parts], axis=2)
            for name in ("z", "coverage", "radiance", "transmission")
        )
    )


def random_lists(
    count: int, tinted: bool = False, seed: int = 1, side: int = SIDE
) -> FragmentLists:
    """Return parallel planes with random values in every pixel.

    Parameters
    ----------
    count : int
        Planes, at distinct distances from 2 m to 6 m, submitted in random order.
    tinted : bool
        Draw transmissions from [0, 1). If false, they are zero.
    seed : int
    side : int
        Width and height in pixels.
    """
    random = np.random.default_rng(seed)
    shape = (count, side, side)
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
    """Return a scene that consists of `lists`; the window depth of a fragment is 1 − `near`/z."""
    camera = Camera(position=(0, 0, 0), target=(0, 0, -1), near=near)
    return Scene("lists", camera, lists=lists, background=background)

"""Random fragment lists, one for each pixel: no geometry, compositing alone.

Parameters
----------
detail : float
    Factor on the number of lists.
width, height : int
    Lists per row and rows of lists at detail 1.
layers : int
    Fragments in each list.
alpha_low, alpha_high : float
    Least and greatest coverage, in [0, 1].
tinted : bool
    Random colored transmission instead of none.
hdr : bool
    Radiance distributed evenly in stops from 0.01 to 100 instead of evenly in [0, 1].
ties : bool
    About half of the distances equal another one exactly.
seed : int
    Seed of all random numbers.

All lists are independent, with their fragments in random order, so that one picture of 256 × 256
pixels is 65,536 random test cases. Distances are uniform in [0.5, 20] m. They differ by more than
the step of a 32-bit depth buffer, unless `ties` is true.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from oitbench.errors import UsageError
from oitbench.parameters import Parameter
from oitbench.scene import Camera, FragmentLists, Scene

NEAREST, FARTHEST = 0.5, 20.0  # meters
LARGEST_GAP = 1e-3
"""Least difference of two distances in short lists, meters."""
BRIGHTEST_HDR = 100.0

parameters = {
    "detail": Parameter(1.0, low=0.0, high=100.0, help="factor on the number of lists"),
    "width": Parameter(256, low=1, high=8192, help="lists per row at detail 1"),
    "height": Parameter(256, low=1, high=8192, help="rows of lists at detail 1"),
    "layers": Parameter(8, low=1, high=4096, help="fragments in each list"),
    "alpha_low": Parameter(0.05, low=0.0, high=1.0, help="least coverage"),
    "alpha_high": Parameter(0.95, low=0.0, high=1.0, help="greatest coverage"),
    "tinted": Parameter(False, help="random colored transmission instead of none"),
    "hdr": Parameter(False, help="radiance distributed evenly in stops from 0.01 to 100"),
    "ties": Parameter(False, help="about half of the distances equal another one exactly"),
    "seed": Parameter(1, low=0, help="seed of all random numbers"),
}


def build(
    *,
    name: str,
    detail: float,
    width: int,
    height: int,
    layers: int,
    alpha_low: float,
    alpha_high: float,
    tinted: bool,
    hdr: bool,
    ties: bool,
    seed: int,
) -> Scene:
    """Return the lists. All values except the distances are independent and uniform."""
    if alpha_low > alpha_high:
        raise UsageError(
            f"{name}: alpha_low is {alpha_low:g}; it must not exceed alpha_high = {alpha_high:g}"
        )
    random = np.random.default_rng(seed)
    rows, columns = (max(1, round(side * detail**0.5)) for side in (height, width))
    shape = (layers, rows, columns)
    z = _tied_distances(random, shape) if ties else _distinct_distances(random, shape)
    coverage = alpha_low + (alpha_high - alpha_low) * random.random(shape, dtype=np.float32)
    radiance = random.random((*shape, 3), dtype=np.float32)
    if hdr:
        radiance = np.float32(BRIGHTEST_HDR) ** (2 * radiance - 1)
    transmission = np.zeros((*shape, 3), dtype=np.float32)
    if tinted:
        random.random(out=transmission, dtype=np.float32)
    return Scene(
        name=name,
        camera=Camera(position=(0, 0, 0), target=(0, 0, -1), near=0.1),
        lists=FragmentLists(z, np.clip(coverage, 0, 1), radiance, transmission),
        background=(0.35, 0.30, 0.25),
    )


def _distinct_distances(
    random: np.random.Generator, shape: tuple[int, int, int]
) -> npt.NDArray[np.float32]:
    """Return uniform distances, given that no two of one list are closer than a gap."""
    layers = shape[0]
    gap = min(LARGEST_GAP, 0.1 * (FARTHEST - NEAREST) / layers)
    z = random.random(shape, dtype=np.float32)
    z.sort(axis=0)
    # First uniform in the range less all gaps; then the gaps are inserted.
    z *= np.float32(FARTHEST - NEAREST - gap * (layers - 1))
    z += (NEAREST + gap * np.arange(layers, dtype=np.float32))[:, None, None]
    random.permuted(z, axis=0, out=z)
    return z


def _tied_distances(
    random: np.random.Generator, shape: tuple[int, int, int]
) -> npt.NDArray[np.float32]:
    """Return distances on evenly spaced steps, which are fewer than the fragments of a list."""
    steps = np.linspace(NEAREST, FARTHEST, max(1, shape[0] // 2), dtype=np.float32)
    return np.asarray(steps[random.integers(len(steps), size=shape)])

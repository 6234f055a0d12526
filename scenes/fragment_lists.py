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
family : str
    "even": coverage is uniform between both. "glass": it is one of both and their geometric mean.
    "tuft": two layers of the greatest coverage stand behind others of the least one, which are all
    in the nearest 4 % of the range of distances.
nearest, farthest : float
    Range of distances, meters.
tinted : bool
    Random colored transmission instead of none.
hdr : bool
    Radiance distributed evenly in stops from 0.01 to 100 instead of evenly in [0, 1].
ties : bool
    About half of the distances equal another one exactly.
seed : int
    Seed of all random numbers.

All lists are independent, with their fragments in random order, so that one picture of 256 × 256
pixels is 65,536 random test cases. Distances are uniform in their range, except those of a tuft.
They differ by more than the step of a 32-bit depth buffer, unless `ties` is true.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from oitbench.errors import UsageError
from oitbench.parameters import Parameter
from oitbench.scene import Camera, FragmentLists, Scene

LARGEST_GAP = 1e-3
"""Least difference of two distances in short lists, meters."""
LEAST_RANGE = 0.1
"""Least difference of both ends of the range of distances, meters."""
STRANDS = 0.04
"""Part of the range of distances, at its near end, in which a tuft lies."""
BEHIND = 2
"""Layers behind a tuft."""
BRIGHTEST_HDR = 100.0

subject = "layers"
parameters = {
    "detail": Parameter(1.0, low=0.0, high=100.0, help="factor on the number of lists"),
    "width": Parameter(256, low=1, high=8192, help="lists per row at detail 1"),
    "height": Parameter(256, low=1, high=8192, help="rows of lists at detail 1"),
    "layers": Parameter(8, low=1, high=4096, help="fragments in each list"),
    "alpha_low": Parameter(0.05, low=0.0, high=1.0, help="least coverage"),
    "alpha_high": Parameter(0.95, low=0.0, high=1.0, help="greatest coverage"),
    "family": Parameter(
        "even", choices=("even", "glass", "tuft"), help="distribution of coverage and distances"
    ),
    "nearest": Parameter(0.5, low=0.2, high=1000.0, help="least distance, m"),
    "farthest": Parameter(20.0, low=0.2, high=1000.0, help="greatest distance, m"),
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
    family: str,
    nearest: float,
    farthest: float,
    tinted: bool,
    hdr: bool,
    ties: bool,
    seed: int,
) -> Scene:
    """Return the lists. Radiance and transmission are independent and uniform."""
    if alpha_low > alpha_high:
        raise UsageError(
            f"{name}: alpha_low is {alpha_low:g}; it must not exceed alpha_high = {alpha_high:g}"
        )
    if farthest < nearest + LEAST_RANGE:
        raise UsageError(
            f"{name}: farthest is {farthest:g} m; it must exceed nearest = {nearest:g} m by"
            f" {LEAST_RANGE:g} m"
        )
    if ties and family == "tuft":
        raise UsageError(f"{name}: a tuft has no tied distances; leave out ties or the family")
    random = np.random.default_rng(seed)
    rows, columns = (max(1, round(side * detail**0.5)) for side in (height, width))
    shape = (layers, rows, columns)
    reach, alphas = (nearest, farthest), (alpha_low, alpha_high)
    if family == "tuft":
        z, coverage = _tuft(random, shape, reach, alphas)
    else:
        z = (_tied_distances if ties else _distinct_distances)(random, shape, reach)
        coverage = _coverage(random, shape, alphas, family)
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


def _coverage(
    random: np.random.Generator,
    shape: tuple[int, int, int],
    alphas: tuple[float, float],
    family: str,
) -> npt.NDArray[np.float32]:
    """Return independent coverage, between the least and the greatest or one of three values."""
    low, high = alphas
    if family == "glass":
        return random.choice(np.array([low, (low * high) ** 0.5, high], np.float32), shape)
    return low + (high - low) * random.random(shape, dtype=np.float32)


def _tuft(
    random: np.random.Generator,
    shape: tuple[int, int, int],
    reach: tuple[float, float],
    alphas: tuple[float, float],
) -> tuple[npt.NDArray[np.float32], npt.NDArray[np.float32]]:
    """Return distances and coverage of thin strands before a few stronger layers."""
    layers, rows, columns = shape
    behind = min(BEHIND, layers)
    edge = reach[0] + STRANDS * (reach[1] - reach[0])
    parts = ((layers - behind, (reach[0], edge)), (behind, (edge + LARGEST_GAP, reach[1])))
    z = np.concatenate([_distinct_distances(random, (n, rows, columns), ends) for n, ends in parts])
    strong = np.arange(layers)[:, None, None] >= layers - behind
    coverage = np.broadcast_to(np.where(strong, *reversed(alphas)), shape).astype(np.float32)
    order = random.permuted(np.broadcast_to(np.arange(layers)[:, None, None], shape), axis=0)
    return np.take_along_axis(z, order, axis=0), np.take_along_axis(coverage, order, axis=0)


def _distinct_distances(
    random: np.random.Generator, shape: tuple[int, int, int], reach: tuple[float, float]
) -> npt.NDArray[np.float32]:
    """Return uniform distances, given that no two of one list are closer than a gap."""
    layers, (nearest, farthest) = shape[0], reach
    gap = min(LARGEST_GAP, 0.1 * (farthest - nearest) / max(layers, 1))
    z = random.random(shape, dtype=np.float32)
    z.sort(axis=0)
    # First uniform in the range less all gaps; then the gaps are inserted.
    z *= np.float32(farthest - nearest - gap * (layers - 1))
    z += (nearest + gap * np.arange(layers, dtype=np.float32))[:, None, None]
    random.permuted(z, axis=0, out=z)
    return z


def _tied_distances(
    random: np.random.Generator, shape: tuple[int, int, int], reach: tuple[float, float]
) -> npt.NDArray[np.float32]:
    """Return distances on evenly spaced steps, which are fewer than the fragments of a list."""
    steps = np.linspace(*reach, max(1, shape[0] // 2), dtype=np.float32)
    return np.asarray(steps[random.integers(len(steps), size=shape)])

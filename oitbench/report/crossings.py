"""Where the lowest errors of two families cross, over the layers or the opacity of stacks."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from oitbench.report.families import UNSEEN, Case
from oitbench.scene import Floats

_LEAST_LAYERS = 3


@dataclass(frozen=True)
class Grid:
    """Stacks by row, number of layers and seed, of which all combinations exist.

    A row has the stacks that differ in their number of layers and their seed alone.

    Parameters
    ----------
    rows : tuple of str
        `Case.row`, by ascending opacity.
    opacities, layers : tuple of float
        Mean of each row; numbers of layers.
    stacks : tuple of tuple of tuple of Case
        (rows, layers, seeds).
    """

    rows: tuple[str, ...]
    opacities: tuple[float, ...]
    layers: tuple[float, ...]
    stacks: tuple[tuple[tuple[Case, ...], ...], ...]

    @property
    def seeds(self) -> int:
        """Number of seeds."""
        return len(self.stacks[0][0])

    def errors(self, methods: Iterable[str]) -> Floats:
        """Return the lowest RMSE of some methods, (rows, layers, seeds); infinite for none."""
        known = tuple(methods)

        def of(stack: Case) -> float:
            return min((stack.rmse.get(method, math.inf) for method in known), default=math.inf)

        return np.array([[[of(stack) for stack in seeds] for seeds in row] for row in self.stacks])


def swept_rows(stacks: Iterable[Case]) -> dict[str, list[Case]]:
    """Return the stacks by row; rows with fewer than three numbers of layers are left out."""
    rows: dict[str, list[Case]] = {}
    for stack in stacks:
        rows.setdefault(stack.row, []).append(stack)
    return {
        name: row for name, row in rows.items() if len({s.layers for s in row}) >= _LEAST_LAYERS
    }


def grid_of(rows: Mapping[str, Sequence[Case]]) -> Grid | None:
    """Return the rows that have the same layers, seeds and methods; None if there are none.

    The row with most stacks decides which numbers of layers and which seeds belong to the grid. A
    stack that lacks a method of another one, as in a run that was interrupted, does not count.
    """
    methods = {method for row in rows.values() for stack in row for method in stack.rmse}
    known = {
        name: {(s.layers, s.seed): s for s in row if s.rmse.keys() == methods}
        for name, row in rows.items()
    }
    whole = max(known.values(), key=len, default={})
    layers, seeds = sorted({n for n, _ in whole}), sorted({seed for _, seed in whole})
    if len(layers) < _LEAST_LAYERS:
        return None
    full = {
        name: row
        for name, row in known.items()
        if all((n, seed) in row for n in layers for seed in seeds)
    }
    if not full:
        return None
    means = {name: _mean_opacity(row) for name, row in full.items()}
    ordered = sorted(full, key=means.__getitem__)
    return Grid(
        tuple(ordered),
        tuple(means[name] for name in ordered),
        tuple(layers),
        tuple(
            tuple(tuple(full[name][n, seed] for seed in seeds) for n in layers) for name in ordered
        ),
    )


def _mean_opacity(row: Mapping[tuple[float, str], Case]) -> float:
    return float(np.mean([stack.opacity for stack in row.values()]))


@dataclass(frozen=True)
class Sweep:
    """Errors along the layers or the opacity of stacks, all else being equal.

    Parameters
    ----------
    by_layers : bool
        Whether the number of layers grows; else the opacity does.
    at : int
        Index of the row or of the number of layers that stays the same.
    fixed : float
        That opacity or number of layers.
    x : tuple of float
    lead : array, shape (places, seeds)
        As `lead` returns it.
    """

    by_layers: bool
    at: int
    fixed: float
    x: tuple[float, ...]
    lead: Floats

    @property
    def crossings(self) -> list[float]:
        """Layers beyond which, or opacity below which the second family is better, by seed."""
        step = 1 if self.by_layers else -1
        return [crossing(self.x[::step], seed[::step]) for seed in self.lead.T]

    @property
    def middle(self) -> float:
        """The median crossing over seeds."""
        return float(np.median(self.crossings))

    @property
    def crosses(self) -> bool:
        """Whether there is one."""
        return 0 < self.middle < math.inf

    @property
    def nearest(self) -> int:
        """The place next to the crossing; the middle one if there is none."""
        if not self.crosses:
            return len(self.x) // 2
        return int(np.abs(np.log(self.x) - math.log(self.middle)).argmin())

    def along(self, errors: Floats) -> Floats:
        """Return the errors of this sweep, (places,), out of (rows, layers, seeds)."""
        mean = errors.mean(axis=-1)
        return np.asarray(mean[self.at] if self.by_layers else mean[:, self.at])


def sweeps(grid: Grid, first: Floats, second: Floats) -> Iterator[Sweep]:
    """Yield a sweep over layers for each row, and over opacity for each number of layers.

    Parameters
    ----------
    grid : Grid
    first, second : array, shape (rows, layers, seeds)
        Lowest errors of two families.
    """
    ahead = lead(first, second)
    for row, opacity in enumerate(grid.opacities):
        yield Sweep(True, row, opacity, grid.layers, ahead[row])
    if len(grid.opacities) > 1:
        for place, n in enumerate(grid.layers):
            yield Sweep(False, place, n, grid.opacities, ahead[:, place])


def lead(first: Floats, second: Floats) -> Floats:
    """Return by which logarithm the second error is lower; errors below `UNSEEN` count as this."""
    return np.asarray(np.log(np.maximum(first, UNSEEN) / np.maximum(second, UNSEEN)))


def crossing(x: Sequence[float], ahead: Sequence[float]) -> float:
    """Return the place beyond which `ahead` stays positive, logarithmically interpolated.

    Parameters
    ----------
    x : sequence of float
        Positive places, ascending or descending.
    ahead : sequence of float

    Returns
    -------
    float
        0 if `ahead` is positive everywhere, and infinite if it is not so at the last place; the
        other way round if `x` descends.
    """
    ends = (0.0, math.inf) if x[0] < x[-1] else (math.inf, 0.0)
    behind = [place for place, value in enumerate(ahead) if value <= 0]
    if not behind:
        return ends[0]
    last = behind[-1]
    if last == len(x) - 1:
        return ends[1]
    part = -ahead[last] / (ahead[last + 1] - ahead[last])
    return float(x[last] * (x[last + 1] / x[last]) ** part)

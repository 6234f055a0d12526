"""What cells cost, learned from a few: a factor for each scene, method and setting.

The logarithm of a cell's cost is a sum of effects: of its scene, of its stage (sub-pixels, shading,
view), of its method, of the method's parameters and of the effects that run. Ridge regression
finds them. An effect that no sample shows is zero, so that an unknown scene costs what scenes
usually cost.
"""

from __future__ import annotations

from collections.abc import Hashable, Iterator, Sequence

import numpy as np
import numpy.typing as npt

from oitbench.matrix.cell import Cell

_RIDGE, _FINE_RIDGE = 0.02, 0.2
"""Weights of squared effects. The second one is that of effects which refine others: a variant of
a method that no sample shows costs what other variants do."""
_LEAST = 1e-6
"""Smallest cost, since a logarithm needs one."""


class CostModel:
    """Costs of cells; sizes of images are no part of it, so all samples must be of one size.

    Parameters
    ----------
    samples : sequence of (Cell, float)
        Cells whose costs are known, at least one, in any unit.
    """

    def __init__(self, samples: Sequence[tuple[Cell, float]]) -> None:
        costs = np.array([max(cost, _LEAST) for _, cost in samples])
        names = dict.fromkeys(name for cell, _ in samples for name in _effects(cell))
        self._places = {name: place for place, name in enumerate(names)}
        rows = self._rows([cell for cell, _ in samples])
        logs = np.log(costs)
        self._mean = float(logs.mean())
        square = rows.T @ rows + np.diag([_ridge(kind) for kind, _ in names])
        self._found = np.linalg.solve(square, rows.T @ (logs - self._mean))
        # The exponential of a mean is less than the mean of exponentials.
        self._scale = 1.0
        self._scale = float(costs.sum() / self.predict([cell for cell, _ in samples]).sum())

    def predict(self, cells: Sequence[Cell]) -> npt.NDArray[np.float64]:
        """Return the costs of cells in the unit of the samples, shape (n,)."""
        found: npt.NDArray[np.float64] = np.exp(self._mean + self._rows(cells) @ self._found)
        return self._scale * found

    def _rows(self, cells: Sequence[Cell]) -> npt.NDArray[np.float64]:
        """Return which effects each cell has, shape (cells, effects)."""
        rows = np.zeros((len(cells), len(self._places)))
        for row, cell in zip(rows, cells, strict=True):
            row[[self._places[name] for name in _effects(cell) if name in self._places]] = 1.0
        return rows


def _ridge(kind: str) -> float:
    return _RIDGE if kind in ("scene", "method") else _FINE_RIDGE


def _effects(cell: Cell) -> Iterator[tuple[str, Hashable]]:
    """Yield the names of the effects that a cell's cost is a product of."""
    yield "scene", cell.scene
    yield "stage", (cell.scene, cell.ssaa, cell.shading, cell.view)
    yield "method", cell.method.partition("[")[0]
    yield "parameters", cell.method
    yield "effects", cell.effects

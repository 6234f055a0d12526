"""The cells that a figure of a paper needs, by names alone; a run decides their size."""

from __future__ import annotations

from collections.abc import Iterable

from msgspec import Struct
from msgspec.structs import replace


class Need(Struct, frozen=True):
    """A cell of any size.

    Parameters
    ----------
    scene, method : str
        Canonical labels.
    view, effects, shading : str
        As in `oitbench.matrix.cell.Cell`.
    truths : tuple of str
        Keys of the truths that a figure shows beside the cell.
    """

    scene: str
    method: str
    view: str
    effects: str
    shading: str = ""
    truths: tuple[str, ...] = ()

    @property
    def cell(self) -> Need:
        """The same cell, whatever truths are shown."""
        return replace(self, truths=())


def merged(needs: Iterable[Need]) -> list[Need]:
    """Return each cell once, with the truths of all who need it, in order of first appearance."""
    found: dict[Need, dict[str, None]] = {}
    for need in needs:
        found.setdefault(need.cell, {}).update(dict.fromkeys(need.truths))
    return [replace(cell, truths=tuple(truths)) for cell, truths in found.items()]

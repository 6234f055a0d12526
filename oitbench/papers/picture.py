"""A picture of a figure: which cell shows it, which of the cell's pictures, and which part."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

from oitbench.catalog.needs import Need, merged
from oitbench.method.ablation import REQUESTED
from oitbench.truths import EXACT, MATCHED
from oitbench.views import MAIN


@dataclass(frozen=True)
class Picture:
    """A picture by names alone.

    Parameters
    ----------
    scene, method : str
        Canonical labels of the cell.
    label : str
        Heading for readers; empty for none.
    truth : str
        Show this truth, as the cell was compared with it, and not what the method drew.
    target : str
        Show this target or view of the method, drawn for the figure.
    crop : str
        Show this part of the picture, which the scene's file names.
    view, effects, shading : str
        As in `oitbench.matrix.cell.Cell`.
    """

    scene: str
    method: str
    label: str = ""
    truth: str = ""
    target: str = ""
    crop: str = ""
    view: str = MAIN
    effects: str = REQUESTED
    shading: str = ""

    @property
    def need(self) -> Need:
        """The cell that has the picture. Exact compositing belongs to every cell."""
        truths = (self.truth,) if self.truth not in ("", EXACT) else ()
        return Need(self.scene, self.method, self.view, self.effects, self.shading, truths)

    def part(self, crop: str) -> Picture:
        """Return a part of the same picture, without a heading."""
        return replace(self, crop=crop, label="")

    @property
    def traced(self) -> Picture:
        """The matched reference of the same cell, without a heading."""
        return replace(self, truth=MATCHED, label="")


def needs_of(pictures: Iterable[Picture | None]) -> list[Need]:
    """Return the cells of some pictures, each once."""
    return merged(picture.need for picture in pictures if picture is not None)

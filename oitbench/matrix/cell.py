"""One cell of the matrix: a scene, a method, a frame size and a set of effects, by name."""

from __future__ import annotations

from typing import Any

from msgspec import Struct

from oitbench.effects import Effect
from oitbench.errors import UsageError, unknown
from oitbench.method.ablation import REQUESTED, leave_out
from oitbench.results.schema import CellKey, Record, Status
from oitbench.shading import ShadingSettings, read_shading
from oitbench.truths import TRUTHS
from oitbench.views import MAIN, seen

_ORDER_SIDE = 128
"""Pixels of the shorter side at which pictures of permuted draws show what their order changes."""


class Cell(Struct, frozen=True):
    """The description of a cell in names alone, so that it can be sent to another process.

    Parameters
    ----------
    scene, method : str
        Canonical labels.
    size : (int, int)
        Width and height of the image in pixels.
    ssaa : int
        Side of the sub-pixel grid of accuracy images; cost is measured without sub-pixels.
    effects : str
        "requested", "all", "none", or names to leave out, as in "-diffusion,-refraction"; effects
        that depend on them are left out too (`oitbench.method.ablation.NEEDS`).
    seed : int
    permutations : int
        Random orders of the draws in which the image is rendered again, at most, small and without
        sub-pixels, to measure how far it depends on them.
    truths : tuple of str
        Keys of the truths to score against; the exact one is always among them.
    shading : str
        Settings of shared shading that differ from their defaults, as `ShadingSettings.label`.
    view : str
        Name of the scene's camera; see `Scene.from_view`.
    reduced : bool
        Compare traced truths with a smaller picture, whose sub-pixels are the pixels of `size`.
    most_layers : int, optional
        See `Preset`.
    """

    scene: str
    method: str
    size: tuple[int, int]
    ssaa: int = 2
    effects: str = REQUESTED
    seed: int = 1
    permutations: int = 4
    truths: tuple[str, ...] = tuple(TRUTHS)
    shading: str = ""
    view: str = MAIN
    reduced: bool = False
    most_layers: int | None = None

    @property
    def traced_size(self) -> tuple[int, int]:
        """Width and height in pixels of the picture that traced truths are compared with."""
        width, height = self.size
        return (width // self.ssaa, height // self.ssaa) if self.reduced else self.size

    @property
    def order_size(self) -> tuple[int, int]:
        """Width and height in pixels of the pictures of permuted draws."""
        width, height = self.size
        factor = max(1, min(self.size) // _ORDER_SIDE)
        return width // factor, height // factor

    @property
    def key(self) -> CellKey:
        """The cell's place in a store."""
        return CellKey(
            self.scene, self.method, self.size, self.ssaa, self.effects, self.shading, self.view
        )

    @property
    def seen(self) -> str:
        """The label of the scene with its view, unless that is the main one."""
        return seen(self.scene, self.view)

    def record(self, status: Status, reason: str = "", **fields: Any) -> Record:
        """Return the record of this cell.

        Parameters
        ----------
        status, reason : str
        **fields
            Further fields of `Record`.
        """
        name = self.method.partition("[")[0]
        return Record(
            self.scene, self.method, name, self.size, self.ssaa, self.effects, self.seed,
            self.permutations, list(self.truths), status, reason,
            shading=self.shading, view=self.view, most_layers=self.most_layers, **fields,
        )  # fmt: skip

    @property
    def settings(self) -> ShadingSettings:
        """The settings of shared shading."""
        return read_shading(self.shading)


def choose_effects(text: str, requested: Effect) -> Effect:
    """Return the effects that `text` selects; see `Cell.effects`.

    Parameters
    ----------
    text : str
    requested : Effect
        Effects that the scene requests.

    Raises
    ------
    UsageError
        The text or the name of an effect is unknown.
    """
    if text in (REQUESTED, "all", "none"):
        return {REQUESTED: requested, "all": ~Effect.NONE, "none": Effect.NONE}[text]
    chosen = requested
    for part in text.split(","):
        name = part.strip().removeprefix("-").upper()
        if not part.strip().startswith("-"):
            raise UsageError(
                f"effects '{text}': give {REQUESTED}, all, none, or -NAME to leave one out"
            )
        if name not in Effect.__members__:
            raise unknown("effect", name.lower(), [e.lower() for e in Effect.__members__])
        chosen = leave_out(chosen, Effect[name])
    return chosen

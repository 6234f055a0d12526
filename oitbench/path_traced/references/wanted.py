"""The reference that pictures of a scene are compared with, by what it must show."""

from __future__ import annotations

from dataclasses import dataclass

from oitbench.effects import Effect, names
from oitbench.path_traced.matched.render import is_random
from oitbench.path_traced.references.storage import reference_key
from oitbench.scene import Scene
from oitbench.truths import FULL, MATCHED, traced_effects
from oitbench.views import MAIN

REFRACTED_SSAA = 8
"""Least side of the sub-pixel grid of matched refraction, which aliases on a coarser one: sharp
refracted edges differ by FLIP .04 between 2 and 4."""
PART_SSAA = 4
"""The same for each part of a random picture: the rays of its eight parts are jittered."""


@dataclass(frozen=True, eq=False)
class Wanted:
    """A reference that is looked for.

    Parameters
    ----------
    scene : Scene
        As seen from the view.
    label : str
        The canonical label of the scene.
    size : (int, int)
        Width and height in pixels.
    ssaa : int
        Side of the sub-pixel grid of the pictures that are compared with it.
    truth : str
        MATCHED or FULL.
    chosen : Effect
        Effects that are not left out. Full path tracing leaves none out.
    view : str
        Name of the camera of `scene`.
    """

    scene: Scene
    label: str
    size: tuple[int, int]
    ssaa: int
    truth: str = MATCHED
    chosen: Effect = ~Effect.NONE
    view: str = MAIN

    @property
    def effects(self) -> Effect:
        """Effects that run."""
        requested = self.scene.effects
        return requested if self.truth == FULL else traced_effects(requested, self.chosen)

    @property
    def left_out(self) -> list[str]:
        """Names of the effects that the scene requests and that do not run."""
        return names(self.scene.effects & ~self.effects)

    @property
    def jittered(self) -> bool:
        """Whether rays pass through their sub-pixels at random, so that aliasing becomes noise."""
        return self._refracts and is_random(self.scene, self.effects)

    @property
    def grid(self) -> int:
        """Side of the sub-pixel grid of the reference."""
        if not self._refracts:
            return self.ssaa
        return max(self.ssaa, PART_SSAA if self.jittered else REFRACTED_SSAA)

    @property
    def _refracts(self) -> bool:
        return self.truth == MATCHED and Effect.REFRACTION in self.effects

    @property
    def key(self) -> str:
        """The name of the reference in a manifest."""
        return reference_key(self.label, self.size, self.truth, self.left_out, self.view)

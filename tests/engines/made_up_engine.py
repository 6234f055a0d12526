"""An engine for tests, from outside of the suite: planes that fill the view, blended in numpy."""

from __future__ import annotations

import os
from typing import ClassVar

import numpy as np

from oitbench.engines import Algorithm, Content, Drawing, Engine
from oitbench.errors import SceneError
from oitbench.image.files import Image


class Abacus(Engine):
    """Blends all planes in order of submission, as its peer does."""

    algorithms: ClassVar = {
        "blend": Algorithm("alpha_blend", "single floats"),
        "refuse": Algorithm("alpha_blend", ""),
        "raise": Algorithm("alpha_blend", ""),
        "end": Algorithm("alpha_blend", ""),
        "end_later": Algorithm("alpha_blend", ""),
    }
    version, renderer = "1.0", "beads"

    def open(self, content: Content, algorithm: str, size: tuple[int, int]) -> Drawing:
        if algorithm == "refuse":
            raise SceneError("the beads are too few")
        return Beads(content, algorithm, size)


class Beads(Drawing):
    """A picture of one color."""

    def __init__(self, content: Content, algorithm: str, size: tuple[int, int]) -> None:
        self._content, self._algorithm, self._size = content, algorithm, size
        self._drawn = 0

    def draw(self) -> None:
        self._drawn += 1
        if self._algorithm == "raise":
            raise ValueError("a bead fell off")
        if self._algorithm == "end" or (self._algorithm == "end_later" and self._drawn > 3):
            os._exit(3)

    def image(self) -> Image:
        color = np.array(self._content.background, dtype=np.float32)
        for surface in self._content.surfaces:
            opacity = surface.opacity[0]
            color = opacity * surface.color[0] + (1 - opacity) * color
        return np.broadcast_to(color, (self._size[1], self._size[0], 3)).astype(np.float32)

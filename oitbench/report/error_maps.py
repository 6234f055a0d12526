"""Colors of error maps: one scale for all maps of a scene, which follows from their errors."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from oitbench.image.files import Image
from oitbench.results.schema import Record

_BRIGHTER = 4
"""The brightest color is about that many times the largest mean error."""
_TOPS = (0.01, 0.02, 0.05, 0.1, 0.2, 0.5)


@dataclass(frozen=True)
class MapScale:
    """A scale from 0 to `top`, by the square root, so that small errors stay visible."""

    top: float = 1.0

    @property
    def words(self) -> str:
        """The ends of the scale."""
        more = "" if self.top >= 1 else " or more"
        return (
            f"from 0 (black) to {self.top:g}{more} (pale yellow); brightness follows the square"
            " root of the error"
        )

    @property
    def ticks(self) -> dict[float, str]:
        """Labels of a color bar by their places from 0 to 1."""
        return {part: f"{part**2 * self.top:g}" for part in (0.0, 0.25, 0.5, 0.75, 1.0)}

    def colored(self, errors: Image) -> Image:
        """Return the colors of errors, shape (h, w), as sRGB of shape (h, w, 3)."""
        return magma(np.sqrt(np.clip(errors / np.float32(self.top), 0, 1)))


def scale_of(cells: Iterable[Record], truth: str, metric: str) -> MapScale:
    """Return the scale for maps of cells against a truth."""
    errors = [cell.metric(truth, metric) or 0.0 for cell in cells]
    wanted = _BRIGHTER * max(errors, default=0.0)
    return MapScale(next((top for top in _TOPS if top >= wanted), 1.0))


def magma(errors: Image) -> Image:
    """Return the colors of errors in [0, 1], shape (h, w): black to pale yellow."""
    import matplotlib

    colors: Image = matplotlib.colormaps["magma"](np.clip(errors, 0, 1))[..., :3].astype(np.float32)
    return colors

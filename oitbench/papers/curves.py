"""Visibility curves at a pixel of a figure's scene, chosen by its layers."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from oitbench.measure.pixel import measure
from oitbench.papers.album import Album
from oitbench.papers.picture import Picture
from oitbench.results.schema import TRANSMITTANCE

if TYPE_CHECKING:
    from oitbench.measure.visibility import Curves

_CLEAR = 0.15
"""Total transmittance that a pixel should have, so that its whole curve can be seen."""


def pixel_with(album: Album, picture: Picture, least: float, most: float) -> tuple[int, int] | None:
    """Return the column and row of a pixel with so many fragments; None if there is none.

    Parameters
    ----------
    album : Album
    picture : Picture
        Whose cell has the counts. If it shows a part, the pixel is inside of that.
    least, most : float
        Fragments, relative to the largest number at a pixel if at most 1.
    """
    record = album.record(picture)
    results = album.context.results
    counts = results.complexity(record) if record else None
    light = results.image(record, TRANSMITTANCE) if record else None
    if counts is None or light is None or counts.shape != light.shape[:2]:
        return None
    low, high = (bound * counts.max() if bound <= 1 else bound for bound in (least, most))
    fits = (counts >= low) & (counts <= high) & _inside(album, picture, counts.shape)
    if not fits.any():
        return None
    apart = np.where(fits, np.abs(light.mean(axis=2) - _CLEAR), np.inf)
    row, column = np.unravel_index(np.argmin(apart), apart.shape)
    return int(column), int(row)


def _inside(album: Album, picture: Picture, shape: tuple[int, ...]) -> npt.NDArray[np.bool_]:
    """Return which pixels of a picture of a shape belong to the part that is shown."""
    if not picture.crop:
        return np.ones(shape, bool)
    left, top, width, height = album.crop(picture, picture.crop)
    rows, columns = ((np.arange(count) + 0.5) / count for count in shape)
    tall, wide = (
        abs(rows - top - height / 2) < height / 2,
        abs(columns - left - width / 2) < width / 2,
    )
    return np.asarray(tall[:, None] & wide)


def curves_at(
    album: Album, picture: Picture, pixel: tuple[int, int], methods: Sequence[str]
) -> Curves:
    """Return the visibility of methods at a pixel of the scene of a picture's cell."""
    record = album.record(picture)
    assert record is not None
    return measure(record.scene, pixel, methods, record.size)

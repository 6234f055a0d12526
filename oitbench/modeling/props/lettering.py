"""Letters of flat strokes."""

from __future__ import annotations

import itertools

import numpy as np

from oitbench.modeling.mesh import grid
from oitbench.modeling.placement import merge, transform, translation
from oitbench.scene import Floats, Mesh, Vector

GLYPHS: dict[str, tuple[tuple[tuple[float, float], ...], ...]] = {
    "A": (((0, 0), (0.5, 2), (1, 0)), ((0.2, 0.75), (0.8, 0.75))),
    "E": (((1, 0), (0, 0), (0, 2), (1, 2)), ((0, 1), (0.8, 1))),
    "I": (((0.5, 0), (0.5, 2)),),
    "P": (((0, 0), (0, 2), (0.7, 2), (1, 1.7), (1, 1.3), (0.7, 1), (0, 1)),),
    "R": (((0, 0), (0, 2), (0.7, 2), (1, 1.7), (1, 1.3), (0.7, 1), (0, 1)), ((0.5, 1), (1, 0))),
    "T": (((0.5, 0), (0.5, 2)), ((0, 2), (1, 2))),
    "V": (((0, 2), (0.5, 0), (1, 2)),),
    "Y": (((0, 2), (0.5, 1), (1, 2)), ((0.5, 1), (0.5, 0))),
}
"""Strokes (x, y) of each letter along the middle of the pen, in a cell one wide and two high."""
LETTER_PITCH = 1.6
"""Distance between the left edges of successive letters, in widths of a letter."""


def lettering(text: str, center: Vector, height: float, pen: float) -> Mesh:
    """Return a line of text that faces +z and reads along +x.

    Parameters
    ----------
    text : str
        Letters of `GLYPHS`, and blanks.
    center : Vector
        Middle of the line of text, meters.
    height : float
        Height of the letters, meters.
    pen : float
        Width of the strokes, meters.

    Raises
    ------
    ValueError
        If a letter has no glyph.
    """
    missing = sorted(set(text) - set(GLYPHS) - {" "})
    if missing:
        raise ValueError(f"lettering: no glyph for {' '.join(missing)}; add it to GLYPHS")
    scale = (height - pen) / 2
    left = -scale * (LETTER_PITCH * (len(text) - 1) + 1) / 2
    strokes: list[Mesh] = []
    for place, letter in enumerate(text):
        origin = np.array([left + scale * LETTER_PITCH * place, -scale])
        for line in GLYPHS.get(letter, ()):
            strokes += _strokes(origin + scale * np.asarray(line), pen)
    return transform(merge(strokes), translation(center))


def _strokes(line: Floats, pen: float) -> list[Mesh]:
    """Return a rectangle for each edge of `line`; it is half a pen width longer at both ends."""
    meshes = []
    for start, end in itertools.pairwise(line):
        along = (end - start) / np.linalg.norm(end - start)
        reach = np.linalg.norm(end - start) / 2 + pen / 2
        x, y = (start + end) / 2
        right = (float(reach * along[0]), float(reach * along[1]), 0.0)
        up = (float(-pen / 2 * along[1]), float(pen / 2 * along[0]), 0.0)
        meshes.append(grid((float(x), float(y), 0.0), right, up))
    return meshes

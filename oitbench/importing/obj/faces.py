"""Faces of a Wavefront file: indices of positions, coordinates and normals of their corners."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

from oitbench.errors import SceneError
from oitbench.importing.limits import short
from oitbench.importing.shapes import Indices

_MISSING = 0


@dataclass
class Run:
    """Lines of faces that follow each other.

    Parameters
    ----------
    before : tuple of int
        Positions, coordinates and normals that come before; negative indices count from there.
    smooth : int
        Number of the smoothing group; 0 for flat faces.
    faces : list of str
    """

    before: tuple[int, int, int]
    smooth: int
    faces: list[str] = field(default_factory=list)


def corners_of(run: Run, counts: tuple[int, int, int]) -> Iterator[Indices]:
    """Yield the corners of faces with equally many of them, shape (m, corners, 3).

    Each corner has the indices of its position, coordinates and normal from 0; −1 for none.

    Raises
    ------
    SceneError
        A face is damaged, or uses something that does not exist.
    """
    words = [face.split() for face in run.faces]
    lengths = np.array([len(face) for face in words])
    for length in np.unique(lengths).tolist():
        if length == 0:
            continue
        chosen = [face for face in words if len(face) == length]
        yield _indices(chosen, run.before, counts).reshape(len(chosen), length, 3)


def _indices(
    faces: list[list[str]], before: tuple[int, int, int], counts: tuple[int, int, int]
) -> Indices:
    written = _written(faces)
    found = np.where(written < 0, written + np.array(before), written - 1)
    found[written == _MISSING] = -1
    wrong = (found < 0) & (written != _MISSING) | (found >= np.array(counts))
    if wrong.any() or (written[:, 0] == _MISSING).any():
        row, column = np.argwhere(wrong)[0] if wrong.any() else (0, 0)
        kind = ("v", "vt", "vn")[column]
        raise SceneError(
            f"a face uses '{kind}' {written[row, column]} of {counts[column]}; export it again"
        )
    return found


def _written(faces: list[list[str]]) -> Indices:
    """Return the indices as they are written, shape (corners of all, 3); 0 where there is none."""
    words = [word for face in faces for word in face]
    text = " ".join(words)
    slashes = text.count("/")
    try:
        if slashes == 0:
            single = np.array(words, dtype=np.int64)
            return np.stack([single, *np.zeros((2, len(words)), np.int64)], axis=1)
        if slashes == 2 * len(words):
            # In the form 1//2, coordinates are missing.
            parts = text.replace("//", "/0/").replace("/", " ").split()
            if len(parts) == 3 * len(words):
                return np.array(parts, dtype=np.int64).reshape(-1, 3)
        return np.array([_one(word) for word in words], dtype=np.int64)
    except (ValueError, OverflowError):
        raise SceneError(f"a face cannot be read: f {short(text[:60])}") from None


def _one(word: str) -> list[int]:
    parts = [int(part) if part else _MISSING for part in word.split("/")]
    if len(parts) > 3:
        raise ValueError(word)
    return [*parts, _MISSING, _MISSING][:3]

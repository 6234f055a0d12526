"""Textures of sprays: twigs with many leaves on one card, ferns and grass.

A texture is painted leaf by leaf on subsamples that are covered or not, and averaged.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from oitbench.modeling.props.leaves import Shape, lance, ovate
from oitbench.scene import RGB, Floats, Texture

SIDE = 256
"""Texels along a side."""
BORDER = 6
"""Empty texels along each edge."""
SHOOTS = 9
"""Shoots on the sides of a twig."""
_SUBSAMPLES = 3


@dataclass(frozen=True, eq=False)
class Spray:
    """A card's textures.

    Parameters
    ----------
    coverage : Texture
    color : Texture
        Factor on the light that leaves the card.
    """

    coverage: Texture
    color: Texture


class _Canvas:
    """Subsamples of a picture over x and y in [−1, 1], with y up."""

    def __init__(self) -> None:
        self.samples = SIDE * _SUBSAMPLES
        self.covered = np.zeros((self.samples, self.samples), dtype=bool)
        self.color = np.zeros((self.samples, self.samples, 3))
        self._edge = 1 / (1 - 2 * BORDER / SIDE)

    def leaf(
        self, shape: Shape, foot: Floats, angle: float, size: tuple[float, float], color: Floats
    ) -> None:
        """Paint a leaf that grows from `foot` at `angle` from straight up, over earlier ones."""
        width, length = size
        toward = np.array([math.sin(angle), math.cos(angle)])
        middle = foot + length * toward
        rows, columns, x, y = self._window(middle, math.hypot(width, length))
        if not x.size:
            return
        u = ((x - middle[0]) * toward[1] - (y - middle[1]) * toward[0]) / width
        v = ((x - middle[0]) * toward[0] + (y - middle[1]) * toward[1]) / length
        inside = (shape(u, v) > 0) & (np.maximum(np.abs(u), np.abs(v)) <= 1)
        rib = 1 - 0.22 * np.exp(-((u / 0.09) ** 2)) + 0.08 * np.sign(u)
        veins = 1 - 0.07 * np.cos(9 * (v + 0.7 * np.abs(u)) * math.pi)
        self._paint(rows, columns, inside, color * (rib * veins)[..., None])

    def stroke(self, start: Floats, end: Floats, width: float, color: Floats) -> None:
        """Paint a straight stalk."""
        middle, axis = (start + end) / 2, end - start
        length = float(np.linalg.norm(axis))
        rows, columns, x, y = self._window(middle, length / 2 + width)
        if not x.size:
            return
        along = ((x - middle[0]) * axis[0] + (y - middle[1]) * axis[1]) / length
        beside = ((x - middle[0]) * axis[1] - (y - middle[1]) * axis[0]) / length
        inside = (np.abs(along) < length / 2) & (np.abs(beside) < width / 2)
        self._paint(rows, columns, inside, np.broadcast_to(color, (*inside.shape, 3)))

    def spray(self) -> Spray:
        """Return the textures."""
        blocks = (SIDE, _SUBSAMPLES, SIDE, _SUBSAMPLES)
        coverage = self.covered.reshape(blocks).mean(axis=(1, 3))
        sums = (self.color * self.covered[..., None]).reshape(*blocks, 3).mean(axis=(1, 3))
        color = sums / np.maximum(coverage, 1e-6)[..., None]
        return Spray(Texture(coverage.astype(np.float32)), Texture(color.astype(np.float32)))

    def _window(self, middle: Floats, reach: float) -> tuple[slice, slice, Floats, Floats]:
        """Return the rows and columns around a point, and the places of their subsamples."""
        scale = self.samples / (2 * self._edge)
        column, row = (middle[0] + self._edge) * scale, (self._edge - middle[1]) * scale
        margin = BORDER * _SUBSAMPLES
        low, high = margin, self.samples - margin
        spans = [
            slice(*np.clip([int(at - reach * scale), int(at + reach * scale) + 2], low, high))
            for at in (row, column)
        ]
        line = (np.arange(self.samples) + 0.5) / scale - self._edge
        x, y = np.meshgrid(line[spans[1]], -line[spans[0]])
        return spans[0], spans[1], x, y

    def _paint(
        self, rows: slice, columns: slice, inside: npt.NDArray[np.bool_], color: Floats
    ) -> None:
        self.covered[rows, columns] |= inside
        self.color[rows, columns][inside] = color[inside]


def twig(
    random: np.random.Generator,
    leaves: int,
    size: tuple[float, float],
    wood: RGB = (0.35, 0.26, 0.19),
    shape: Shape = ovate,
) -> Spray:
    """Return a forked twig that grows upwards, with leaves on both sides.

    Parameters
    ----------
    random : Generator
    leaves : int
    size : (float, float)
        Half the width and half the length of a leaf, in halves of the card's side.
    """
    canvas = _Canvas()
    bark = np.asarray(wood)
    shoots = [(np.array([0.0, -0.98]), 0.0, 1.75)]
    for index in range(SHOOTS):
        side = 1 if index % 2 else -1
        at = -0.80 + 1.35 * (index + random.random()) / SHOOTS
        foot = np.array([0.06 * math.sin(3 * at), at])
        shoots.append(
            (foot, side * random.uniform(0.6, 1.1), random.uniform(0.75, 1.0) * (1.05 - 0.4 * at))
        )
    spots = []
    for foot, angle, length in shoots:
        bend = random.uniform(-0.25, 0.25)
        place, step = foot, length / 8
        for index in range(8):
            turn = angle + bend * index / 8
            ahead = place + step * np.array([math.sin(turn), math.cos(turn)])
            canvas.stroke(place, ahead, 0.022 * (1 - index / 10), bark)
            spots.append((ahead, turn))
            place = ahead
    for index in range(leaves):
        place, turn = spots[random.integers(len(spots))]
        angle = turn + (1 if index % 2 else -1) * random.uniform(0.4, 1.25)
        scale = random.uniform(0.7, 1.15)
        shade = random.uniform(0.72, 1.12) * np.array([1.0, 1.0, 1.0])
        shade[0] *= random.uniform(0.85, 1.25)
        canvas.leaf(shape, place, angle, (size[0] * scale, size[1] * scale), shade)
    return canvas.spray()


def frond(random: np.random.Generator, pairs: int = 22) -> Spray:
    """Return the frond of a fern: a stalk with pairs of slender, toothed leaves."""
    canvas = _Canvas()
    canvas.stroke(np.array([0, -0.97]), np.array([0, 0.95]), 0.035, np.array([0.6, 0.5, 0.3]))
    for index in range(pairs):
        at = -0.72 + 1.62 * index / pairs
        length = 0.44 * (1 - index / pairs) ** 0.8 * min(1.0, 0.45 + 3.5 * index / pairs)
        for side in (-1, 1):
            shade = random.uniform(0.8, 1.1) * np.ones(3)
            foot = np.array([0.0, at + 0.02 * side])
            angle = side * random.uniform(1.05, 1.2)
            canvas.leaf(lance, foot, angle, (0.045, length), shade)
    return canvas.spray()


def grass(random: np.random.Generator, blades: int = 26) -> Spray:
    """Return a tuft of grass."""
    canvas = _Canvas()
    for _ in range(blades):
        place = np.array([0.35 * random.normal(), -0.97])
        turn, bend = 0.25 * random.normal() + 0.5 * place[0], 0.22 * random.normal()
        length, shade = random.uniform(0.8, 1.75) / 7, random.uniform(0.7, 1.15)
        for index in range(7):
            turn += bend * index / 7
            ahead = place + length * np.array([math.sin(turn), math.cos(turn)])
            color = shade * np.array([1.0, 1.0, 0.8]) * (0.6 + 0.08 * index)
            canvas.stroke(place, ahead, 0.036 * (1 - index / 7.5), color)
            place = ahead
    return canvas.spray()

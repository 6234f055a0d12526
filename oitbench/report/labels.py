"""Labels beside their points, placed so that they cover no label, marker or line."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from oitbench.report.figures import QUIET

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Floats = npt.NDArray[np.float64]
"""Boxes are (..., 4): left, bottom, right, top. Segments are (..., 4): x0, y0, x1, y1.

Both are in typographic points, 1/72 inch.
"""

# Typographic points.
_FONT_SIZE = 7.0
_MARKER = 7.0
_DISTANCES = (5.0, 8.0, 12.0, 17.0, 23.0, 30.0, 38.0, 48.0, 60.0, 75.0, 92.0, 112.0, 135.0)
_DIRECTIONS = 24
_LEADER_FROM = 11.0
_PADDING = 1.0
_BAR = np.array([0.0, 2.0])
# Costs: of each square point of overlap, of each crossed line, and of each point of distance.
_OVERLAP = 3.0
_CROSSING = 40.0
_DISTANCE = 0.4


@dataclass(frozen=True)
class Label:
    """A text that belongs to the point (x, y) in data coordinates.

    `left` and `right` are the ends of the point's horizontal error bar, which labels avoid.
    """

    x: float
    y: float
    text: str
    color: str
    left: float
    right: float
    bold: bool = False


def place(
    axes: Axes,
    labels: Sequence[Label],
    *,
    lines: Sequence[tuple[Sequence[float], Sequence[float]]] = (),
) -> None:
    """Write `labels` into `axes`, whose limits must be final.

    Each label takes the nearest free place around its point; a distant one gets a thin leader line.

    Parameters
    ----------
    axes : Axes
        Their figure is laid out once, to find their position.
    labels : sequence of Label
        Earlier labels are placed first.
    lines : sequence of (xs, ys)
        Polylines in data coordinates that labels avoid.
    """
    figure = axes.get_figure(root=True)
    if figure is None:
        raise ValueError("the axes belong to no figure; labels need one")
    figure.draw_without_rendering()
    scale = 72 / figure.dpi

    def to_points(x: Sequence[float], y: Sequence[float]) -> Floats:
        return np.asarray(axes.transData.transform(np.column_stack([x, y])) * scale)

    frame = np.asarray(axes.get_window_extent().extents) * scale
    markers = to_points([label.x for label in labels], [label.y for label in labels])
    left = to_points([label.left for label in labels], [label.y for label in labels])
    right = to_points([label.right for label in labels], [label.y for label in labels])
    half = _MARKER / 2
    taken = np.concatenate(
        [
            np.column_stack([markers - half, markers + half]),
            np.column_stack([left - _BAR, right + _BAR]),
        ]
    )
    segments = np.concatenate([np.empty((0, 4)), *(_segments(to_points(*line)) for line in lines)])
    for number, label in enumerate(labels):
        own = (number, number + len(labels))
        box, leader = _best(
            markers[number], _text_size(axes, label, scale), frame, taken, segments, own
        )
        taken = np.concatenate([taken, box[None]])
        if leader is not None:
            segments = np.concatenate([segments, leader[None]])
        _write(axes, label, box / scale, None if leader is None else leader / scale)


def _text_size(axes: Axes, label: Label, scale: float) -> tuple[float, float]:
    text = axes.text(0, 0, label.text, **_font(label))
    extent = text.get_window_extent()
    text.remove()
    return extent.width * scale, extent.height * scale


def _font(label: Label) -> dict[str, Any]:
    return {"fontsize": _FONT_SIZE, "fontweight": "bold" if label.bold else "normal"}


def _segments(points: Floats) -> Floats:
    return np.column_stack([points[:-1], points[1:]])


def _candidates(point: Floats, width: float, height: float) -> tuple[Floats, Floats]:
    """Return distances (n,) and boxes (n, 4) around `point`, nearest and rightmost first."""
    steps = np.arange(_DIRECTIONS)
    # 0, 1, −1, 2, −2, … steps from the direction to the right.
    turns = (steps + 1) // 2 * np.where(steps % 2, 1, -1)
    angles = np.tile(2 * math.pi * turns / _DIRECTIONS, len(_DISTANCES))
    distances = np.repeat(_DISTANCES, _DIRECTIONS)
    along, up = np.cos(angles), np.sin(angles)
    left = point[0] + distances * along + (along - 1) / 2 * width
    bottom = point[1] + distances * up + (up - 1) / 2 * height
    return distances, np.column_stack([left, bottom, left + width, bottom + height])


def _best(
    point: Floats,
    extent: tuple[float, float],
    frame: Floats,
    taken: Floats,
    segments: Floats,
    own: Sequence[int],
) -> tuple[Floats, Floats | None]:
    """Return the box with the lowest cost, and the leader to it if it is distant.

    Parameters
    ----------
    point : array, shape (2,)
    extent : (float, float)
        Width and height of the text.
    frame : array, shape (4,)
        Box of the axes.
    taken : array, shape (n, 4)
        Boxes of markers, error bars and earlier labels.
    segments : array, shape (m, 4)
        Lines and earlier leaders.
    own : sequence of int
        Indices in `taken` of the point's own marker and error bar, which the leader may touch.
    """
    distances, boxes = _candidates(point, *extent)
    padded = boxes + np.array([-_PADDING, -_PADDING / 2, _PADDING, _PADDING / 2])
    ends = np.clip(point, boxes[:, :2], boxes[:, 2:])
    leaders = np.column_stack([np.broadcast_to(point, ends.shape), ends])
    far = distances > _LEADER_FROM
    others = np.delete(taken, list(own), axis=0)
    cost = _DISTANCE * distances
    cost += _OVERLAP * (np.prod(extent) - _overlap(boxes, frame[None])[:, 0])
    cost += _OVERLAP * _overlap(padded, taken).sum(axis=1)
    cost += _CROSSING * _meets(segments[None], padded[:, None]).sum(axis=1)
    cost += far * _CROSSING * _meets(leaders[:, None], others[None]).sum(axis=1)
    cost += far * _CROSSING * _cross(leaders[:, None], segments[None]).sum(axis=1)
    choice = int(np.argmin(cost))
    return boxes[choice], leaders[choice] if far[choice] else None


def _overlap(boxes: Floats, others: Floats) -> Floats:
    """Return the shared areas, (n, m), of boxes (n, 4) and others (m, 4)."""
    low = np.maximum(boxes[:, None, :2], others[None, :, :2])
    high = np.minimum(boxes[:, None, 2:], others[None, :, 2:])
    return np.asarray(np.prod(np.maximum(high - low, 0), axis=-1))


def _meets(segments: Floats, boxes: Floats) -> npt.NDArray[np.bool_]:
    """Return which segments pass through which boxes (slab test); both are broadcast."""
    start, step = segments[..., :2], segments[..., 2:] - segments[..., :2]
    # A tiny step instead of zero makes the quotients huge instead of NaN.
    step = np.where(np.abs(step) < 1e-9, 1e-9, step)
    one, two = (boxes[..., :2] - start) / step, (boxes[..., 2:] - start) / step
    enter = np.minimum(one, two).max(axis=-1)
    leave = np.maximum(one, two).min(axis=-1)
    return np.asarray(np.maximum(enter, 0) < np.minimum(leave, 1))


def _cross(ones: Floats, others: Floats) -> npt.NDArray[np.bool_]:
    """Return which segments cross each other; both are broadcast."""

    def side(segments: Floats, points: Floats) -> Floats:
        along, to = segments[..., 2:] - segments[..., :2], points - segments[..., :2]
        return np.asarray(along[..., 0] * to[..., 1] - along[..., 1] * to[..., 0])

    apart = side(ones, others[..., :2]) * side(ones, others[..., 2:]) < 0
    return np.asarray(apart & (side(others, ones[..., :2]) * side(others, ones[..., 2:]) < 0))


def _write(axes: Axes, label: Label, box: Floats, leader: Floats | None) -> None:
    """Write one label; `box` and `leader` are in pixels."""
    to_data = axes.transData.inverted()
    x, y = to_data.transform(box[:2])
    if leader is not None:
        end = to_data.transform(leader[2:])
        axes.plot([label.x, end[0]], [label.y, end[1]], color=QUIET, linewidth=0.5, zorder=2)
    text = axes.text(
        float(x),
        float(y),
        label.text,
        color=label.color,
        verticalalignment="bottom",
        zorder=6,
        **_font(label),
    )
    # The layout is final; another pass must not move the axes because of the labels.
    text.set_in_layout(False)

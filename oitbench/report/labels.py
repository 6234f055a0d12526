"""Labels beside their points, where none lies on another label, on a marker or on a line."""

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
"""Boxes are (..., 4): left, bottom, right, top. Segments are (..., 4): x0, y0, x1, y1. Points."""

_DISTANCES = (5.0, 8.0, 12.0, 17.0, 23.0, 30.0, 38.0, 48.0, 60.0, 75.0, 92.0, 112.0, 135.0)
_DIRECTIONS = 24
_LEADER_FROM = 11.0
_PADDING = 1.0
_BAR = np.array([0.0, 2.0])
# What it costs to lie on something per square point, across a line, and one point farther off.
_OVERLAP = 3.0
_CROSSING = 40.0
_DISTANCE = 0.4


@dataclass(frozen=True)
class Label:
    """A text that belongs to the point (x, y) in data coordinates.

    `left` and `right` are the ends of its horizontal error bar, which other labels keep clear of.
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
    size: float = 7.0,
    marker: float = 7.0,
) -> None:
    """Write `labels` into `axes`, whose limits must be final.

    Each takes the nearest free place round its point; those farther off get a thin leader.

    Parameters
    ----------
    axes : Axes
        The figure's layout is run once to learn where it lies.
    labels : sequence of Label
        Earlier ones choose first.
    lines : sequence of (xs, ys)
        Polylines in data coordinates to keep clear of.
    size, marker : float
        Font size and marker diameter in points.
    """
    figure = axes.get_figure(root=True)
    if figure is None:
        raise ValueError("labels need axes that belong to a figure")
    figure.draw_without_rendering()
    scale = 72 / figure.dpi

    def to_points(x: Sequence[float], y: Sequence[float]) -> Floats:
        return np.asarray(axes.transData.transform(np.column_stack([x, y])) * scale)

    frame = np.asarray(axes.get_window_extent().extents) * scale
    markers = to_points([label.x for label in labels], [label.y for label in labels])
    left = to_points([label.left for label in labels], [label.y for label in labels])
    right = to_points([label.right for label in labels], [label.y for label in labels])
    half = marker / 2
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
            markers[number], _text_size(axes, label, size, scale), frame, taken, segments, own
        )
        taken = np.concatenate([taken, box[None]])
        if leader is not None:
            segments = np.concatenate([segments, leader[None]])
        _write(axes, label, size, box / scale, None if leader is None else leader / scale)


def _text_size(axes: Axes, label: Label, size: float, scale: float) -> tuple[float, float]:
    text = axes.text(0, 0, label.text, **_font(label, size))
    extent = text.get_window_extent()
    text.remove()
    return extent.width * scale, extent.height * scale


def _font(label: Label, size: float) -> dict[str, Any]:
    return {"fontsize": size, "fontweight": "bold" if label.bold else "normal"}


def _segments(points: Floats) -> Floats:
    return np.column_stack([points[:-1], points[1:]])


def _candidates(point: Floats, width: float, height: float) -> tuple[Floats, Floats]:
    """Return distances (n,) and boxes (n, 4) round `point`, nearest and rightmost first."""
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
    """Return the cheapest box, and the leader to it if it is far."""
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
    """Return the shared areas of boxes (n, 4) and others (m, 4) as (n, m)."""
    low = np.maximum(boxes[:, None, :2], others[None, :, :2])
    high = np.minimum(boxes[:, None, 2:], others[None, :, 2:])
    return np.asarray(np.prod(np.maximum(high - low, 0), axis=-1))


def _meets(segments: Floats, boxes: Floats) -> npt.NDArray[np.bool_]:
    """Tell which segments pass through which boxes (slab test), broadcasting both."""
    start, step = segments[..., :2], segments[..., 2:] - segments[..., :2]
    # A vanishing step becomes tiny, so that the division gives ±huge instead of NaN.
    step = np.where(np.abs(step) < 1e-9, 1e-9, step)
    one, two = (boxes[..., :2] - start) / step, (boxes[..., 2:] - start) / step
    enter = np.minimum(one, two).max(axis=-1)
    leave = np.maximum(one, two).min(axis=-1)
    return np.asarray(np.maximum(enter, 0) < np.minimum(leave, 1))


def _cross(ones: Floats, others: Floats) -> npt.NDArray[np.bool_]:
    """Tell which segments cross each other, broadcasting both."""

    def side(segments: Floats, points: Floats) -> Floats:
        along, to = segments[..., 2:] - segments[..., :2], points - segments[..., :2]
        return np.asarray(along[..., 0] * to[..., 1] - along[..., 1] * to[..., 0])

    apart = side(ones, others[..., :2]) * side(ones, others[..., 2:]) < 0
    return np.asarray(apart & (side(others, ones[..., :2]) * side(others, ones[..., 2:]) < 0))


def _write(axes: Axes, label: Label, size: float, box: Floats, leader: Floats | None) -> None:
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
        **_font(label, size),
    )
    # The layout is done; a second pass must not move the axes under the labels.
    text.set_in_layout(False)

"""Methods with k nodes per pixel in double precision; only stored values are rounded."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from oitbench.scene import Floats, FragmentLists
from tests.models.commutative import layers_of

_EMPTY = float(np.finfo(np.float32).max)
_TIES = {"8-bit": (3, 2, 1, 0), "16f": (1, 0, 3, 2), "32f": (0, 1, 2, 3)}
"""Channels that order nodes of equal depth: those of the packed words, high bits first."""


def stored(color: Floats, node: str) -> Floats:
    """Return colors and opacities as a node of this format stores them."""
    if node == "8-bit":
        return np.asarray(np.rint(np.clip(color, 0, 1) * 255) / 255)
    kind = np.float16 if node == "16f" else np.float32
    return np.asarray(np.clip(color, 0, np.finfo(kind).max).astype(kind).astype(np.float64))


@dataclass
class Nodes:
    """Nodes of each pixel from near to far: depth (k, h, w), color and opacity (k, h, w, 4)."""

    depth: Floats
    color: Floats
    node: str

    def insert(self, depth: Floats, color: Floats) -> Floats:
        """Insert one node in each pixel; return the color that is removed, or zero."""
        for place in range(len(self.depth)):
            kept_depth, kept = self.depth[place].copy(), self.color[place].copy()
            before = self._before(depth, color, kept_depth, kept)
            self.depth[place] = np.where(before, depth, kept_depth)
            self.color[place] = np.where(before[..., None], color, kept)
            depth = np.where(before, kept_depth, depth)
            color = np.where(before[..., None], kept, color)
        return color

    def merge_into_last(self, behind: Floats) -> None:
        """Composite a color behind the last node."""
        last = self.color[-1]
        self.color[-1] = stored(last + (1 - last[..., 3:]) * behind, self.node)

    def _before(
        self, depth: Floats, color: Floats, other_depth: Floats, other: Floats
    ) -> npt.NDArray[np.bool_]:
        before = depth < other_depth
        equal = depth == other_depth
        for channel in _TIES[self.node]:
            before |= equal & (color[..., channel] < other[..., channel])
            equal &= color[..., channel] == other[..., channel]
        return np.asarray(before)

    def composite(self) -> Floats:
        """Return premultiplied color and opacity of all nodes."""
        total = np.zeros(self.color.shape[1:])
        for layer in self.color:
            total += (1 - total[..., 3:]) * layer
        return total


def gathered(
    lists: FragmentLists, k: int, node: str, merging: bool = False
) -> tuple[Nodes, list[Floats]]:
    """Insert all fragments in submission order; return the nodes, and the removed colors.

    With `merging`, removed colors are composited into the last node.
    """
    nodes = empty_nodes(lists, k, node)
    removed = []
    for depth, layer in zip(lists.z.astype(np.float64), stored_layers(lists, node), strict=True):
        # Layers that are clear go behind all nodes, also behind empty ones.
        removed.append(nodes.insert(np.where(layer.any(axis=-1), depth, np.inf), layer))
        if merging:
            nodes.merge_into_last(removed[-1])
    return nodes, removed


def empty_nodes(lists: FragmentLists, k: int, node: str) -> Nodes:
    """Return `k` empty nodes for each pixel of the lists."""
    shape = (k, *lists.z.shape[1:])
    return Nodes(np.full(shape, _EMPTY), np.zeros((*shape, 4)), node)


def stored_layers(lists: FragmentLists, node: str) -> Floats:
    """Return color and opacity of every fragment as a node of this format stores them."""
    color, opacity = layers_of(lists)
    return stored(np.concatenate([color, opacity[..., None]], axis=-1), node)


def _over(front: Floats, background: npt.ArrayLike) -> Floats:
    return np.asarray(front[..., :3] + (1 - front[..., 3:]) * np.asarray(background))


def k_buffer(lists: FragmentLists, background: npt.ArrayLike, k: int, node: str) -> Floats:
    """Return the k nearest layers over the background."""
    return _over(gathered(lists, k, node)[0].composite(), background)


def multilayer_alpha(lists: FragmentLists, background: npt.ArrayLike, k: int, node: str) -> Floats:
    """Return all layers, merged in submission order; Salvi & Vaidyanathan 2014."""
    return _over(gathered(lists, k, node, merging=True)[0].composite(), background)


def multilayer_alpha_buckets(
    lists: FragmentLists,
    background: npt.ArrayLike,
    k: int,
    node: str,
    lower: float = 0.2,
    opaque: float = 0.98,
) -> Floats:
    """Return layers before the first strong one as one node, merged layers after it; Kern 2020."""
    z, opacity = lists.z.astype(np.float64), layers_of(lists)[1]
    front = np.where(opacity > lower, z, np.inf).min(axis=0)
    hidden = np.where(opacity >= opaque, z, np.inf).min(axis=0)
    bucket, nodes = empty_nodes(lists, 1, node), empty_nodes(lists, k - 1, node)
    for depth, layer in zip(z, stored_layers(lists, node), strict=True):
        seen = layer.any(axis=-1) & (depth <= hidden)
        for part, chosen in ((bucket, seen & (depth < front)), (nodes, seen & (depth >= front))):
            own = np.where(chosen[..., None], layer, 0)
            part.merge_into_last(part.insert(np.where(chosen, depth, np.inf), own))
    first, behind = bucket.composite(), nodes.composite()
    return _over(first + (1 - first[..., 3:]) * behind, background)


def hybrid(
    lists: FragmentLists,
    background: npt.ArrayLike,
    k: int,
    node: str,
    transmittance: str = "mean",
    admission: float = 0.0,
) -> Floats:
    """Return the k nearest layers over the weighted average of all others; Maule et al. 2013."""
    opacity = layers_of(lists)[1]
    refused = opacity < admission
    admitted = replace(lists, coverage=np.where(refused, 0, lists.coverage))
    nodes, removed = gathered(admitted, k, node)
    faint = np.where(refused[..., None], stored_layers(lists, node), 0)
    tail_layers = np.stack(removed) + faint
    total = np.zeros(tail_layers.shape[1:])
    for layer in tail_layers:
        total = stored(total + layer, "16f")
    sum_ = total[..., 3]
    number = np.maximum((tail_layers[..., 3] > 0).sum(axis=0), 1)
    mean = 1 - (1 - sum_ / number) ** number
    covered = mean if transmittance == "mean" else 1 - (1 - tail_layers[..., 3]).prod(axis=0)
    factor = np.divide(covered, sum_, out=np.ones_like(sum_), where=sum_ > 1e-4)
    tail = np.concatenate([total[..., :3] * factor[..., None], covered[..., None]], axis=-1)
    core = nodes.composite()
    return _over(core + (1 - core[..., 3:]) * tail, background)

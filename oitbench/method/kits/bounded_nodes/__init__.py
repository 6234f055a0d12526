"""Targets of methods that keep at most k nodes a pixel."""

from __future__ import annotations

from collections.abc import Mapping

from oitbench.method.declaration import Target

EMPTY = 0x7F7FFFFF
"""Depth of a node that holds no fragment: the bits of the largest float."""
NODES: Mapping[str, int] = {"8-bit": 1, "16f": 2, "32f": 4}
"""Words of 32 bits that a node's color takes, by format: premultiplied color and net opacity."""
STEPS: Mapping[str, float] = {"8-bit": 1 / 255, "16f": 2.0**-11, "32f": 2.0**-24}
"""Distance of neighboring colors and opacities just below one, by format."""
_FORMATS = {1: "r32ui", 2: "rg32ui", 4: "rgba32ui"}


def node_targets(k: int, node: str) -> dict[str, Target]:
    """Return the targets of `k` nodes a pixel: one word of depth each, and the color's words.

    Parameters
    ----------
    k : int
        Nodes a pixel: 1, 2, or a multiple of 4.
    node : str
        Format of a node's color, a key of `NODES`.
    """
    return {**_words("depths", k, EMPTY), **_words("colors", k * NODES[node], 0)}


def _words(base: str, count: int, clear: int) -> dict[str, Target]:
    """Return numbered targets of `count` words in all, four to each unless there are fewer."""
    each = min(count, 4)
    return {f"{base}{i}": Target(_FORMATS[each], (clear,)) for i in range(count // each)}

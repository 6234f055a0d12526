"""At most k nodes per pixel, sorted by depth, in targets that a shader blends.

Shaders: `nodes.glsl` defines the layout of a node, `insert.glsl` inserts a fragment and returns the
node that no longer fits, `composite.glsl` composites the nodes, `resolve.glsl` shows them.
"""

from __future__ import annotations

from collections.abc import Mapping

from oitbench.effects import Effect
from oitbench.method.blending import OVER, PROGRAMMABLE
from oitbench.method.declaration import MSAA, Method, Plan, Request
from oitbench.method.passes import Gather, Resolve
from oitbench.method.storage import Target

EMPTY = 0x7F7FFFFF
"""Depth of a node without a fragment: the bits of the largest float."""
NODES: Mapping[str, int] = {"8-bit": 1, "16f": 2, "32f": 4}
"""Words of 32 bits in a node's premultiplied color and net opacity, by format."""
STEPS: Mapping[str, float] = {"8-bit": 1 / 255, "16f": 2.0**-11, "32f": 2.0**-24}
"""Distance of adjacent colors and opacities just below one, by format."""
_FORMATS = {1: "r32ui", 2: "rg32ui", 4: "rgba32ui"}


class BoundedNodes(Method):
    """Base of methods that insert fragments with `insert.glsl` and show the nodes.

    A subclass has the parameters `k`, the number of nodes per pixel, and `node`, the format of a
    node's color, a key of `NODES`.
    """

    expresses = Effect.COVERAGE
    msaa = MSAA
    k: int
    node: str

    @property
    def record_step(self) -> float:
        """The step of the node's format."""
        return STEPS[self.node]

    def plan(self, request: Request) -> Plan:
        """Return one gather pass into the nodes, and their resolve."""
        nodes = node_targets(self.k, self.node)
        wide = {"color": Target("rgba32f")} if self.node == "32f" else {}
        return Plan(
            targets={**nodes, **wide},
            passes=(
                Gather("insert.glsl", writes=dict.fromkeys(nodes, PROGRAMMABLE)),
                Resolve("bounded_nodes/resolve.glsl", reads=tuple(nodes), writes={"color": OVER}),
            ),
        )


def node_targets(k: int, node: str) -> dict[str, Target]:
    """Return the targets of `k` nodes per pixel: one word of depth each, and the color's words.

    Parameters
    ----------
    k : int
        Nodes per pixel: 1, 2, or a multiple of 4.
    node : str
        Format of a node's color, a key of `NODES`.
    """
    return {**_words("depths", k, EMPTY), **_words("colors", k * NODES[node], 0)}


def _words(base: str, count: int, clear: int) -> dict[str, Target]:
    """Return numbered targets of `count` words in total, four to each unless there are fewer."""
    each = min(count, 4)
    return {f"{base}{i}": Target(_FORMATS[each], (clear,)) for i in range(count // each)}

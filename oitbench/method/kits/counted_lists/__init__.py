"""Lists of the fragments at each pixel whose records follow each other in memory.

One pass over the geometry counts the fragments of each pixel, a pass over pixels allocates that
many records, and another pass over the geometry stores them. Shaders: `count.glsl`,
`allocate.glsl` and `capture.glsl`; records are those of `linked_lists/record.glsl`, with no link.

A list is [heads.x, heads.x + min(heads.y, stored)): a fragment beyond the counted ones is not
stored, so that no list reaches into the next one.

Sources: Vasilakis & Fudos 2012, "S-buffer: Sparsity-aware Multi-fragment Rendering"; Maule et al.
2014, "Memory-Optimized Order-Independent Transparency with Dynamic Fragment Buffer".
"""

from __future__ import annotations

from oitbench.method.blending import COUNT, REPLACE
from oitbench.method.kits.linked_lists import Lists, record_fields
from oitbench.method.passes import Gather, Resolve
from oitbench.method.storage import Buffer, Items, Target

_NODES = ("nodes",)
_TARGETS = {"heads": Target("rg32ui", single=True), "stored": Target("r32ui", single=True)}
_FILL = (
    Gather("counted_lists/count.glsl", writes={"stored": COUNT}),
    Resolve("counted_lists/allocate.glsl", ("stored",), {"heads": REPLACE}, _NODES),
    Gather("counted_lists/capture.glsl", ("heads",), {"stored": COUNT}, _NODES, clears=("stored",)),
)


def counted(node: str) -> Lists:
    """Return counted lists, in no particular order.

    The targets are the first record and the number of counted fragments of each pixel, `heads`, and
    the number of `stored` ones.

    Parameters
    ----------
    node : str
        "precise": depth, and α·L and τ as three floats each, 28 bytes. "compact": depth, and α·L
        with net opacity in RGBA8, 8 bytes.
    """
    return Lists({"nodes": Buffer(record_fields(node), Items.FRAGMENTS)}, _FILL, _TARGETS)

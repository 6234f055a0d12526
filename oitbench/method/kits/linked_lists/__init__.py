"""Linked lists of the fragments at each pixel.

Shaders: `capture.glsl` stores every fragment with its view distance, and `append.glsl` holds the
function for methods that store another depth; `reverse.glsl` reverses the lists; `record.glsl`
reads and writes records. With `msaa` above 1 the low four bits of a depth hold the coverage mask.

Sources: Yang et al. 2010, "Real-Time Concurrent Linked List Construction on the GPU"; Salvi et al.
2011, "Adaptive Transparency", section 4.2 for masks and the compact record.
"""

from __future__ import annotations

from oitbench.method.passes import Gather, Resolve
from oitbench.method.storage import Buffer, Items

_LINK = {"next": "uint", "depth": "float"}
RECORD_STEPS = {"precise": 0.0, "compact": 1 / 255}
"""`Method.record_step` by kind of record."""
LISTS = ("heads", "nodes")
"""Names of the buffers."""
CAPTURE = Gather("linked_lists/capture.glsl", buffers=LISTS)
"""Puts every fragment at the head of its pixel's list, so the last one submitted comes first."""
REVERSE = Resolve("linked_lists/reverse.glsl", buffers=LISTS)
"""Reverses every list, so the first fragment submitted comes first."""


def linked_lists(node: str, tinted: bool = False) -> dict[str, Buffer]:
    """Return the buffers: a head of 4 bytes per pixel and a record per fragment.

    Parameters
    ----------
    node : str
        "precise": next, depth, and α·L and τ as three floats each, 32 bytes. "compact": next,
        depth, and α·L with net opacity in RGBA8, 12 bytes.
    tinted : bool
        Whether a compact record also holds τ in RGBA8; it then has 16 bytes.
    """
    if node == "precise":
        fields = {**_LINK, "front": "vec4", "back": "vec2"}
    else:
        fields = {**_LINK, "color": "uint", **({"factor": "uint"} if tinted else {})}
    return {
        "heads": Buffer({"first": "uint"}, Items.PIXELS, clear=0xFFFFFFFF),
        "nodes": Buffer(fields, Items.FRAGMENTS),
    }

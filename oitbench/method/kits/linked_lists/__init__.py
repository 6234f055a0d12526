"""Linked lists of the fragments at each pixel.

Shaders: `capture.glsl` stores every fragment with its view distance, and `append.glsl` holds the
function for methods that store another depth; `reverse.glsl` reverses the lists; `record.glsl`
reads and writes records. With `msaa` above 1 the low four bits of a depth hold the coverage mask.

Sources: Yang et al. 2010, "Real-Time Concurrent Linked List Construction on the GPU"; Salvi et al.
2011, "Adaptive Transparency", section 4.2 for masks and the compact record.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from oitbench.method.passes import Gather, Resolve, Step
from oitbench.method.storage import Buffer, Items, Target

RECORD_STEPS = {"precise": 0.0, "compact": 1 / 255}
"""`Method.record_step` by kind of record."""
LISTS = ("heads", "nodes")
"""Names of the buffers."""
CAPTURE = Gather("linked_lists/capture.glsl", buffers=LISTS)
"""Puts every fragment at the head of its pixel's list, so the last one comes first.

On GPUs, fragments of a pixel arrive in any order; software renderers keep that of the draws.
"""
REVERSE = Resolve("linked_lists/reverse.glsl", buffers=LISTS)
"""Reverses every list, so the first fragment comes first."""


@dataclass(frozen=True)
class Lists:
    """All fragments of each pixel: the buffers and targets that hold them, and how they are filled.

    Parameters
    ----------
    buffers : mapping of str to Buffer
    fill : tuple of Step
    targets : mapping of str to Target
        Targets that passes over the lists read.
    """

    buffers: Mapping[str, Buffer]
    fill: tuple[Step, ...]
    targets: Mapping[str, Target] = field(default_factory=dict)


def linked(node: str) -> Lists:
    """Return linked lists in the order of arrival, the last fragment first."""
    return Lists(linked_lists(node), (CAPTURE,))


def record_fields(node: str, tinted: bool = False) -> dict[str, str]:
    """Return the fields of a record less its link, as `linked_lists` describes them."""
    if node == "precise":
        return {"depth": "float", "front": "vec4", "back": "vec2"}
    return {"depth": "float", "color": "uint", **({"factor": "uint"} if tinted else {})}


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
    fields = {"next": "uint", **record_fields(node, tinted)}
    return {
        "heads": Buffer({"first": "uint"}, Items.PIXELS, clear=0xFFFFFFFF),
        "nodes": Buffer(fields, Items.FRAGMENTS),
    }

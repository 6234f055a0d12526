"""Lists of fragments at each pixel, as several methods declare them.

Shaders come with them: `capture.glsl` keeps every fragment by its view distance, and
`list_capture.glsl` has its parts; `reverse.glsl` turns lists round; `list_record.glsl` reads and
writes records.
A method with a parameter `msaa` above 1 keeps coverage masks in the depths' low four bits.

Sources: Yang et al. 2010, "Real-Time Concurrent Linked List Construction on the GPU"; Salvi et al.
2011, "Adaptive Transparency", section 4.2 for masks and the compact record.
"""

from __future__ import annotations

from oitbench.method.declaration import Buffer, Draws, Items, Pass

_LINK = {"next": "uint", "depth": "float"}
RECORD_STEPS = {"precise": 0.0, "compact": 1 / 255}
"""`Method.record_step` by kind of record."""
LISTS = ("heads", "nodes")
"""The buffers, by name."""
CAPTURE = Pass("capture.glsl", Draws.FRAGMENTS, buffers=LISTS)
"""Puts every fragment at the head of its pixel's list: the last one submitted comes first."""
REVERSE = Pass("reverse.glsl", Draws.PIXELS, buffers=LISTS)
"""Turns every list round: the first fragment submitted comes first."""


def linked_lists(node: str, tinted: bool = False) -> dict[str, Buffer]:
    """Return a head a pixel, 4 bytes, and a record a fragment.

    Parameters
    ----------
    node : str
        "precise": next, depth, and alpha L and tau as three floats each, 32 bytes. "compact": next,
        depth, and alpha L with net opacity in RGBA8, 12 bytes.
    tinted : bool
        Whether a compact record also has tau in RGBA8, then 16 bytes.
    """
    if node == "precise":
        fields = {**_LINK, "front": "vec4", "back": "vec2"}
    else:
        fields = {**_LINK, "color": "uint", **({"factor": "uint"} if tinted else {})}
    return {
        "heads": Buffer({"first": "uint"}, Items.PIXELS, clear=0xFFFFFFFF),
        "nodes": Buffer(fields, Items.FRAGMENTS),
    }

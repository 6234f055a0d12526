"""A visibility curve and its nodes: the light that reaches the eye from each depth of a pixel.

A node, a dot, holds the depth of a fragment and the visibility behind it. The curve is that of a
pixel of random layers, measured and not sketched as in the paper.
"""

import numpy as np

from oitbench.papers import Album, Picture, caption, curves, needs_of
from oitbench.report import Artifact, Note, ReportContext, figures
from oitbench.report.visibility import steps

title = "Nodes of a visibility curve"

FRAGMENTS = 7
PICTURE = Picture(f"fragment_lists[layers={FRAGMENTS},alpha_high=0.5]", "a_buffer")
needs = needs_of([PICTURE])


def build(context: ReportContext) -> list[Artifact]:
    """Draw the exact curve of one pixel."""
    album = Album(context, needs)
    pixel = curves.pixel_with(album, PICTURE, FRAGMENTS, FRAGMENTS)
    if pixel is None:
        return [Note(f"No pixel of {PICTURE.scene} in these results has {FRAGMENTS} fragments.")]
    found = curves.curves_at(album, PICTURE, pixel, [PICTURE.method])
    z = found.fragments.z[:, 0, 0].astype(np.float64)
    with figures.canvas(4.6, 2.6) as canvas:
        axes = canvas.subplots()
        axes.step(*steps(z, found.exact), where="pre", color="#444444", linewidth=1.6)
        axes.plot(
            z,
            found.exact[1:].mean(axis=1),
            "o",
            color="#D7301F",
            markersize=5,
            clip_on=False,
            zorder=3,
        )
        axes.set(xlabel="view distance, m", ylabel="visibility", ylim=(0, 1.05))
        where = "Exact curve at the pixel {}, {} of {} × {}".format(*pixel, *found.size)
        text = caption(album, f"{where}, counted from the upper left.")
        path = context.out / "at_figure03"
        return [figures.save(canvas, path, title=title, caption=text)]

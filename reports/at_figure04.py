"""A curve with fewer nodes than fragments: an overestimate, or an underestimate, of the exact one.

Without a node, the curve is too high up to the next one. The other way also lowers the node before,
so that the curve is too low instead, and exact again behind. Both are measured at a pixel of random
layers, of which four nodes remain.
"""

import numpy as np

from oitbench.papers import Album, Finding, Picture, caption, curves, needs_of
from oitbench.report import Artifact, Note, ReportContext, figures
from oitbench.report.visibility import steps

title = "Removed nodes: underestimate and overestimate"

FRAGMENTS = 7
PICTURE = Picture(f"fragment_lists[layers={FRAGMENTS},alpha_high=0.5]", "a_buffer")
needs = needs_of([PICTURE])
UNDER = "adaptive[nodes=4,node=precise]"
OVER = "adaptive[nodes=4,removal=over,node=precise]"
ROUNDING = 1e-3


def build(context: ReportContext) -> list[Artifact]:
    """Draw the exact curve and both approximations of one pixel."""
    album = Album(context, needs)
    pixel = curves.pixel_with(album, PICTURE, FRAGMENTS, FRAGMENTS)
    if pixel is None:
        return [Note(f"No pixel of {PICTURE.scene} in these results has {FRAGMENTS} fragments.")]
    found = curves.curves_at(album, PICTURE, pixel, [UNDER, OVER])
    z = found.fragments.z[:, 0, 0].astype(np.float64)
    # The colors of the paper.
    lines = (
        ("overestimate", found.methods[OVER], "#2C7BB6", "--"),
        ("exact", found.exact, "#D7301F", "-"),
        ("underestimate", found.methods[UNDER], "#E6842A", ":"),
    )
    with figures.canvas(4.6, 2.6) as canvas:
        axes = canvas.subplots()
        for label, values, color, line in lines:
            axes.step(
                *steps(z, values), where="pre", color=color, linestyle=line, linewidth=1.8,
                label=label,
            )  # fmt: skip
        axes.set(xlabel="view distance, m", ylabel="visibility", ylim=(0, 1.05))
        axes.legend()
        where = "Curves at the pixel {}, {} of {} × {}".format(*pixel, *found.size)
        apart = [found.methods[label] - found.exact for label in (UNDER, OVER)]
        said = (
            Finding("the underestimate is nowhere too high", bool(np.all(apart[0] < ROUNDING))),
            Finding("the overestimate is nowhere too low", bool(np.all(apart[1] > -ROUNDING))),
            Finding(
                "the total transmittance of the underestimate is exact",
                bool(np.all(np.abs(apart[0][-1]) < ROUNDING)),
            ),
        )
        text = caption(album, f"{where}, counted from the upper left.", said)
        path = context.out / "at_figure04"
        return [figures.save(canvas, path, title=title, caption=text)]

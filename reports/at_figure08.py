"""Visibility at one pixel of the smoke by four methods, over the exact curve in gray.

Colors of fragments are stored as floats here, so that they do not change the curves. Stochastic
transparency shows its mean over random numbers; its error includes the noise of a single pixel.
"""

from dataclasses import replace
from pathlib import Path

import numpy as np

from oitbench.papers import Album, Finding, caption, curves, needs_of, read_paper
from oitbench.report import Artifact, Note, ReportContext, visibility

title = "Visibility curves of four methods"

PAPER = read_paper(Path(__file__).parent / "papers" / "at2011.toml")
PICTURE = PAPER.picture("SMOKE", "A-buffer").part("fence")
needs = needs_of([PICTURE])
METHODS = {
    "AT": PAPER.picture("SMOKE", "AT, floats").method,
    "ST": PAPER.picture("SMOKE", "ST").method,
    "OSMT": "opacity_map[node=precise]",
    "FOMT": "fourier_map[node=precise]",
}


def build(context: ReportContext) -> list[Artifact]:
    """Draw a panel for each method, and say which curve is nearest to the exact one."""
    album = Album(context, needs)
    pixel = curves.pixel_with(album, PICTURE, 0.5, 1)
    if pixel is None:
        return [Note(f"There are no counts of fragments of {PICTURE.scene} in these results.")]
    found = curves.curves_at(album, PICTURE, pixel, list(METHODS.values()))
    errors = {
        name: float(np.sqrt(np.nanmean((curve - found.exact) ** 2 + found.spread(label) ** 2)))
        for name, label in METHODS.items()
        if (curve := found.methods.get(label)) is not None
    }
    numbers = ", ".join(f"{name} {error:.4f}" for name, error in errors.items())
    text = f"the curve of AT is nearest to the exact one (RMS error {numbers})"
    said = Finding(text, min(errors, key=errors.__getitem__) == "AT" if errors else None)
    drawn = visibility.write(found, context.out, "at_figure08")
    return [replace(drawn, title=title, caption=caption(album, f"{drawn.caption}.", [said]))]

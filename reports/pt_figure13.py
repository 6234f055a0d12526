"""Uniform fog in a court, by one pass that marches through it, and in closed form.

Under even light from all sides, fog has a closed form: a surface at distance s fades by exp(−σs),
and the fog's own light takes the place of what fades. The traced picture is that closed form.
"""

from dataclasses import replace

from oitbench.papers import Album, Picture, Row, caption, faithful, needs_of, plate, unlike
from oitbench.report import Artifact, ReportContext
from oitbench.truths import MATCHED

title = "Uniform fog"

CLEAR = Picture("atrium_fog", "phenomenological", "No fog", effects="-volume")
OURS = Picture("atrium_fog", "phenomenological", "Phenomenological")
CLOSED = replace(OURS.traced, label="Closed form, traced")
ROWS = (
    Row((CLEAR, OURS, CLOSED)),
    Row((*(replace(picture, label="") for picture in (CLEAR, OURS)), None), against=CLOSED),
)
needs = needs_of((CLEAR, OURS, CLOSED))


def build(context: ReportContext) -> list[Artifact]:
    """Draw the court without fog and with it, and the differences from the closed form."""
    album = Album(context, needs)
    said = (
        faithful(album, OURS, MATCHED, "the march looks like the closed form"),
        unlike(album, OURS, CLEAR, "the fog is plain to see"),
    )
    text = caption(album, "Differences are from the closed form.", said)
    return [plate(album, ROWS, "pt_figure13", title=title, caption=text)]

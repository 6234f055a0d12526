"""An engine as CAD programs show it, from two sides: many close layers of partial coverage.

The paper shows phenomenological transparency alone, and says that its weights, which fall with
distance, tell front from back. The mean of all layers, which ignores distance, shows what the
weights add, and exact compositing what they lack. Weights also grow with the cube of opacity, so
that dense parts shine through pale ones.
"""

from oitbench.papers import Album, Picture, Row, caption, nearer, needs_of, plate
from oitbench.report import Artifact, ReportContext
from oitbench.truths import EXACT

title = "An engine of many close layers"

VIEWS = {"main": "From the front", "rear": "From the rear"}
OURS = [Picture("engine", "phenomenological", label, view=view) for view, label in VIEWS.items()]
AVERAGED = [Picture("engine", "weighted_average", view=view) for view in VIEWS]
IDEAL = [Picture("engine", "phenomenological", view=view, truth=EXACT) for view in VIEWS]
ROWS = (
    Row(OURS, "phenomenological", score=EXACT),
    Row(AVERAGED, "weighted average", score=EXACT),
    Row(IDEAL, "exact compositing"),
)
needs = needs_of(OURS + AVERAGED)


def build(context: ReportContext) -> list[Artifact]:
    """Draw both views by two methods and by exact compositing."""
    album = Album(context, needs)
    said = [
        nearer(
            album, ours, (averaged,), EXACT,
            f"weights by distance are better than the mean of all layers {ours.label.lower()}",
        )
        for ours, averaged in zip(OURS, AVERAGED, strict=True)
    ]  # fmt: skip
    text = caption(album, "FLIP is against exact compositing.", said)
    return [plate(album, ROWS, "pt_figure20", title=title, caption=text)]

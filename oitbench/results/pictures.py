"""The pictures of a cell: truths may be compared with one that is smaller."""

from __future__ import annotations

from oitbench.results.schema import Outcome

PICTURE = "color"
"""Key of `Outcome.images` for the picture of the method."""
REDUCED = "color_reduced"
"""Key of `Outcome.images` for the same picture at the size of traced truths, if that is smaller."""
REDUCED_EXACT = "exact_reduced"
"""Key of `Outcome.images` for exact compositing at that size."""


def compared(outcome: Outcome, truth: str) -> str:
    """Return the key of the picture that is compared with a truth."""
    traced = truth in outcome.scores and outcome.scores[truth].reference is not None
    return REDUCED if traced and REDUCED in outcome.images else PICTURE

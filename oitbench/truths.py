"""The truths that pictures are compared with, a ladder, and the one that ranks methods."""

from __future__ import annotations

from collections.abc import Mapping

from oitbench.effects import SHADING, Effect

EXACT, MATCHED, FULL = "exact", "matched", "full"
TRUTHS: Mapping[str, str] = {
    EXACT: "exact compositing",
    MATCHED: "matched tracing",
    FULL: "full path tracing",
}
"""Keys of the truths in a record, and their names for readers."""
TRACED = (MATCHED, FULL)
"""The truths that are stored as references."""
COMPOSITING_ONLY = "compositing only"
"""Label of errors against exact compositing in scenes that it does not rank."""

_COMPOSITED = Effect.COVERAGE | Effect.COLORED_TRANSMISSION
"""Effects of compositing. Those of shading are the same for all methods."""


def ranking_truth(effects: Effect) -> str:
    """Return the truth that ranks all methods of a scene under the effects that are requested.

    It is exact compositing if all effects are compositing or shared shading, and matched tracing
    if any of them, such as refraction, is beyond exact compositing. Full path tracing ranks
    nothing: its difference is mostly that of the shading.
    """
    return MATCHED if effects & ~(_COMPOSITED | SHADING) else EXACT


def traced_effects(requested: Effect, chosen: Effect) -> Effect:
    """Return the effects that run in a matched picture: coverage always does.

    Parameters
    ----------
    requested, chosen : Effect
        Of the scene, and those of them that are not left out.
    """
    return requested & (chosen | Effect.COVERAGE)

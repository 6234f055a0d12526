"""Effects left out one at a time, to measure the cost and the gain of each."""

from __future__ import annotations

from collections.abc import Iterator

from oitbench.effects import SHADING, Effect
from oitbench.method.declaration import Method, Request, plan_of

REQUESTED = "requested"
"""On the axis of effects: all effects that the scene requests."""
EACH = "each"
"""On the axis of effects: all requested effects, then all but one, for each one in turn."""

NEEDS = {
    Effect.TRANSLUCENT_SHADOWS: Effect.SHADOWS,
    Effect.COLORED_SHADOWS: Effect.TRANSLUCENT_SHADOWS,
    Effect.CAUSTICS: Effect.TRANSLUCENT_SHADOWS,
    Effect.INFERRED_AO: Effect.AMBIENT_OCCLUSION,
}
"""Effects that are meaningless without another one. Variance maps of translucent shadows need the
map of opaque receivers."""


def leave_out(effects: Effect, removed: Effect) -> Effect:
    """Return `effects` without `removed` and without the effects that depend on them."""
    # NEEDS lists an effect before those that depend on it, so one round is enough.
    for effect, needed in NEEDS.items():
        if needed & removed:
            removed |= effect
    return effects & ~removed


def effects_axis(requested: Effect, method: Method) -> Iterator[str]:
    """Yield "requested", then "-name" for each requested effect that changes the method's picture.

    Coverage is never left out, since there is no transparency without it.
    """
    yield REQUESTED
    for effect in Effect:
        if effect & requested & method.shows & ~Effect.COVERAGE and _matters(
            method, requested, effect
        ):
            yield f"-{str(effect.name).lower()}"


def _matters(method: Method, requested: Effect, effect: Effect) -> bool:
    """Return whether anything that `method` draws depends on `effect`."""
    if effect & SHADING:
        return True
    running = requested & method.shows
    plans = [
        plan_of(method, Request(effects, particles=True))
        for effects in (running, running & ~effect)
    ]
    if plans[0] != plans[1]:
        return True
    shaders = (path for folder in method.folders for path in folder.glob("*.glsl"))
    return any(f"EFFECT_{effect.name}" in path.read_text(encoding="utf-8") for path in shaders)

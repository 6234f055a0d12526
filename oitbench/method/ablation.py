"""What can be left out of a picture, one effect at a time, to see what each costs and gains."""

from __future__ import annotations

from collections.abc import Iterator

from oitbench.effects import SHADING, Effect
from oitbench.gl.draws.steps import passes_of
from oitbench.method.declaration import Method
from oitbench.plugins import folder_of

EACH = "each"
"""On the axis of effects: all that are called for, then all but one, for every one in turn."""

NEEDS = {
    Effect.TRANSLUCENT_SHADOWS: Effect.SHADOWS,
    Effect.COLORED_SHADOWS: Effect.TRANSLUCENT_SHADOWS,
    Effect.CAUSTICS: Effect.TRANSLUCENT_SHADOWS,
    Effect.INFERRED_AO: Effect.AMBIENT_OCCLUSION,
}
"""Effects that mean nothing without another one. Variance maps of translucent shadows need to know
where opaque surfaces receive them."""


def leave_out(effects: Effect, left: Effect) -> Effect:
    """Return `effects` without `left`, and without what means nothing without it."""
    # From what others need to what needs them, so that one round does.
    for effect, needed in NEEDS.items():
        if needed & left:
            left |= effect
    return effects & ~left


def variants(called: Effect, method: Method) -> Iterator[str]:
    """Yield "called", then "-name" for every called effect without which `method` draws otherwise.

    Coverage is never left out: without it there is no transparency.
    """
    yield "called"
    for effect in Effect:
        if effect & called & method.shows & ~Effect.COVERAGE and _answers(method, effect):
            yield f"-{str(effect.name).lower()}"


def _answers(method: Method, effect: Effect) -> bool:
    """Tell whether anything that `method` draws depends on whether `effect` runs."""
    if effect & SHADING:
        return True
    declared = [item.when for step in method.passes for item in passes_of(step)]
    declared += [buffer.when for buffer in method.buffers.values()]
    for target in method.targets.values():
        declared += [target.when, *target.instead]
    if any(effect & when for when in declared):
        return True
    shaders = folder_of(type(method)).glob("*.glsl")
    return any(f"EFFECT_{effect.name}" in path.read_text(encoding="utf-8") for path in shaders)

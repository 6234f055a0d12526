"""The scenes and variants to which the contract applies, with the effects that they request."""

from __future__ import annotations

from oitbench.effects import Effect
from oitbench.scene import Scene
from tests.scenes.helpers import COLLECTION, build, with_detail

SMALL, FULL = 0.1, 1.0
"""Values of the parameter `detail`."""
SHADOWED = Effect.SHADOWS | Effect.TRANSLUCENT_SHADOWS
GRAY = Effect.COVERAGE
COLORED = GRAY | Effect.COLORED_TRANSMISSION
COLORED_CASTERS = COLORED | SHADOWED | Effect.COLORED_SHADOWS
REFRACTING = COLORED_CASTERS | Effect.REFRACTION | Effect.CAUSTICS
EFFECTS = {
    "atrium_fog": Effect.VOLUME,
    "bottles": COLORED_CASTERS,
    "caustic_spheres": REFRACTING,
    "chess": REFRACTING,
    "clouds": GRAY | Effect.TRANSLUCENT_SHADOWS,
    "courtyard": REFRACTING | Effect.VOLUME,
    "engine": GRAY,
    "foggy_street": GRAY | SHADOWED | Effect.DIFFUSION | Effect.VOLUME,
    "foggy_street[collimation=1]": GRAY | SHADOWED | Effect.VOLUME,
    "foliage": GRAY,
    "foliage[light=sky]": GRAY | SHADOWED | Effect.AMBIENT_OCCLUSION | Effect.INFERRED_AO,
    "fragment_lists": GRAY,
    "fragment_lists[tinted=true]": COLORED,
    "frosted_door": GRAY | SHADOWED | Effect.DIFFUSION,
    "frosted_door[collimation=1]": GRAY | SHADOWED,
    "frosted_panes": GRAY | SHADOWED | Effect.DIFFUSION,
    "glass_bars": COLORED,
    "glow": COLORED_CASTERS,
    "glow[opacity=1]": COLORED_CASTERS,
    "layer_stack": GRAY,
    "layer_stack[transmission=gray]": GRAY,
    "layer_stack[transmission=colored]": COLORED,
    "light_shafts": COLORED_CASTERS | Effect.VOLUME,
    "shadow_trio": REFRACTING,
    "smoke_and_glass": REFRACTING,
    "smoke_ball": GRAY | SHADOWED,
    "smoke_ball[cube=above]": GRAY | SHADOWED,
    "tumblers": REFRACTING,
    "water_and_smoke": REFRACTING,
}
"""The effects that each scene requests, and that its variants do."""
CASES = sorted({*EFFECTS, *COLLECTION.scenes})


def name_of(case: str) -> str:
    return case.partition("[")[0]


def small(case: str) -> Scene:
    return build(with_detail(case, SMALL))

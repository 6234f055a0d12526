"""How many samples each sub-pixel of a full picture gets by default.

They are chosen so that the noise floor, FLIP between the mean M and M + (A − B)/2 with the means A
and B of both halves, is at most 0.02 at 256 × 256.
"""

from __future__ import annotations

from oitbench.scene import Scene

SAMPLES = {
    "atrium_fog": 24,
    "bottles": 40,
    "caustic_spheres": 16,
    "chess": 96,
    "clouds": 4,
    "foggy_street": 112,
    "frosted_door": 16,
    "frosted_panes": 16,
    "light_shafts": 512,
    "shadow_trio": 16,
    "smoke_and_glass": 16,
    "smoke_ball": 12,
    "tumblers": 64,
}
"""By the name of a scene, measured by FLIP at 64 × 64 with 16 samples, as noise falls with the root
of their number."""
PARTICLES, MEDIUM, REFRACTION, OTHER = 12, 256, 64, 48
"""For scenes that are not listed: with particles, with a medium, with solids that refract, other
ones."""


def default_samples(scene: Scene) -> int:
    """Return the default number of samples; scenes that need no random numbers get one anyway."""
    name = scene.name.partition("[")[0]
    if name in SAMPLES:
        return SAMPLES[name]
    if any(item.particles for item in scene.objects):
        return PARTICLES
    if scene.medium is not None:
        return MEDIUM
    return REFRACTION if any(item.material.refracts for item in scene.objects) else OTHER

"""How many samples each sub-pixel of a full picture gets by default.

They suffice for a noise floor of at most 0.02 at 256 × 256: FLIP between the mean M and
M + (A − B)/2, where A and B are the means of both halves.
"""

from __future__ import annotations

from oitbench.scene import Scene

PARTICLES, MEDIUM, REFRACTION, OTHER = 12, 256, 64, 48
"""For scenes that state no number: with particles, with a medium, with solids that refract, other
ones."""


def default_samples(scene: Scene) -> int:
    """Return the default number of samples; scenes that need no random numbers get one anyway."""
    if scene.full_samples:
        return scene.full_samples
    if any(item.particles for item in scene.objects):
        return PARTICLES
    if scene.medium is not None:
        return MEDIUM
    return REFRACTION if any(item.refracts for item in scene.objects) else OTHER

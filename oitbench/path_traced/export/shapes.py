"""Which objects of a scene share a Mitsuba shape, and the ids of these shapes."""

from __future__ import annotations

from oitbench.scene import Object, Scene

FILMS, SOLIDS = "films", "solids"
"""Ids of the shapes of all films, and of all refracting solids."""


def solids(scene: Scene) -> list[Object]:
    """Return the refracting solids of `scene`, in submission order."""
    return [item for item in scene.transparent if item.refracts]


def layout(scene: Scene) -> dict[str, list[Object]]:
    """Return the objects of `scene` by the id of their Mitsuba shape.

    Objects that are no refracting solids are films. Few shapes keep the kernel small, as drjit
    records the calls of each plugin.
    """
    refracting = solids(scene)
    apart = {id(item) for item in refracting}
    films = [item for item in scene.objects if id(item) not in apart]
    return {name: group for name, group in ((FILMS, films), (SOLIDS, refracting)) if group}

"""Which objects of a scene share a Mitsuba shape, and the ids of these shapes."""

from __future__ import annotations

from oitbench.path_traced.optics.materials import interface_roughness
from oitbench.scene import Object, Scene

FILMS = "films"
"""Id of the shape of all films."""


def solids(scene: Scene) -> dict[str, list[Object]]:
    """Return the refracting solids of `scene` by the ids of their Mitsuba shapes.

    Solids with equal interfaces share a shape.
    """
    groups: dict[tuple[float, float], list[Object]] = {}
    for item in scene.transparent:
        material = item.material
        if material.refracts:
            key = (material.index, interface_roughness(material))
            groups.setdefault(key, []).append(item)
    return {f"solids_{number}": group for number, group in enumerate(groups.values())}


def layout(scene: Scene) -> dict[str, list[Object]]:
    """Return the objects of `scene` by the id of their Mitsuba shape.

    Objects that are no refracting solids are films, and share a shape. Few shapes keep the kernel
    small, as drjit records the calls of each plugin.
    """
    refracting = solids(scene)
    apart = {id(item) for group in refracting.values() for item in group}
    films = [item for item in scene.objects if id(item) not in apart]
    return ({FILMS: films} if films else {}) | refracting

"""Which objects of a scene share a Mitsuba shape, and the ids of these shapes."""

from __future__ import annotations

from collections.abc import Hashable

from oitbench.scene import Material, Object, Scene, Texture


def solids(scene: Scene) -> dict[str, Object]:
    """Return the refracting solids of `scene` by the ids of their Mitsuba shapes."""
    found = [item for item in scene.transparent if item.material.refracts]
    return {f"solid_{number}": item for number, item in enumerate(found)}


def layout(scene: Scene) -> dict[str, list[Object]]:
    """Return the objects of `scene` by the id of their Mitsuba shape.

    Each refracting solid has a shape of its own. All other objects are films, and those with the
    same texture share a shape. Few shapes keep the kernel small, as drjit records the calls of each
    plugin.
    """
    refracting = solids(scene)
    apart = {id(item) for item in refracting.values()}
    groups: dict[Hashable, list[Object]] = {}
    for item in scene.objects:
        if id(item) not in apart:
            groups.setdefault(_texture_key(item.material), []).append(item)
    films = {f"films_{number}": group for number, group in enumerate(groups.values())}
    return films | {name: [item] for name, item in refracting.items()}


def _texture_key(material: Material) -> Hashable:
    parts = (material.emission, material.coverage)
    if not any(isinstance(part, Texture) for part in parts):
        return None
    return tuple(id(part) if isinstance(part, Texture) else part for part in parts)

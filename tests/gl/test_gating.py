"""Effects that a scene does not call for: forcing them on changes no pixel, and costs memory.

So what is left out of a frame is only what would have done nothing.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
import pytest

from oitbench.effects import SHADING, Effect, names
from oitbench.gl.device import Device
from oitbench.gl.frame import Frame, Image
from oitbench.gl.uploaded_scene import UploadedScene
from oitbench.matrix.cell import choose_effects
from oitbench.measure import accounting
from oitbench.method.declaration import Method
from oitbench.scene import Scene
from tests.helpers import collection, method

SIZE = (64, 48)
MAP_SIDE = 128
"""Texels along each side of shadow maps: small ones, for speed."""
STEPS = 8
"""Slices of fog, for speed."""
PHENOMENOLOGICAL = f"phenomenological[steps={STEPS}]"
FLOAT = f"phenomenological[precision=float,steps={STEPS}]"
SCENES = (
    *(f"{name}[detail=0.1]" for name in collection().scenes),
    "foliage[detail=0.1,light=sky]",
    "fragment_lists[detail=0.1,tinted=true]",
)
OF_EACH_KIND = (
    "clouds[detail=0.1]",
    "foliage[detail=0.1,light=sky]",
    "fragment_lists[detail=0.1,tinted=true]",
    "frosted_panes[detail=0.1]",
    "light_shafts[detail=0.1]",
    "tumblers[detail=0.1]",
)
"""Scenes that leave out different effects."""
NEEDS_MEMORY = (
    Effect.REFRACTION
    | Effect.DIFFUSION
    | Effect.SHADOWS
    | Effect.TRANSLUCENT_SHADOWS
    | Effect.COLORED_SHADOWS
)
"""What has a target, a larger target or maps of its own, whatever is in the scene."""


@dataclass(frozen=True)
class Rendered:
    """A frame: its picture, bytes by name, passes, effects that shaders were told of, and maps.

    `maps` are the texels of shadow maps by name, `memory` the bytes of targets, maps and textures
    of ambient occlusion.
    """

    image: Image
    memory: dict[str, int]
    passes: frozenset[str]
    told: frozenset[str]
    maps: dict[str, bytes]
    occluded: bool

    @property
    def bytes(self) -> int:
        return sum(self.memory.values())


def rendered(uploaded: UploadedScene, chosen: Method, effects: Effect) -> Rendered:
    uploaded.device.programs.clear()
    with Frame(uploaded, chosen, SIZE, effects) as frame:
        frame.render()
        shading = [entry for stage in frame.shading for entry in stage.memory()]
        own = [(term.resource, term.bytes) for term in accounting.memory(frame).terms]
        sources = " ".join(part for program in uploaded.device.programs for part in program)
        maps: dict[str, bytes] = {}
        for number, one in enumerate(frame.lighting.maps if frame.lighting else ()):
            if one is not None:
                maps |= {f"{name}_map{number}": t.read() for name, t in one.finished.items()}
        return Rendered(
            frame.image(),
            dict([*own, *shading]),
            frozenset(step.name for step in frame.plan.passes),
            frozenset(re.findall(r"#define EFFECT_(\w+) 1", sources)),
            maps,
            frame.occlusion is not None,
        )


def pair(device: Device, scene: Scene, chosen: Method) -> tuple[Rendered, Rendered]:
    """Return the frame of what the scene calls for, and that of everything."""
    everything = choose_effects("all", scene.effects)
    with UploadedScene(device, scene, MAP_SIDE) as uploaded:
        called, forced = (
            rendered(uploaded, chosen, effects & chosen.shows)
            for effects in (scene.effects, everything)
        )
    return called, forced


def steps_of_half(image: Image) -> npt.NDArray[np.float32]:
    """Return the distance to the next value that the target's format, rgba16f, holds."""
    return np.spacing(abs(image).astype(np.float16)).astype(np.float32)


def absent(scene: Scene, chosen: Method) -> Iterator[Effect]:
    """Yield the effects that the method shows and the scene does not call for."""
    yield from (effect for effect in Effect if effect in chosen.shows & ~scene.effects)


@pytest.mark.parametrize("text", SCENES)
@pytest.mark.parametrize("name", [PHENOMENOLOGICAL, "weighted_blended"])
def test_what_is_not_called_for_costs_memory_and_does_nothing(
    device: Device, name: str, text: str
) -> None:
    scene, chosen = collection().build_scene(text), method(name)
    called, forced = pair(device, scene, chosen)
    assert (abs(forced.image - called.image) <= steps_of_half(called.image)).all()
    left_out = Effect.NONE
    for effect in absent(scene, chosen):
        left_out |= effect
    assert left_out
    if not scene.beams:
        left_out &= ~SHADING
    assert (forced.bytes > called.bytes) == bool(left_out & NEEDS_MEMORY)
    assert all(forced.memory[resource] >= size for resource, size in called.memory.items())
    only_what_is_called_for_is_there(scene, chosen, called)
    forced_maps_say_the_same(called.maps, forced.maps)


def only_what_is_called_for_is_there(scene: Scene, chosen: Method, frame: Rendered) -> None:
    running = scene.effects & chosen.shows
    assert frame.told == set(names(running))
    assert ("fog" in frame.passes) == (Effect.VOLUME in running)
    assert frame.occluded == (Effect.AMBIENT_OCCLUSION in running)
    assert ("delta" in frame.memory) == (Effect.REFRACTION in running)
    if "beta" in frame.memory:
        pixel = 4 if Effect.DIFFUSION in running else 3
        assert frame.memory["beta"] == pixel * SIZE[0] * SIZE[1]
    for number in range(len(scene.beams)):
        channels = 3 if Effect.COLORED_SHADOWS in running else 1
        expected = set()
        if Effect.SHADOWS in running:
            expected.add(f"opaque_map{number}")
        if Effect.TRANSLUCENT_SHADOWS in running:
            expected |= {f"filtered{k}_map{number}" for k in range(channels)}
        assert {map_ for map_ in frame.maps if map_.endswith(f"_map{number}")} == expected


def forced_maps_say_the_same(called: dict[str, bytes], forced: dict[str, bytes]) -> None:
    """Maps of red, green and blue are all the one of gray, and no other map changes."""
    for name, texels in forced.items():
        alike = name if name in called else re.sub(r"filtered\d", "filtered0", name)
        if alike in called:
            assert texels == called[alike], name


@pytest.mark.parametrize("text", OF_EACH_KIND)
def test_in_single_precision_nothing_changes_either(device: Device, text: str) -> None:
    called, forced = pair(device, collection().build_scene(text), method(FLOAT))
    np.testing.assert_allclose(forced.image, called.image, rtol=0, atol=1e-6)

"""Effects that a scene does not request: forcing them changes no pixel and only takes memory.

So a frame loses nothing when it leaves them out.
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
from oitbench.shading import ShadingSettings
from tests.helpers import collection, method

SIZE = (64, 48)
SETTINGS = ShadingSettings(shadow_map=128)
"""Texels along each side of shadow maps; few, for speed."""
STEPS = 8
"""Slices of fog; few, for speed."""
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
"""Scenes that request different effects."""
NEEDS_MEMORY = (
    Effect.REFRACTION
    | Effect.DIFFUSION
    | Effect.SHADOWS
    | Effect.TRANSLUCENT_SHADOWS
    | Effect.COLORED_SHADOWS
)
"""Effects with a target, a larger target or maps of their own, in any scene."""


@dataclass(frozen=True)
class Rendered:
    """A rendered frame.

    Attributes
    ----------
    image : array, shape (h, w, 3)
    memory : dict
        Bytes of targets, shadow maps and textures of ambient occlusion, by name.
    passes : frozenset of str
    effects : frozenset of str
        Effects that are defined in the shaders.
    maps : dict
        Texels of shadow maps, by name.
    occluded : bool
        Whether ambient occlusion was rendered.
    """

    image: Image
    memory: dict[str, int]
    passes: frozenset[str]
    effects: frozenset[str]
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
    """Return the frame with the effects that the scene requests, and that with all effects."""
    everything = choose_effects("all", scene.effects)
    with UploadedScene(device, scene, SETTINGS, SIZE[1]) as uploaded:
        requested, forced = (
            rendered(uploaded, chosen, effects & chosen.shows)
            for effects in (scene.effects, everything)
        )
    return requested, forced


def steps_of_half(image: Image) -> npt.NDArray[np.float32]:
    """Return the distance to the next value that the target's format, rgba16f, holds."""
    return np.spacing(abs(image).astype(np.float16)).astype(np.float32)


def absent(scene: Scene, chosen: Method) -> Iterator[Effect]:
    """Yield the effects that the method shows and the scene does not request."""
    yield from (effect for effect in Effect if effect in chosen.shows & ~scene.effects)


@pytest.mark.parametrize("text", SCENES)
@pytest.mark.parametrize("name", [PHENOMENOLOGICAL, "weighted_blended"])
def test_effects_that_are_not_requested_change_no_pixel_and_only_take_memory(
    device: Device, name: str, text: str
) -> None:
    scene, chosen = collection().build_scene(text), method(name)
    requested, forced = pair(device, scene, chosen)
    assert (abs(forced.image - requested.image) <= steps_of_half(requested.image)).all()
    left_out = Effect.NONE
    for effect in absent(scene, chosen):
        left_out |= effect
    assert left_out
    if not scene.beams:
        left_out &= ~SHADING
    assert (forced.bytes > requested.bytes) == bool(left_out & NEEDS_MEMORY)
    assert all(forced.memory[resource] >= size for resource, size in requested.memory.items())
    assert_only_requested(scene, chosen, requested)
    assert_same_maps(requested.maps, forced.maps)


def assert_only_requested(scene: Scene, chosen: Method, frame: Rendered) -> None:
    """Assert that the frame has the resources of the running effects and no others."""
    running = scene.effects & chosen.shows
    assert frame.effects == set(names(running))
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
            expected |= {f"slices{k}_map{number}" for k in range(channels)}
        assert {map_ for map_ in frame.maps if map_.endswith(f"_map{number}")} == expected


def assert_same_maps(requested: dict[str, bytes], forced: dict[str, bytes]) -> None:
    """Assert that the maps of red, green and blue equal that of gray, and other maps are equal."""
    for name, texels in forced.items():
        same = name if name in requested else re.sub(r"filtered\d", "filtered0", name)
        if same in requested:
            assert texels == requested[same], name


@pytest.mark.parametrize("text", OF_EACH_KIND)
def test_effects_that_are_not_requested_change_nothing_in_single_precision(
    device: Device, text: str
) -> None:
    requested, forced = pair(device, collection().build_scene(text), method(FLOAT))
    np.testing.assert_allclose(forced.image, requested.image, rtol=0, atol=1e-6)

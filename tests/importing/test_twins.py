"""Scenes that were written to a file and imported look like the scenes themselves."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from oitbench.effects import Effect
from oitbench.gl.device import Device
from oitbench.image.files import Image, to_srgb
from oitbench.path_traced.matched.render import matched
from oitbench.scene import Mesh, Scene
from tests.helpers import collection, render
from tests.importing.export import twin

TWINS = ("layer_stack", "foliage[detail=0.02]", "tumblers[detail=0.1]")
SIZE = (48, 48)


def stored(scene: Scene) -> Scene:
    """Return a scene with positions as files store them.

    Refraction magnifies their rounding: without it, 4 of the 2,304 pixels of `tumblers` differ by
    up to 5 steps, with or without a file.
    """
    return replace(
        scene,
        objects=tuple(
            replace(item, mesh=replace(mesh, positions=mesh.positions.astype(np.float32)))
            for item in scene.objects
            if isinstance(mesh := item.mesh, Mesh)
        ),
    )


def levels(image: Image, scene: Scene) -> Image:
    """Return a picture in steps of its format."""
    return np.rint(to_srgb(image, scene.exposure) * 255)


@pytest.mark.parametrize("label", TWINS)
def test_an_imported_twin_looks_like_its_scene(label: str, device: Device, tmp_path: Path) -> None:
    native = stored(collection().build_scene(label))
    imported = twin(native, tmp_path)
    assert imported.effects == native.effects
    for found, expected in zip(imported.objects, native.objects, strict=True):
        assert found.material.solid == expected.material.solid, found.name
        assert found.opaque == expected.opaque
    pictures = [render(device, one, "a_buffer", size=SIZE) for one in (native, imported)]
    compare(native, *pictures)
    # Caustics and other random effects would take many samples.
    effects = ~(Effect.CAUSTICS | Effect.AMBIENT_OCCLUSION | Effect.VOLUME | Effect.DIFFUSION)
    traced = [matched(one, SIZE, 1, effects) for one in (native, imported)]
    compare(native, *traced)


def compare(scene: Scene, first: Image, second: Image) -> None:
    apart = np.abs(levels(first, scene) - levels(second, scene))
    assert levels(first, scene).std() > 10
    assert apart.max() <= 1

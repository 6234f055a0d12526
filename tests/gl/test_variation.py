"""What varies over surfaces costs scenes that have none of it nothing."""

from __future__ import annotations

import re
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from oitbench.gl.device import Device
from oitbench.gl.surface_textures import surface_key
from oitbench.gl.uploaded_scene import UploadedScene
from oitbench.modeling.mesh import quad
from oitbench.scene import (
    Camera,
    DirectionalLight,
    EnvironmentLight,
    Material,
    Object,
    Scene,
    Texture,
    Wrap,
)
from tests.helpers import render

CAMERA = Camera((0, 0, 0), (0, 0, -1))
FLAT = quad((0, 0, -2), (1, 0, 0), (0, 1, 0))
LIGHTS = (DirectionalLight((0.1, -0.2, -1.0)), EnvironmentLight())
GRAY = Texture(np.full((4, 4), 0.5, np.float32))
AROUND = Texture(GRAY.texels, (Wrap.REPEAT, Wrap.CLAMP))
LIT: dict[str, Any] = {"albedo": (0.5, 0.5, 0.5), "specular": 0.04, "roughness": 0.5}
PLAIN = {"TEXTURED", "DETAILED"}
TABLE = {"VARIED"}
KINDS: dict[str, tuple[Material, dict[str, Any], set[str]]] = {
    "plain": (Material(GRAY, **LIT), {}, set()),
    "wrap": (Material(AROUND, **LIT), {}, {"WRAPS"}),
    "albedo": (Material(GRAY, **LIT | {"albedo": GRAY}), {}, TABLE | {"ALBEDO_TEXTURES"}),
    "transmission": (Material(GRAY, GRAY, **LIT), {}, TABLE | {"TRANSMISSION_TEXTURES"}),
    "roughness": (
        Material(GRAY, **LIT | {"roughness": GRAY}), {}, TABLE | {"ROUGHNESS_TEXTURES", "GRADES"},
    ),
    "cutoff": (Material(GRAY, cutoff=0.25, **LIT), {}, TABLE | {"CUTOFF"}),
    "culled": (Material(GRAY, culled=True, **LIT), {}, TABLE | {"CULLED"}),
    "vertices": (
        Material(GRAY, **LIT), {"coverage": np.ones(4, np.float32)}, {"VARIED", "VERTEX_FACTORS"},
    ),
}  # fmt: skip
ALL = set[str]().union(*(names for _, _, names in KINDS.values()))


def test_objects_of_one_material_are_told_apart_by_what_light_passes() -> None:
    paper = Material(**LIT)
    faded = replace(FLAT, coverage=np.zeros(4, np.float32))
    one, same, other = (Object("x", mesh, paper) for mesh in (FLAT, FLAT, faded))
    assert surface_key(one) == surface_key(same) != surface_key(other)


@pytest.mark.parametrize("kind", KINDS)
def test_only_what_a_scene_has_is_compiled(device: Device, kind: str) -> None:
    material, vertices, names = KINDS[kind]
    objects = (Object("x", replace(FLAT, **vertices), material),)
    scene = Scene("s", CAMERA, objects, lights=LIGHTS)
    device.programs.clear()
    with UploadedScene(device, scene) as uploaded:
        geometry = uploaded.geometry
        found = set(re.findall(r"#define (\w+)", geometry.macros))
        assert found >= PLAIN
        assert found & ALL == names
        table = "VARIED" in names and kind != "vertices"
        assert ("surface_variation" in geometry.textures) == table
        assert (geometry.factors is None) == (kind != "vertices")
    render(device, scene, "weighted_blended", size=(8, 8))
    text = " ".join(part for program in device.programs for part in program)
    assert set(re.findall(r"#define (\w+)", text)) & ALL == names


@pytest.mark.parametrize("kind", ["wrap", "albedo", "transmission", "roughness", "vertices"])
def test_what_does_not_vary_draws_as_a_constant(device: Device, kind: str) -> None:
    material, vertices, _ = KINDS[kind]
    constant = KINDS["plain"][0]
    if kind == "transmission":
        constant = replace(constant, transmission=(0.5, 0.5, 0.5))
    scenes = [
        Scene("s", CAMERA, (Object("x", mesh, one),), lights=LIGHTS)
        for mesh, one in ((replace(FLAT, **vertices), material), (FLAT, constant))
    ]
    found, expected = (render(device, one, "a_buffer", size=(16, 16)) for one in scenes)
    assert np.ptp(expected) > 0.01
    np.testing.assert_allclose(found, expected, rtol=1e-5, atol=1e-6)

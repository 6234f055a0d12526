"""Writes scenes as glTF files, as far as the format holds them."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from oitbench.image.files import write_exr
from oitbench.importing import read_scene
from oitbench.scene import (
    BLACK,
    PENUMBRA,
    Camera,
    DirectionalLight,
    Floats,
    Material,
    Mesh,
    Object,
    Scene,
    SpotLight,
    Texture,
    Wrap,
    axes_along,
)
from tests.importing.files import Gltf

_WRAPS = {Wrap.CLAMP: 33071, Wrap.MIRROR: 33648, Wrap.REPEAT: 10497}


def twin(scene: Scene, folder: Path) -> Scene:
    """Return a scene that was written to a file and imported.

    Its background, its exposure and the floors that throw no shadow are taken from the scene, since
    no file holds them.
    """
    gltf = Gltf()
    for item in scene.objects:
        _add_object(gltf, item)
    _add_camera(gltf, scene.camera)
    for light in scene.beams:
        _add_light(gltf, light)
    sky = "none"
    if scene.environment is not None:
        sky = "sky.exr"
        write_exr(folder / sky, scene.environment.texels.astype(np.float32))
    found = read_scene(
        gltf.write(folder), scene.name, light="file", environment=sky, ground="no",
        unit=scene.meters_per_unit,
    )  # fmt: skip
    assert found.notes == ()
    objects = tuple(
        replace(item, casts=native.casts)
        for item, native in zip(found.scene.objects, scene.objects, strict=True)
    )
    return replace(
        found.scene, objects=objects, background=scene.background, exposure=scene.exposure
    )


def _add_object(gltf: Gltf, item: Object) -> None:
    mesh, described = item.mesh, _material(gltf, item.material)
    attributes = {"POSITION": gltf.array(mesh.positions)}
    if mesh.normals is not None:
        attributes["NORMAL"] = gltf.array(mesh.normals)
    if mesh.uvs is not None:
        attributes["TEXCOORD_0"] = gltf.array(mesh.uvs * [1, -1] + [0, 1])
    if (color := _vertex_color(mesh)) is not None:
        attributes["COLOR_0"] = gltf.array(color)
    indices = gltf.array(mesh.triangles.ravel(), "uint32")
    number = gltf.mesh(attributes, indices, material=gltf.add("materials", described))
    gltf.add("nodes", {"mesh": number, "name": item.name})


def _vertex_color(mesh: Mesh) -> Any:
    if mesh.radiance is not None:
        assert mesh.radiance.max() <= 1
    return mesh.radiance


def _material(gltf: Gltf, material: Material) -> dict[str, Any]:
    """Return a material of a file; the inverse of what importing does."""
    coverage = material.coverage
    extensions: dict[str, Any] = {}
    pbr: dict[str, Any] = {"metallicFactor": 0, "roughnessFactor": material.roughness}
    described = {"pbrMetallicRoughness": pbr, "extensions": extensions, "doubleSided": True}
    assert isinstance(material.emission, tuple)
    assert isinstance(material.albedo, tuple)
    assert isinstance(material.transmission, tuple)
    if any(material.emission):
        assert material.albedo == material.transmission == BLACK
        assert material.reflectance == 0
        base = np.array(material.emission)
        extensions["KHR_materials_unlit"] = {}
    else:
        albedo, tint = np.array(material.albedo), np.array(material.transmission)
        passed = tint * (1 - albedo)
        base = albedo + passed
        part = float(passed.max() / base.max()) if passed.any() else 0.0
        np.testing.assert_allclose(base * part, passed, atol=1e-12)
        index = material.index if material.transmission != BLACK else 1.5
        extensions["KHR_materials_ior"] = {"ior": index}
        factor = material.reflectance / max(Material(index=index).reflectance, 1e-9)
        extensions["KHR_materials_specular"] = {"specularColorFactor": [factor] * 3}
        if part:
            extensions["KHR_materials_transmission"] = {"transmissionFactor": part}
        if material.solid:
            extensions["KHR_materials_volume"] = {"thicknessFactor": 1}
    assert base.max() <= 1
    alpha = 1.0 if isinstance(coverage, Texture) else coverage
    pbr["baseColorFactor"] = [*base.tolist(), alpha]
    if isinstance(coverage, Texture):
        levels = np.full((*coverage.texels.shape, 4), 255.0)
        levels[..., 3] = np.rint(coverage.texels * 255)
        wrap = {"wrapS": _WRAPS[coverage.wrap[0]], "wrapT": _WRAPS[coverage.wrap[1]]}
        pbr["baseColorTexture"] = {"index": gltf.picture(levels, **wrap)}
    if coverage != 1:
        described["alphaMode"] = "BLEND"
    return described


def _add_camera(gltf: Gltf, camera: Camera) -> None:
    lens = {"yfov": camera.fov_y, "znear": camera.near}
    number = gltf.add("cameras", {"type": "perspective", "perspective": lens})
    place = _placed(camera.axes, np.array(camera.position))
    gltf.add("nodes", {"camera": number, "name": "camera", "matrix": place})


def _add_light(gltf: Gltf, light: DirectionalLight | SpotLight) -> None:
    described: dict[str, Any]
    if isinstance(light, DirectionalLight):
        ahead, position = np.array(light.direction), np.zeros(3)
        described = {"type": "directional", "color": list(light.irradiance)}
    else:
        position = np.array(light.position)
        ahead = np.array(light.target) - position
        half = light.angle / 2
        spot = {"innerConeAngle": (1 - PENUMBRA) * half, "outerConeAngle": half}
        described = {"type": "spot", "color": list(light.intensity), "spot": spot}
    lights = gltf.document.setdefault("extensions", {"KHR_lights_punctual": {"lights": []}})
    lights["KHR_lights_punctual"]["lights"].append(described)
    extension = {"light": len(lights["KHR_lights_punctual"]["lights"]) - 1}
    place = _placed(axes_along(-ahead), position)
    gltf.add("nodes", {"extensions": {"KHR_lights_punctual": extension}, "matrix": place})


def _placed(axes: Floats, position: Floats) -> list[float]:
    """Return the matrix of a node, column by column."""
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = axes.T, position
    return [float(value) for value in matrix.T.ravel()]

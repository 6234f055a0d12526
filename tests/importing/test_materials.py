"""What becomes of the materials of glTF files."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from oitbench.errors import SceneError
from oitbench.importing.looks import collimation_of, roughness_of_exponent, transmission_of
from oitbench.scene import BLACK, Material, Object, Texture, Wrap
from tests.importing.files import SIMPLE, Gltf, close

GLASS = {"KHR_materials_transmission": {"transmissionFactor": 1}}


def pbr(**members: Any) -> dict[str, Any]:
    return {"pbrMetallicRoughness": {"metallicFactor": 0, **members}}


def material(folder: Path, described: dict[str, Any], **attributes: Any) -> Material:
    gltf = Gltf()
    arrays = {name: gltf.array(values) for name, values in attributes.items()}
    gltf.triangle(described, **arrays)
    return gltf.one(folder).material


def textured(folder: Path, gltf: Gltf, described: dict[str, Any], **attributes: Any) -> Object:
    uvs = gltf.array([[0, 0], [1, 0], [0, 1]])
    gltf.triangle(described, TEXCOORD_0=uvs, **attributes)
    return gltf.one(folder)


def texels(value: Any) -> Any:
    assert isinstance(value, Texture)
    return value.texels


def test_plain_surfaces(tmp_path: Path) -> None:
    found = material(tmp_path, pbr(baseColorFactor=[0.2, 0.4, 0.6, 0.5], roughnessFactor=0.3))
    assert found.albedo == pytest.approx((0.2, 0.4, 0.6))
    assert found.roughness == pytest.approx(0.3)
    assert (found.coverage, found.transmission, found.index) == (1, BLACK, 1.5)
    assert found.reflectance == pytest.approx(0.04)
    assert found.culled
    assert not material(tmp_path, {**pbr(), "doubleSided": True}).culled


def test_alpha_blends_or_cuts(tmp_path: Path) -> None:
    half = pbr(baseColorFactor=[1, 1, 1, 0.5])
    assert material(tmp_path, {**half, "alphaMode": "BLEND"}).coverage == 0.5
    assert material(tmp_path, {**half, "alphaMode": "MASK"}).coverage == 1
    with pytest.raises(SceneError, match="no triangle that can be seen"):
        material(tmp_path, {**half, "alphaMode": "MASK", "alphaCutoff": 0.6})
    for cutoff, expected in ((0.25, 0.25), (0, None)):
        gltf = Gltf()
        image = gltf.picture([[[255, 255, 255, 0], [255, 255, 255, 51]]])
        described = {**pbr(baseColorTexture={"index": image}), "alphaMode": "MASK"}
        found = textured(tmp_path, gltf, {**described, "alphaCutoff": cutoff}).material
        assert found.cutoff == expected
        assert found.opaque
        if expected is None:
            assert found.coverage == 1
        else:
            close(texels(found.coverage), [[0, 0.2]])
            assert found.binary_coverage


def test_base_color_is_a_product_of_factor_texture_and_vertices(tmp_path: Path) -> None:
    gltf = Gltf()
    image = gltf.picture([[[255, 188, 0, 128]]] * 2 + [[[0, 0, 255, 255]]] * 2)
    described = pbr(baseColorFactor=[0.5, 1, 1, 0.5], baseColorTexture={"index": image})
    colors = gltf.array(
        [[255, 0, 0, 255], [0, 255, 0, 51], [0, 0, 255, 0]], "uint8", normalized=True
    )
    item = textured(tmp_path, gltf, {**described, "alphaMode": "BLEND"}, COLOR_0=colors)
    # 188 of sRGB is half of the light, within its steps.
    close(texels(item.material.albedo)[0, 0], [0.5, 0.5, 0], atol=0.005)
    close(texels(item.material.coverage)[:, 0], [0.251, 0.251, 0.5, 0.5], atol=1e-3)
    close(item.mesh.albedo, np.eye(3))
    close(item.mesh.coverage, [1, 0.2, 0])
    assert item.mesh.transmission is None
    opaque = Gltf()
    colors = opaque.array([[0, 0, 0, 0]] * 3)
    assert textured(tmp_path, opaque, pbr(), COLOR_0=colors).mesh.coverage is None


@pytest.mark.parametrize(
    ("code", "wrap"), [(33071, Wrap.CLAMP), (33648, Wrap.MIRROR), (10497, Wrap.REPEAT)]
)
def test_textures_continue_as_their_sampler_says(code: int, wrap: Wrap, tmp_path: Path) -> None:
    gltf = Gltf()
    image = gltf.picture([[[255, 0, 0], [0, 0, 0], [9, 9, 9]]], wrapS=code, wrapT=33071)
    found = textured(tmp_path, gltf, pbr(baseColorTexture={"index": image})).material.albedo
    assert isinstance(found, Texture)
    assert found.wrap == (wrap, Wrap.CLAMP)
    assert found.texels.shape == (1, 3, 3)


def test_texture_coordinates_are_transformed(tmp_path: Path) -> None:
    gltf = Gltf()
    image = gltf.picture([[[255, 0, 0], [0, 0, 0]]])
    # The example of the extension's page: the lower left quarter, turned clockwise.
    transform = {"offset": [0, 1], "rotation": np.pi / 2, "scale": [0.5, 0.5], "texCoord": 1}
    extensions = {"KHR_texture_transform": transform}
    info = {"index": image, "extensions": extensions}
    coordinates = gltf.array([[0, 0], [1, 0], [0, 1]])
    item = textured(tmp_path, gltf, pbr(baseColorTexture=info), TEXCOORD_1=coordinates)
    # Of a file, v runs down; of a mesh, up.
    close(item.mesh.uvs, [[0, 0], [0, 0.5], [0.5, 0]], atol=1e-6)


def test_metallic_roughness_maps(tmp_path: Path) -> None:
    gltf = Gltf()
    image = gltf.picture([[[0, 51, 0], [0, 255, 255]]])
    described = {
        "pbrMetallicRoughness": {
            "baseColorFactor": [0.9, 0.6, 0.3, 1],
            "roughnessFactor": 0.5,
            "metallicRoughnessTexture": {"index": image},
        }
    }
    gltf.triangle(described, TEXCOORD_0=gltf.array([[0, 0], [1, 0], [0, 1]]))
    imported = gltf.read(tmp_path)
    found = imported.scene.objects[0].material
    close(texels(found.roughness), [[0.1, 0.5]])
    # A metal mirrors the gray part of its color, and scatters the rest.
    close(texels(found.albedo), [[[0.9, 0.6, 0.3], [0.6, 0.3, 0]]], atol=1e-6)
    assert found.reflectance == pytest.approx(0.5 * 0.04 + 0.5 * 0.3)
    assert any(note.startswith("metals:") for note in imported.notes)


def test_reflectance_and_index(tmp_path: Path) -> None:
    def reflectance(**extensions: Any) -> float:
        names = {f"KHR_materials_{key}": value for key, value in extensions.items()}
        return material(tmp_path, {**pbr(), "extensions": names}).reflectance

    assert reflectance(ior={"ior": 2}) == pytest.approx(1 / 9)
    assert reflectance(ior={"ior": 0}) == 1
    assert reflectance(specular={"specularFactor": 0.5}) == pytest.approx(0.02)
    assert reflectance(specular={"specularColorFactor": [2, 1, 0]}) == pytest.approx(0.04)
    strong = {"specularColorFactor": [99, 99, 99], "specularFactor": 0.7}
    assert reflectance(specular=strong) == pytest.approx(0.7)


def test_emission(tmp_path: Path) -> None:
    strong = {"KHR_materials_emissive_strength": {"emissiveStrength": 4}}
    described = {**pbr(), "emissiveFactor": [1, 0.5, 0], "extensions": strong}
    assert material(tmp_path, described).emission == (4, 2, 0)
    gltf = Gltf()
    image = gltf.picture([[[255, 255, 255], [0, 0, 0]]])
    described["emissiveTexture"] = {"index": image}
    found = textured(tmp_path, gltf, described).material
    close(texels(found.emission), [[[4, 2, 0], [0, 0, 0]]])


def test_unlit_surfaces_only_emit(tmp_path: Path) -> None:
    gltf = Gltf()
    described = {
        **pbr(baseColorFactor=[0.2, 0.4, 0.6, 1]),
        "extensions": {"KHR_materials_unlit": {}},
    }
    item = textured(tmp_path, gltf, described, COLOR_0=gltf.array(np.eye(3)))
    found = item.material
    assert found.emission == pytest.approx((0.2, 0.4, 0.6))
    assert (found.albedo, found.reflectance) == (BLACK, 0)
    np.testing.assert_array_equal(item.mesh.radiance, np.eye(3))
    assert item.mesh.albedo is None


@pytest.mark.parametrize("part", [0.0, 0.25, 1.0])
def test_transmission_keeps_the_transmittance_of_the_file(part: float) -> None:
    base = np.array([0.0, 0.3, 1.0], dtype=np.float32)
    albedo = base * np.float32(1 - part)
    tint = transmission_of(base * np.float32(part), albedo)
    assert ((tint >= 0) & (tint <= 1)).all()
    # What is not scattered passes as T (1 − albedo).
    close(tint * (1 - base * (1 - part)), base * part, atol=1e-6)


def test_glass_without_a_volume_is_a_thin_sheet(tmp_path: Path) -> None:
    described = {**pbr(baseColorFactor=[0.5, 0.8, 1, 1], roughnessFactor=0), "extensions": GLASS}
    gltf = Gltf()
    gltf.solid(described)
    found = gltf.one(tmp_path).material
    assert found.transmission == pytest.approx((0.5, 0.8, 1))
    assert (found.albedo, found.solid, found.collimation) == (BLACK, False, 1)
    item = textured(tmp_path, gltf := Gltf(), described, COLOR_0=gltf.array(np.eye(3)))
    np.testing.assert_array_equal(item.mesh.transmission, np.eye(3))


def volume(**members: Any) -> dict[str, Any]:
    inside = {"thicknessFactor": 0.5, "attenuationDistance": 2, "attenuationColor": [1, 0.25, 1]}
    extensions = {**GLASS, "KHR_materials_volume": {**inside, **members}}
    extensions["KHR_materials_ior"] = {"ior": 1.25}
    return {**pbr(roughnessFactor=0.5), "extensions": extensions}


def test_a_volume_in_a_closed_mesh_is_a_solid(tmp_path: Path) -> None:
    gltf = Gltf()
    gltf.solid(volume())
    found = gltf.one(tmp_path).material
    assert (found.solid, found.index, found.culled) == (True, 1.25, False)
    # A cube of side 1 has the mean chord 4 V / S = 2/3, which two interfaces share.
    assert found.transmission == pytest.approx((1, 0.25 ** (2 / 3 / 2 / 2), 1))
    assert found.collimation == pytest.approx(1 - 4 * 0.25 * 0.25)


def test_an_open_volume_is_a_sheet_of_its_thickness(tmp_path: Path) -> None:
    gltf = Gltf()
    gltf.solid(volume(), closed=False)
    imported = gltf.read(tmp_path)
    found = imported.scene.objects[0].material
    assert not found.solid
    assert found.transmission == pytest.approx((1, 0.25 ** (0.5 / 2), 1))
    (note,) = imported.notes
    assert note.startswith("a volume is a thin sheet if")
    # Thickness is a length of the mesh, and the distance of attenuation one of the world.
    gltf.document["nodes"][0]["scale"] = [3, 3, 3]
    assert gltf.one(tmp_path).material.transmission == pytest.approx((1, 0.25 ** (3 * 0.5 / 2), 1))
    image = gltf.picture([[[255, 255, 255], [0, 0, 0]]])
    described = gltf.document["materials"][0]["pbrMetallicRoughness"]
    described["baseColorTexture"] = {"index": image}
    part = gltf.document["meshes"][0]["primitives"][0]
    part["attributes"]["TEXCOORD_0"] = gltf.array(np.zeros((8, 2)))
    close(gltf.one(tmp_path).mesh.transmission, [[1, 0.25 ** (3 * 0.5 / 2), 1]] * 8)
    gltf = Gltf()
    gltf.solid(volume(thicknessFactor=0))
    assert gltf.one(tmp_path).material.transmission == (1, 1, 1)


def test_a_solid_has_one_tint(tmp_path: Path) -> None:
    gltf = Gltf()
    described = volume()
    image = gltf.picture([[[255, 255, 255], [0, 0, 0]]])
    described["pbrMetallicRoughness"]["baseColorTexture"] = {"index": image}
    gltf.solid(described)
    mesh = gltf.document["meshes"][0]["primitives"][0]
    mesh["attributes"]["TEXCOORD_0"] = gltf.array(np.zeros((8, 2)))
    imported = gltf.read(tmp_path)
    tint = imported.scene.objects[0].material.transmission
    assert not isinstance(tint, Texture)
    assert tint[0] == pytest.approx(0.5)
    assert any("mean of their textures" in note for note in imported.notes)


def test_collimation_has_the_blur_of_the_microfacets() -> None:
    assert collimation_of(0, 1.5) == 1
    assert collimation_of(1, 1) == 1
    # The path tracer's facets of a solid, see CONVENTIONS.md: α = (1 − c) / (4 (N − 1)).
    for index in (1.1, 1.33, 1.5):
        assert (1 - collimation_of(0.4, index)) / (4 * (index - 1)) == pytest.approx(0.4**2)
    assert collimation_of(1, 2) == 0
    assert roughness_of_exponent(0) == 1
    assert roughness_of_exponent(1e6) < 0.04


def test_maps_that_lie_otherwise_are_means(tmp_path: Path) -> None:
    gltf = Gltf()
    image = gltf.picture([[[255, 255, 255], [0, 0, 0]]])
    other = {"index": image, "extensions": {"KHR_texture_transform": {"scale": [2, 2]}}}
    described = {**pbr(baseColorTexture={"index": image}), "emissiveFactor": [1, 1, 1]}
    described["emissiveTexture"] = other
    gltf.triangle(described, TEXCOORD_0=gltf.array([[0, 0], [1, 0], [0, 1]]))
    imported = gltf.read(tmp_path)
    assert isinstance(imported.scene.objects[0].material.albedo, Texture)
    # Half of the texels emit, so the mean of light is half, whatever its code is.
    close(imported.scene.objects[0].material.emission, [0.5] * 3)
    assert "replaced by means (material 0)" in imported.notes[0]


def test_what_is_not_shown_is_noted_once_for_each_kind(tmp_path: Path) -> None:
    gltf = Gltf()
    image = gltf.picture([[[1, 2, 3]]])
    coat = {"KHR_materials_clearcoat": {"clearcoatFactor": 1}}
    for name in ("red", "blue"):
        described = {**pbr(), "name": name, "normalTexture": {"index": image}, "extensions": coat}
        gltf.triangle(described)
    gltf.document |= {"animations": [{}], "extensionsUsed": ["KHR_materials_clearcoat"]}
    line = {"attributes": {"POSITION": 0}, "mode": 1}
    gltf.document["meshes"][0]["primitives"].append(line)
    assert sorted(gltf.read(tmp_path).notes) == [
        "KHR_materials_clearcoat is ignored",
        "animations are ignored; the scene is shown at rest",
        "normal maps are ignored (red and 1 more)",
        "points and lines are left out",
    ]


def test_required_extensions_are_refused_if_unknown(tmp_path: Path) -> None:
    for name, message in (
        ("KHR_draco_mesh_compression", "export it without compression"),
        ("XX_magic", "XX_magic, which cannot be imported"),
    ):
        gltf = Gltf()
        gltf.triangle()
        gltf.document["extensionsRequired"] = [name]
        with pytest.raises(SceneError, match=message):
            gltf.read(tmp_path, **SIMPLE)


def test_metals_let_no_light_pass(tmp_path: Path) -> None:
    for metallic, passed in ((1, 0), (0.5, 0.5)):
        described = {
            "pbrMetallicRoughness": {"metallicFactor": metallic, "baseColorFactor": [1, 1, 1, 1]},
            "extensions": GLASS,
        }
        found = material(tmp_path, described)
        assert isinstance(found.albedo, tuple)
        assert isinstance(found.transmission, tuple)
        # What is neither mirrored nor scattered passes: T (1 − albedo).
        assert found.transmission[0] * (1 - found.albedo[0]) == pytest.approx(passed, abs=1e-6)


def colored(folder: Path, colors: Any, described: dict[str, Any] | None) -> tuple[Object, Any]:
    """Return the triangle with colors of its vertices, and the notes of the import."""
    gltf = Gltf()
    uvs = gltf.array([[0, 0], [1, 0], [0, 1]])
    gltf.triangle(described, COLOR_0=gltf.array(colors), TEXCOORD_0=uvs)
    found = gltf.read(folder)
    return found.scene.objects[0], found.notes


def scattered(item: Object) -> Any:
    """Return the albedo at the vertices of an object without textures."""
    assert item.mesh.albedo is not None
    assert isinstance(item.material.albedo, tuple)
    return item.mesh.albedo * np.array(item.material.albedo)


def test_a_metal_has_the_colors_of_its_vertices(tmp_path: Path) -> None:
    # A material that states nothing is a metal.
    for described in (None, {"name": "plain"}):
        item, notes = colored(tmp_path, [[1, 0, 0]] * 3, described)
        assert item.material.reflectance == 0
        close(scattered(item), [[1, 0, 0]] * 3)
        assert [note.partition(":")[0] for note in notes] == ["metals"]
    item, notes = colored(tmp_path, [[0.8, 0.5, 0.4]] * 3, None)
    assert item.material.reflectance == pytest.approx(0.4)
    close(scattered(item), [[0.4, 0.1, 0]] * 3)
    item, notes = colored(tmp_path, [[0.5, 0.5, 0.5]] * 3, None)
    assert item.material.reflectance == pytest.approx(0.5)
    assert (item.material.albedo, notes) == (BLACK, ())


def test_a_metal_mirrors_the_mean_of_its_vertices(tmp_path: Path) -> None:
    # What no channel shares is scattered by each vertex in its own color.
    item, notes = colored(tmp_path, np.eye(3), None)
    assert item.material.reflectance == 0
    close(scattered(item), np.eye(3))
    assert "metals mirror the mean of their colors at vertices (the default)" in notes
    half = {"pbrMetallicRoughness": {"metallicFactor": 0.5}}
    item, notes = colored(tmp_path, [[1, 1, 1], [0.5, 0.5, 0.5], [0, 0, 0]], half)
    assert item.material.reflectance == pytest.approx(0.5 * 0.04 + 0.5 * 0.5)
    assert item.material.albedo == pytest.approx((0.5, 0.5, 0.5))


def test_meshes_of_one_metal_have_their_own_colors(tmp_path: Path) -> None:
    gltf = Gltf()
    image = gltf.picture([[[255, 255, 255], [255, 255, 255]], [[255, 255, 255], [0, 0, 0]]])
    metal = {"pbrMetallicRoughness": {"baseColorTexture": {"index": image}}}
    uvs = gltf.array([[0, 0], [1, 0], [0, 1]])
    for level in (1.0, 0.5, 0.25):
        gltf.triangle(metal, TEXCOORD_0=uvs, COLOR_0=gltf.array([[level, level, level]] * 3))
    for mesh in gltf.document["meshes"]:
        mesh["primitives"][0]["material"] = 0
    items = gltf.read(tmp_path).scene.objects
    found = [item.material.reflectance for item in items]
    assert found == pytest.approx([0.75, 0.375, 0.1875])
    for item in items:
        assert isinstance(item.material.albedo, Texture)
        close(item.material.albedo.texels[0, 0], [0.25] * 3)

"""Scenes beyond a limit of the driver are drawn in parts, or refused by the limit's name."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest

from oitbench.errors import CapabilityError, SceneError
from oitbench.gl.device import Device
from oitbench.gl.frame import Image
from oitbench.gl.surface_textures import Pages
from oitbench.gl.uploaded_scene import UploadedScene
from oitbench.modeling.mesh import quad
from oitbench.scene import (
    Camera,
    DirectionalLight,
    EnvironmentLight,
    FragmentLists,
    Material,
    Medium,
    Mesh,
    Object,
    Scene,
    SpotLight,
    Texture,
    as_vector,
)
from oitbench.scene.texturing import Images, lookup, premultiplied_pyramid
from tests.helpers import Empty, opened, render

CAMERA = Camera((0, 0, 0), (0, 0, -1))
CORNERS = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]], dtype=np.float64)
TRIANGLES = np.array([[0, 1, 2], [0, 2, 3]], dtype=np.uint32)
SIDE = 64
"""Pixels along each side of a frame, one for each quad of a grid of 64 × 64."""
SHEET = quad((0, 0, -2), (1, 0, 0), (0, 1, 0))


@pytest.fixture
def limited(device: Device) -> Iterator[dict[str, int]]:
    """Yield the limits of the shared device; they are restored afterwards."""
    kept = dict(device.limits)
    yield device.limits
    device.limits.update(kept)


def tiles(materials: list[Material], uv: Any = CORNERS / 2 + 0.5) -> tuple[Object, ...]:
    """Return opaque quads that fill one pixel each, row by row from the top left."""
    scale = np.tan(CAMERA.fov_y / 2) * 2 / SIDE
    objects = []
    for number, material in enumerate(materials):
        row, column = divmod(number, SIDE)
        center = np.array([column + 0.5 - SIDE / 2, SIDE / 2 - row - 0.5])
        positions = np.column_stack([(center + CORNERS / 2) * scale, np.full(4, -1.0)])
        mesh = Mesh.from_arrays(positions, TRIANGLES, uvs=uv)
        objects.append(Object(str(number), mesh, material))
    return tuple(objects)


def shown(device: Device, scene: Scene) -> Image:
    """Return the first pixels of a frame of `SIDE` × `SIDE`, one for each object."""
    image = render(device, scene, Empty(), size=(SIDE, SIDE))
    return image.reshape(-1, 3)[: len(scene.objects)]


@pytest.mark.parametrize("count", [1, 1023, 1024, 1025, 3000])
def test_each_of_many_reflecting_materials_has_its_own_albedo(device: Device, count: int) -> None:
    random = np.random.default_rng(2).random((count, 3))
    materials = [Material(albedo=as_vector(albedo), specular=0.0) for albedo in random]
    scene = Scene("m", CAMERA, tiles(materials), lights=(EnvironmentLight((1.0, 1.0, 1.0)),))
    np.testing.assert_allclose(shown(device, scene), random, atol=2e-3)


def test_more_reflecting_materials_than_the_side_of_a_texture_are_drawn(device: Device) -> None:
    count = device.limits["GL_MAX_TEXTURE_SIZE"] + 1
    many = [Material(albedo=(0.1, 0.1, 0.1), specular=0.0) for _ in range(count - SIDE * SIDE)]
    hidden = tuple(Object(f"hidden {k}", SHEET, material) for k, material in enumerate(many))
    random = np.random.default_rng(3).random((SIDE * SIDE, 3))
    front = tiles([Material(albedo=as_vector(row), specular=0.0) for row in random])
    scene = Scene("m", CAMERA, hidden + front, lights=(EnvironmentLight((1.0, 1.0, 1.0)),))
    image = render(device, scene, Empty(), size=(SIDE, SIDE)).reshape(-1, 3)
    np.testing.assert_allclose(image, random, atol=2e-3)


def glowing(count: int, width: int, height: int) -> list[Material]:
    random = np.random.default_rng(count + width)
    texels = random.random((count, height, width, 3)).astype(np.float32)
    return [Material(emission=Texture(one)) for one in texels]


def expected(materials: list[Material], uv: tuple[float, float], level: float) -> Any:
    found = []
    for material in materials:
        assert isinstance(material.emission, Texture)
        pyramid = premultiplied_pyramid(Images(material.emission, None))
        found.append(lookup(pyramid, [uv], [level])[0, :3])
    return np.array(found)


@pytest.mark.parametrize("side", [64, 4, 1])
@pytest.mark.parametrize("size", [(4, 4), (8, 1), (1, 4), (5, 3)])
def test_textures_run_on_in_further_layers(
    device: Device, monkeypatch: pytest.MonkeyPatch, size: tuple[int, int], side: int
) -> None:
    monkeypatch.setattr(
        Pages, "of", lambda count, device: Pages(side, side, -(-count // (side * side)))
    )
    materials = glowing(8, *size)
    # A quad of one pixel that shows a small part of its texture, and one that shows all of it.
    for place, level in (((0.3, 0.55), 0.0), ((0.5, 0.5), float(np.log2(max(size))))):
        spread = 0.01 if level == 0 else 0.5
        scene = Scene("t", CAMERA, tiles(materials, uv=place + CORNERS * spread))
        wanted = expected(materials, place, level)
        np.testing.assert_allclose(shown(device, scene), wanted, atol=1e-4)


def test_many_textures_of_several_sizes_are_drawn(device: Device) -> None:
    count = device.limits["GL_MAX_ARRAY_TEXTURE_LAYERS"] + 1
    materials = [*glowing(count, 2, 2), *glowing(8, 3, 5)]
    scene = Scene("t", CAMERA, tiles(materials, uv=(0.25, 0.75) + CORNERS * 0.001))
    wanted = expected(materials, (0.25, 0.75), 0)
    np.testing.assert_allclose(shown(device, scene), wanted, atol=1e-3)


def test_materials_of_one_texture_share_its_texels(device: Device) -> None:
    coverage = Texture(np.full((2, 2), 0.5, dtype=np.float32))
    materials = [Material(coverage, emission=(float(k), 1.0, 2.0)) for k in range(50)]
    scene = Scene("t", CAMERA, tiles(materials), background=(0.0, 0.0, 4.0))
    with UploadedScene(device, scene) as uploaded:
        assert uploaded.geometry.textures["texture_levels"].size == (2, 1)
    found = render(device, scene, "a_buffer", size=(SIDE, SIDE)).reshape(-1, 3)[:50]
    wanted = np.column_stack([np.arange(50) / 2, np.full(50, 0.5), np.full(50, 3.0)])
    np.testing.assert_allclose(found, wanted, rtol=1e-6)


def test_pages_grow_as_the_textures_do(device: Device, limited: dict[str, int]) -> None:
    limited["GL_MAX_TEXTURE_SIZE"] = 9
    assert Pages.of(1, device) == Pages(1, 1, 1)
    assert Pages.of(20, device) == Pages(8, 3, 1)
    assert Pages.of(64, device) == Pages(8, 8, 1)
    assert Pages.of(65, device) == Pages(8, 8, 2)
    limited["GL_MAX_ARRAY_TEXTURE_LAYERS"] = 2
    with pytest.raises(CapabilityError, match="textures of 129 texels, mip levels included: 3 exc"):
        Pages.of(129, device)


def lit(*lights: Any, **parts: Any) -> Scene:
    shade = Object("shade", quad((0, 1, -2), (0.1, 0, 0), (0, 0, 0.1)), Material(coverage=0.5))
    return Scene("lit", CAMERA, (Object("sheet", SHEET, Material(albedo=(1.0, 1.0, 1.0))), shade),
                 lights=lights, **parts)  # fmt: skip


def lists(layers: int) -> FragmentLists:
    one = np.ones((layers, 1, 1, 3), dtype=np.float32)
    return FragmentLists(one[..., 0], one[..., 0], one, one)


TOO_MUCH: list[tuple[Scene, str, str]] = [
    (
        lit(EnvironmentLight(Texture(np.ones((2, 1 << 15), np.float32)))),
        "an environment of 32768x2 texels: 32768 exceeds GL_MAX_TEXTURE_SIZE, which is 16384",
        "GL_MAX_TEXTURE_SIZE",
    ),
    (
        lit(medium=Medium(0.1, (0, 0, 0), (1, 1, 1), density=np.ones((1, 1, 4096), np.float32))),
        "a medium of 4096x1x1 cells: 4096 exceeds GL_MAX_3D_TEXTURE_SIZE, which is 2048",
        "GL_MAX_3D_TEXTURE_SIZE",
    ),
    (
        lit(*[DirectionalLight((0, -1, 0))] * 500),
        "a scene of 500 directional and spot lights: 72160 exceeds GL_MAX_UNIFORM_BLOCK_SIZE",
        "GL_MAX_UNIFORM_BLOCK_SIZE",
    ),
    (
        lit(*[SpotLight((0, 3, 0), (0, 0, -2))] * 30),
        r"opaque.glsl \(textures\): 6\d exceeds GL_MAX_TEXTURE_IMAGE_UNITS, which is 32",
        "GL_MAX_TEXTURE_IMAGE_UNITS",
    ),
    (
        Scene("deep", CAMERA, lists=lists(9)),
        "fragment lists of 9 layers of 1x1: 5 exceeds GL_MAX_TEXTURE_SIZE, which is 4",
        "",
    ),
]


@pytest.mark.parametrize(("scene", "message", "limit"), TOO_MUCH, ids=[m for _, m, _ in TOO_MUCH])
def test_a_scene_beyond_a_limit_is_refused_with_its_name_and_value(
    device: Device, limited: dict[str, int], scene: Scene, message: str, limit: str
) -> None:
    known = {
        "GL_MAX_TEXTURE_SIZE": 16384, "GL_MAX_3D_TEXTURE_SIZE": 2048,
        "GL_MAX_UNIFORM_BLOCK_SIZE": 65536, "GL_MAX_TEXTURE_IMAGE_UNITS": 32,
    }  # fmt: skip
    if limit:
        if device.limits[limit] != known[limit]:
            pytest.skip(f"this driver has another {limit}")
    else:
        limited.update({"GL_MAX_ARRAY_TEXTURE_LAYERS": 2, "GL_MAX_TEXTURE_SIZE": 4})
    with (
        pytest.raises(CapabilityError, match=message),
        opened(device, scene, "phenomenological", (8, 8)) as frame,
    ):
        frame.render()


def test_more_textures_than_units_are_refused_though_the_driver_links_them(
    device: Device, limited: dict[str, int]
) -> None:
    limited["GL_MAX_TEXTURE_IMAGE_UNITS"] = 1
    match = r"opaque: \w+\.glsl \(textures\): \d exceeds GL_MAX_TEXTURE_IMAGE_UNITS"
    scene = lit(EnvironmentLight((1.0, 1.0, 1.0)))
    with (
        pytest.raises(CapabilityError, match=match),
        opened(device, scene, "phenomenological", (8, 8)) as frame,
    ):
        frame.render()


def work(device: Device, owner: str, slot: int) -> None:
    with device.checked(owner):
        device.call("glColorMaski", slot, 1, 1, 1, 1)


def test_errors_of_opengl_are_reported_where_they_occur(device: Device) -> None:
    with pytest.raises(CapabilityError, match=r"scene x: .* reports GL_INVALID_VALUE; it lacks"):
        work(device, "scene x", 10_000)
    work(device, "scene y", 0)
    device.call("glColorMaski", 10_000, 1, 1, 1, 1)
    work(device, "scene z", 0)  # the earlier error is not its fault


def test_a_frame_reports_errors_of_its_first_issue(
    device: Device, monkeypatch: pytest.MonkeyPatch
) -> None:
    scene = Scene("s", CAMERA, (Object("sheet", SHEET, Material(coverage=0.5)),))
    with opened(device, scene, "weighted_blended", (8, 8)) as frame:
        frame.render()
        original = device.clear

        def wrong(*arguments: Any) -> None:
            original(*arguments)
            device.call("glColorMaski", 10_000, 1, 1, 1, 1)

        monkeypatch.setattr(device, "clear", wrong)
        with pytest.raises(CapabilityError, match=r"weighted_blended at 8x8: .* GL_INVALID_VALUE"):
            frame.render()


def test_set_up_and_frames_cause_no_error_of_opengl(device: Device) -> None:
    with device.checked("all"):
        for chosen in ("a_buffer", "stochastic[msaa=4]", "depth_peeling"):
            render(device, lit(DirectionalLight((0, -1, 0))), chosen, size=(16, 16))


def test_measuring_again_and_again_creates_no_query(
    device: Device, monkeypatch: pytest.MonkeyPatch
) -> None:
    scene = Scene("s", CAMERA, (Object("sheet", SHEET, Material(coverage=0.5)),))
    with opened(device, scene, "depth_peeling", (8, 8)) as frame:
        frame.render()
        frame.measure()
        monkeypatch.setattr(device.context, "query", None)
        for _ in range(3):
            frame.measure()
            frame.restore()
            frame.composite()


@pytest.mark.parametrize(
    ("scene", "message"),
    [
        (Scene("s", Camera((0, 0, 1), fov_y=1e-39), tiles([Material()])), "the view of the scene"),
        (Scene("s", Camera((0, 0, 1), near=1e-40), tiles([Material()])), "camera: near is 1e-40 m"),
        (lit(medium=Medium(0.1, (0, 0, 0), (1, 1, 3e38))), None),
        (lit(SpotLight((0, 3e38, 0), (0, 0, 0))), "exceeds single precision"),
    ],
)
def test_numbers_beyond_single_precision_never_reach_a_shader(
    device: Device, scene: Scene, message: str | None
) -> None:
    if message is None:
        render(device, scene, "phenomenological", size=(8, 8))
        return
    with pytest.raises(SceneError, match=message):
        render(device, scene, "phenomenological", size=(8, 8))

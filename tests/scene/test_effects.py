"""Effects run if the scene requests them and the method expresses them; others cost nothing."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from oitbench.effects import Effect, names
from oitbench.errors import UsageError
from oitbench.gl.device import Device
from oitbench.matrix.cell import choose_effects
from oitbench.method.declaration import Method
from oitbench.modeling.mesh import quad
from oitbench.scene import (
    Camera,
    DirectionalLight,
    EnvironmentLight,
    Material,
    Medium,
    Mesh,
    Object,
    Scene,
    Texture,
)
from tests.helpers import (
    Layer,
    collection,
    foreign_method,
    method,
    opened,
    random_lists,
    render,
    scene_of,
    stack,
    write_method,
)

OPTIONAL = """
from oitbench import *


class Optional(Method):
    expresses = Effect.COVERAGE | Effect.DIFFUSION

    def plan(self, request):
        plain = Gather("plain.glsl", writes={"color": ADD})
        if Effect.DIFFUSION not in request.effects:
            gather = Gather("gather.glsl", writes={"sum": ADD})
            return Plan({"sum": Target("rgba16f")}, (gather, Interleaved((plain,))))
        targets = {"sum": Target("rgba16f"), "spread": Target("r32f")}
        gather = Gather("gather.glsl", writes={"sum": ADD, "spread": ADD})
        blur = Resolve("blur.glsl", reads=("spread",), writes={"sum": ADD}, buffers=("marks",))
        diffuse = Gather("diffuse.glsl", writes={"color": ADD})
        marks = {"marks": Buffer({"mark": "uint"}, Items.PIXELS)}
        return Plan(targets, (gather, blur, Interleaved((plain, diffuse))), marks)
"""
GATHER = """void gather(Fragment fragment) {
    sum = vec4(1.0);
#ifdef EFFECT_DIFFUSION
    spread = 1.0;
#endif
}"""
PLAIN = "void gather(Fragment fragment) { color = vec4(1.0); }"
BLUR = "void resolve() { set_marks_mark(pixel_index(), 1u); sum = vec4(read_spread()); }"


@pytest.fixture
def optional(tmp_path: Path) -> Method:
    """A method with a target, a buffer, a pass and half a step that only diffusion needs."""
    shaders = {"gather": GATHER, "blur": BLUR, "plain": PLAIN, "diffuse": PLAIN}
    folder = write_method(tmp_path / "optional", "()", **shaders)
    (folder / "method.py").write_text(OPTIONAL)
    return foreign_method(folder)


def scene(transparent: Material, **more: Any) -> Scene:
    camera = Camera(position=(0, 0, 0), target=(0, 0, -1))
    floor = Object("floor", quad((0, 0, -3), (1, 0, 0), (0, 1, 0)), Material())
    sheet = Object("sheet", quad((0, 0, -2), (1, 0, 0), (0, 1, 0)), transparent)
    return Scene("small", camera, objects=(floor, sheet), **more)


@pytest.mark.parametrize(
    ("material", "requested"),
    [
        (Material(), []),
        (Material(coverage=0.5), ["COVERAGE"]),
        (Material(transmission=(0.5, 0.5, 0.5)), ["COVERAGE"]),
        (Material(transmission=(0.5, 0.6, 0.5)), ["COVERAGE", "COLORED_TRANSMISSION"]),
        (Material(coverage=0.5, index=1.5, solid=True), ["COVERAGE", "REFRACTION"]),
        # A thin sheet has two sides, whose refractions cancel.
        (Material(coverage=0.5, index=1.5), ["COVERAGE"]),
        (Material(coverage=0.5, collimation=0.9), ["COVERAGE", "DIFFUSION"]),
        # No light passes an opaque surface, so that it neither refracts nor spreads light.
        (Material(index=1.5, collimation=0.5), []),
    ],
)
def test_materials_request_effects(material: Material, requested: list[str]) -> None:
    assert names(scene(material).effects) == requested


def test_lights_request_the_shadows_of_the_objects_in_the_scene() -> None:
    sun = (DirectionalLight((0.0, -1.0, 0.0)),)
    gray, red = (
        Material(coverage=0.5),
        Material(transmission=(0.9, 0.1, 0.1), index=1.5, solid=True),
    )
    shadows = ["SHADOWS", "TRANSLUCENT_SHADOWS"]
    assert names(scene(gray, lights=sun).effects) == ["COVERAGE", *shadows]
    assert names(scene(Material(), lights=sun).effects) == ["SHADOWS"]
    found = names(scene(red, lights=sun).effects)
    assert found[-4:] == [*shadows, "COLORED_SHADOWS", "CAUSTICS"]
    assert names(scene(gray, lights=(EnvironmentLight(),)).effects) == ["COVERAGE"]


def test_fog_and_foliage_request_their_effects() -> None:
    leaf = Material(coverage=0.5, binary_coverage=True)
    fog = Medium(0.1, (-1, -1, -3), (1, 1, 0))
    assert Effect.VOLUME in scene(leaf, medium=fog).effects
    assert Effect.INFERRED_AO in scene(leaf, ambient_occlusion=0.5).effects
    assert Effect.INFERRED_AO not in scene(leaf).effects


def test_lists_request_color_if_one_fragment_is_tinted() -> None:
    assert names(scene_of(random_lists(2)).effects) == ["COVERAGE"]
    assert "COLORED_TRANSMISSION" in names(scene_of(random_lists(2, tinted=True)).effects)


def test_an_effect_that_is_not_rendered_costs_nothing(device: Device, optional: Method) -> None:
    device.programs.clear()
    lists = scene_of(stack([Layer(2, 0.5)]))
    with opened(device, lists, optional, effects=Effect.COVERAGE) as frame:
        frame.render()
        assert {name for name, _ in frame.resources.memory()} == {"sum"}
        assert [step.name for step in frame.plan.passes] == ["gather", "plain"]
        sources = " ".join(fragment for _, fragment in device.programs)
        assert "DIFFUSION 1" not in sources
        assert "out float spread" not in sources


def test_a_rendered_effect_has_all_its_resources(device: Device, optional: Method) -> None:
    device.programs.clear()
    lists = scene_of(stack([Layer(2, 0.5)]))
    with opened(device, lists, optional, effects=Effect.DIFFUSION) as frame:
        frame.render()
        assert {name for name, _ in frame.resources.memory()} == {"sum", "spread", "marks"}
        assert [step.name for step in frame.plan.passes] == ["gather", "blur", "plain", "diffuse"]
        sources = " ".join(fragment for _, fragment in device.programs)
        assert "#define EFFECT_DIFFUSION 1" in sources
        assert (frame.read("spread") == 1).all()


@pytest.mark.parametrize("name", collection().methods)
def test_forcing_every_effect_changes_no_pixel(device: Device, name: str) -> None:
    lists, chosen = random_lists(6), method(name)
    requested = render(device, lists, chosen)
    forced = render(device, lists, chosen, effects=~Effect.NONE & chosen.shows)
    np.testing.assert_array_equal(requested, forced)


def test_effects_are_chosen_by_name() -> None:
    requested = Effect.COVERAGE | Effect.DIFFUSION | Effect.REFRACTION
    assert choose_effects("requested", requested) == requested
    assert choose_effects("none", requested) is Effect.NONE
    assert all(effect in choose_effects("all", requested) for effect in Effect)
    assert choose_effects("-diffusion, -refraction", requested) == Effect.COVERAGE
    with pytest.raises(UsageError, match="unknown effect 'difusion'; did you mean diffusion"):
        choose_effects("-difusion", requested)
    with pytest.raises(UsageError, match="give requested, all, none, or -NAME"):
        choose_effects("diffusion", requested)


GRAY, RED = (
    Texture(np.full((2, 2, 3), color, np.float32)) for color in ((0.5, 0.5, 0.5), (0.9, 0.1, 0.1))
)
THREE = np.array([[1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 1, 1]], np.float32)


@pytest.mark.parametrize(
    ("material", "vertices", "tinted"),
    [
        (Material(transmission=GRAY), {}, False),
        (Material(transmission=Texture(np.ones((2, 2), np.float32))), {}, False),
        (Material(transmission=RED), {}, True),
        (Material(transmission=(1.0, 1.0, 1.0), albedo=RED), {}, True),
        (Material(transmission=(1.0, 1.0, 1.0), albedo=(0.5, 0.5, 0.5)), {"albedo": THREE}, True),
        (Material(transmission=(1.0, 1.0, 1.0)), {"transmission": THREE}, True),
        (Material(transmission=(1.0, 1.0, 1.0)), {"transmission": 0.5 * np.ones((4, 3))}, False),
    ],
)
def test_what_varies_may_tint(material: Material, vertices: Any, tinted: bool) -> None:
    mesh = quad((0, 0, -2), (1, 0, 0), (0, 1, 0))
    given = {name: np.asarray(values, np.float32) for name, values in vertices.items()}
    mesh = Mesh.from_arrays(mesh.positions, mesh.triangles, uvs=mesh.uvs, **given)
    one = Object("sheet", mesh, material)
    assert one.tints == tinted
    found = Scene("s", Camera((0, 0, 0), (0, 0, -1)), (one,)).effects
    assert (Effect.COLORED_TRANSMISSION in found) == tinted


def test_a_surface_with_a_cutoff_is_opaque_where_it_is() -> None:
    mesh = quad((0, 0, -2), (1, 0, 0), (0, 1, 0))
    faded = replace(mesh, coverage=np.array([0, 1, 1, 0], np.float32))
    holes = Texture(np.array([[0, 1]], np.float32))
    assert not Material(holes).opaque
    assert Material(holes, cutoff=0.5).opaque
    assert not Material(holes, (0.1, 0.0, 0.0), cutoff=0.5).opaque
    assert not Material(holes, RED, cutoff=0.5).opaque
    assert Object("x", mesh, Material()).opaque
    assert not Object("x", faded, Material()).opaque
    assert Object("x", faded, Material(cutoff=0.5)).opaque
    leaf = Object("x", mesh, Material(holes, cutoff=0.5))
    assert Scene("s", Camera((0, 0, 0), (0, 0, -1)), (leaf,)).effects == Effect.NONE

"""Scenes as other engines draw them."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from oitbench.engines.content import unlit
from oitbench.errors import SceneError
from oitbench.modeling.mesh import quad
from oitbench.scene import (
    WHITE,
    Camera,
    DirectionalLight,
    EnvironmentLight,
    Material,
    Object,
    Scene,
    Texture,
)
from tests.helpers import collection

WHITE_TEXTURE = Texture(np.ones((2, 2), np.float32))


def pane(scene: dict[str, Any] | None = None, **material: Any) -> Scene:
    """Return a scene of one pane, 2 m in front of the camera."""
    item = Object("pane", quad((0, 0, -2), (1, 0, 0), (0, 1, 0)), Material(**material))
    return Scene("panes", Camera((0, 0, 0), (0, 0, -1)), (item,), **(scene or {}))


@pytest.mark.parametrize(("kind", "layer"), [("none", 0.5), ("gray", 0.2)])
def test_blending_the_content_gives_the_closed_form(kind: str, layer: float) -> None:
    scene = collection().build_scene(f"layer_stack[count=4,order=far_first,transmission={kind}]")
    content = unlit(scene, 8, brightest=10.0)
    color = expected = np.array(content.background)
    for item, surface in zip(scene.objects, content.surfaces, strict=True):
        assert surface.even
        opacity = float(surface.opacity[0])
        assert opacity == pytest.approx(layer)
        color = opacity * surface.color[0] + (1 - opacity) * color
        alpha, clear = float(item.material.coverage), item.material.transmission[0]  # type: ignore
        light = alpha * np.array(item.material.emission)
        expected = light + (1 - alpha + alpha * clear) * expected
    np.testing.assert_allclose(color, expected, atol=1e-6)


def test_factors_at_vertices_become_colors_and_opacities() -> None:
    mesh = quad((0, 0, -2), (1, 0, 0), (0, 1, 0))
    factors = {
        "coverage": np.array([0, 0.5, 1, 1], np.float32),
        "radiance": np.array([[1, 1, 1], [0.5, 1, 1], [1, 1, 1], [1, 1, 1]], np.float32),
    }
    shaded = type(mesh)(mesh.positions, mesh.triangles, mesh.uvs, **factors)
    material = Material(coverage=0.5, emission=(0.2, 0.4, 0.6))
    scene = Scene("s", Camera((0, 0, 0), (0, 0, -1)), (Object("o", shaded, material),))
    (surface,) = unlit(scene, 8, 1.0).surfaces
    assert not surface.even
    np.testing.assert_allclose(surface.opacity, [0, 0.25, 0.5, 0.5])
    np.testing.assert_allclose(surface.color[1], [0.1, 0.4, 0.6], rtol=1e-6)


def test_a_far_plane_lies_behind_everything() -> None:
    assert unlit(pane(), 8, 1.0).camera.far == pytest.approx(2.02)


@pytest.mark.parametrize(
    ("scene", "reason"),
    [
        (pane(transmission=(0.1, 0.5, 0.5)), "panes: it requests colored_transmission;"),
        (pane({"lights": (DirectionalLight((0, 0, -1), (1, 1, 1)),)}, coverage=0.5), "it requests"),
        (pane({"lights": (EnvironmentLight(WHITE),)}), "panes: it has lights;"),
        (pane(coverage=WHITE_TEXTURE), "pane: it has a texture of coverage,"),
        (pane(cutoff=0.5, coverage=0.7), "pane: it has a cutoff,"),
        (pane(coverage=0.5, culled=True), "pane: it has no back,"),
        (pane(transmission=(0.5, 0.5, 0.5), albedo=(0.5, 0.5, 0.5)), "pane: it has albedo or"),
        (pane(transmission=(0.5, 0.5, 0.5), index=1.5), "pane: it has albedo or"),
        (pane(transmission=(1, 1, 1), emission=(1, 1, 1)), "pane: it adds light but hides none"),
        (pane(coverage=0.5, emission=(1.5, 0, 0)), "panes: its layers are up to 1.5 bright"),
    ],
)
def test_what_engines_do_not_draw_is_refused(scene: Scene, reason: str) -> None:
    with pytest.raises(SceneError, match=reason):
        unlit(scene, 8, brightest=1.0)


def test_fragment_lists_are_refused() -> None:
    with pytest.raises(SceneError, match="its fragment lists have no geometry"):
        unlit(collection().build_scene("fragment_lists"), 8, 1.0)

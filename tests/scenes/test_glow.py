"""Glow: light that is added exactly, before and behind smoke and dark glass."""

from __future__ import annotations

import numpy as np
import pytest

from oitbench.scene import Object, Scene, Sprites, Texture
from oitbench.scene.texturing import constant
from tests.scenes.helpers import build, named, particles, starting


def adding(scene: Scene) -> list[Object]:
    """Return the objects that add light."""
    return [item for start in ("flames", "embers", "halo") for item in starting(scene, start)]


def light(item: Object) -> float:
    """Return the added light of an object: α L, summed over texels and sprites."""
    coverage, emission = item.material.coverage, item.material.emission
    assert isinstance(coverage, Texture)
    assert isinstance(item.mesh, Sprites)
    each = emission.texels if isinstance(emission, Texture) else np.asarray(emission)
    picture = (coverage.texels[..., None] * each).mean()
    return float(picture * (np.asarray(item.mesh.radii) ** 2).sum())


def test_light_is_added_and_hides_nothing() -> None:
    scene = build("glow[detail=0.1]")
    assert len(adding(scene)) == 6
    for item in adding(scene):
        material = item.material
        assert material.transmission == (1, 1, 1)
        assert material.reflectance == 0
        assert max(constant(material.albedo)) == 0
        assert isinstance(material.coverage, Texture)
        assert material.coverage.texels.max() > 0.2


def test_opacity_lets_light_hide_what_is_behind() -> None:
    for item in adding(build("glow[detail=0.1,opacity=0.75]")):
        assert item.material.transmission == (0.25, 0.25, 0.25)


def test_the_light_of_the_fire_does_not_depend_on_detail() -> None:
    for name in ("flames 0", "embers"):
        coarse, fine = (light(named(build(f"glow[detail={d}]"), name)) for d in (0.5, 4))
        assert coarse == pytest.approx(fine, rel=0.15)


def test_absorbing_layers_are_before_and_behind_the_flames() -> None:
    scene = build("glow")
    (smoke,) = particles(scene)
    assert isinstance(smoke.mesh, Sprites)
    flames = named(scene, "flames 0").mesh
    assert isinstance(flames, Sprites)
    depths = scene.camera.view_distance(np.asarray(flames.centers))
    spread = scene.camera.view_distance(np.asarray(smoke.mesh.centers))
    assert (spread < np.median(depths)).mean() > 0.1
    assert (spread > np.median(depths)).mean() > 0.3
    for label, before in (("front pane", True), ("back pane", False)):
        pane = scene.camera.view_distance(named(scene, label).mesh.positions)
        assert (pane < depths.min()).all() if before else (pane > depths.max()).all()
        assert max(constant(named(scene, label).material.transmission)) < 0.5


def test_smoke_drifts_before_the_sign() -> None:
    scene = build("glow")
    sign = named(scene, "halo O").mesh.positions
    (smoke,) = particles(scene)
    assert isinstance(smoke.mesh, Sprites)
    centers = np.asarray(smoke.mesh.centers)
    over = (centers[:, 1] > sign[:, 1].min()) & (centers[:, 2] > sign[:, 2].max())
    assert over.mean() > 0.2

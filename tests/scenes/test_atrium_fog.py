"""Atrium: fog whose effect has a closed form, and paints at several distances."""

from __future__ import annotations

import numpy as np

from tests.scenes.helpers import build, named, view_distances


def test_the_effect_of_the_fog_has_a_closed_form() -> None:
    scene = build("atrium_fog[detail=0.1]")
    assert scene.lights == (scene.environment,)
    assert all(item.mesh.radiance is not None for item in scene.objects)
    fog = scene.medium
    assert fog is not None
    assert fog.density is None
    assert fog.anisotropy == 0
    assert fog.collimation == 1


def test_banners_of_one_paint_hang_at_several_distances() -> None:
    scene = build("atrium_fog[detail=0.1]")
    for paint in ("red", "blue", "green"):
        mesh = named(scene, f"{paint} banners").mesh
        assert len(np.unique(mesh.positions[:, 2])) >= 3
        assert np.ptp(view_distances(scene, mesh)) > 6

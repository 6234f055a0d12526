"""Foliage: thousands of binary leaves, with baked light or under a sun and a sky."""

from __future__ import annotations

from oitbench.scene import Texture
from oitbench.scene.texturing import constant
from tests.scenes.helpers import build


def test_foliage_is_thousands_of_binary_leaves() -> None:
    scene = build("foliage")
    assert all(item.material.binary_coverage for item in scene.transparent)
    assert sum(len(item.mesh.triangles) for item in scene.transparent) / 8 > 4000
    for item in scene.transparent:
        mask = item.material.coverage
        assert isinstance(mask, Texture)
        # Only texels at the outline are partly covered.
        assert ((mask.texels > 0) & (mask.texels < 1)).mean() < 0.1
        assert 0.2 < mask.texels.mean() < 0.8


def test_sun_and_sky_replace_baked_light() -> None:
    baked, lit = build("foliage[detail=0.1]"), build("foliage[detail=0.1,light=sky]")
    assert all(item.mesh.radiance is not None for item in baked.objects)
    assert all(any(constant(item.material.albedo)) for item in lit.objects)
    assert all(item.material.binary_coverage for item in lit.transparent)
    assert lit.beams
    assert lit.environment is not None

"""People: heights, and normals of bodies and limbs."""

from __future__ import annotations

import pytest

from oitbench.modeling.props.people import hand, limb, man, woman
from oitbench.scene import Mesh
from tests.meshes import agreement, has_unit_normals


@pytest.mark.parametrize(
    "part",
    [
        woman(1),
        man(1),
        hand((0.1, 1.4, -0.2), 1),
        limb((0, 0, 0), (0.1, -0.5, 0.2), 0.05, 0.03, 1),
        limb((0, 0.5, 0), (0, 0, 0), 0.05, 0.03, 1),
    ],
    ids=["woman", "man", "hand", "slanted limb", "limb downwards"],
)
def test_normals_fit_the_triangles(part: Mesh) -> None:
    assert has_unit_normals(part)
    # Where a profile turns sharply, its smooth normals round the edge off.
    assert (agreement(part).sum(axis=1) > 0).mean() > 0.97


def test_people_stand_on_the_ground_at_their_heights() -> None:
    for figure, height in ((woman(1), 1.78), (man(1), 1.88)):
        low, high = figure.positions[:, 1].min(), figure.positions[:, 1].max()
        assert 0 <= low < 0.06
        assert high == pytest.approx(height, abs=0.03)

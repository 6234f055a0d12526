"""People: heights, and normals of bodies and limbs."""

from __future__ import annotations

import pytest

from oitbench.modeling.props.people import Figure, hand, limb, man, woman
from oitbench.scene import Mesh
from tests.meshes import agreement, bounds, count_hits, has_unit_normals, hits


@pytest.mark.parametrize(
    "part",
    [
        woman(1).whole(),
        man(1).whole(),
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
        low, high = (edge[1] for edge in bounds(figure.whole()))
        assert 0 <= low < 0.06
        assert high == pytest.approx(height, abs=0.03)


@pytest.mark.parametrize(("figure", "height"), [(woman(1), 1.6), (man(1), 1.68)])
def test_a_face_is_round_and_bare_in_front_with_hair_behind(figure: Figure, height: float) -> None:
    """From the front, skin is nearest in the middle of the face; from behind, hair is."""
    for z, nearest in ((1.0, figure.skin), (-1.0, figure.hair)):
        first = {
            id(part): hits(part, (0.0, height, z), (0.0, 0.0, -z))[0]
            for part in (figure.skin, figure.hair)
        }
        assert min(first, key=lambda part: first[part]) == id(nearest)
    # The face bulges: its cheeks are farther back than its middle, and its chin is narrow.
    front = [hits(figure.skin, (x, height, 1.0), (0.0, 0.0, -1.0))[0] for x in (0.02, 0.04, 0.06)]
    assert front == sorted(front)
    assert front[-1] - front[0] > 0.02
    chin = count_hits(figure.skin, [(0.07, height - 0.1, 1.0)], (0.0, 0.0, -1.0))
    assert chin == 0

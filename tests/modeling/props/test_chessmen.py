"""Chess pieces: heights and shapes."""

from __future__ import annotations

import numpy as np
import pytest

from oitbench.modeling.props import chessmen


def test_pieces_stand_on_the_board_with_heights_in_the_usual_order() -> None:
    heights = {}
    for name in chessmen.PIECES:
        mesh = chessmen.piece(name, 0.09, 0.3)
        assert mesh.positions[:, 1].min() == 0
        heights[name] = float(mesh.positions[:, 1].max())
    assert heights["king"] == pytest.approx(0.09)
    assert sorted(heights, key=heights.__getitem__) == [
        "pawn",
        "rook",
        "knight",
        "bishop",
        "queen",
        "king",
    ]


def test_the_knight_faces_forward_and_other_pieces_are_round() -> None:
    for name in ("pawn", "bishop", "queen"):
        radii = np.hypot(*chessmen.piece(name, 1.0, 0.3).positions[:, [0, 2]].T)
        assert len(np.unique(radii.round(5))) < len(radii) / 4
    head = chessmen.piece("knight", 1.0, 1.0).positions
    high = head[head[:, 1] > 0.38]
    assert high[:, 0].max() > 0.2
    assert high[:, 0].min() > -0.15
    assert np.abs(high[:, 2]).max() < 0.08


def test_a_rook_has_its_notches() -> None:
    mesh = chessmen.piece("rook", 1.0, 1.0)
    rim = mesh.positions[np.hypot(mesh.positions[:, 0], mesh.positions[:, 2]) > 0.11]
    angle = np.arctan2(rim[:, 2], rim[:, 0]).round(4)
    tops = np.array([rim[angle == a, 1].max() for a in np.unique(angle)]) > 0.56
    assert (tops != np.roll(tops, 1)).sum() == 2 * chessmen.NOTCHES

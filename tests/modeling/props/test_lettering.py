"""Lettering: normals, size, and letters without a glyph."""

from __future__ import annotations

import numpy as np
import pytest

from oitbench.modeling.props.lettering import lettering
from tests.meshes import agreement, bounds, has_unit_normals


def test_letters_face_forward_around_their_center() -> None:
    text = lettering("PRIVATE EYE", (1, 2, 3), 0.2, 0.03)
    assert has_unit_normals(text)
    assert text.normals is not None
    assert (text.normals[:, 2] == 1).all()
    assert (agreement(text) > 0).all()
    low, high = bounds(text)
    np.testing.assert_allclose((low + high) / 2, (1, 2, 3), atol=0.01)
    # Slanted strokes end a little beyond the height.
    assert high[1] - low[1] == pytest.approx(0.2, abs=0.015)


def test_letters_without_a_glyph_are_refused() -> None:
    with pytest.raises(ValueError, match="glyph for Q"):
        lettering("QUIET", (0, 0, 0), 0.2, 0.03)

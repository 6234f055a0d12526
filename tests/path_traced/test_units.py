"""The path tracer renders one picture of a scene in all units, and at all places in the world."""

from __future__ import annotations

import numpy as np
import pytest

from oitbench.path_traced.trace.render import render
from tests.gl.test_units import toy
from tests.path_traced.agreement import needs_mitsuba

SIZE = (16, 12)


@needs_mitsuba
@pytest.mark.parametrize(("unit", "at"), [(1e-3, 0.0), (1e3, 0.0), (1.0, 1e6), (1e-3, 1e6)])
def test_a_scene_looks_the_same_in_all_units_and_places(unit: float, at: float) -> None:
    expected = render(toy(), SIZE, 2, 4)
    found = render(toy(unit, at), SIZE, 2, 4)
    # The random numbers are the same, so that only roundings differ.
    difference = np.abs(found.mean - expected.mean).max(axis=-1)
    assert np.median(difference) < 1e-4
    assert np.sqrt(((found.mean - expected.mean) ** 2).mean()) < 0.02
    np.testing.assert_allclose(found.mean.mean(), expected.mean.mean(), rtol=0.01)

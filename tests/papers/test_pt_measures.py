"""What figures of phenomenological transparency measure in their pictures."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from oitbench.image.files import Image
from oitbench.papers import Picture
from tests.helpers import collection

CAUSTICS = collection().reports["pt_figure10"]
PANES = collection().reports["pt_figure08"]
MAP = collection().reports["pt_figure11"]


def gray(values: np.ndarray) -> Image:
    return np.repeat(np.asarray(values, np.float32)[..., None], 3, axis=2)


@pytest.mark.parametrize(("peak", "wanted"), [(1.5, [True, True]), (1.01, [True, False])])
def test_caustics_are_gains_of_light_in_the_lower_half(peak: float, wanted: list[bool]) -> None:
    dull = gray(np.full((8, 4), 0.5))
    bright = {part: dull.copy() for part in CAUSTICS.PARTS}
    bright["index_10"][0] *= 3  # the ball itself
    bright["index_13"][6, 1:3] *= peak
    bright["index_15"][6, 1] *= peak

    def image(picture: Picture) -> Image:
        return dull if picture.effects == "-caustics" else bright[picture.crop]

    flat, middle, sharp, size = CAUSTICS._findings(SimpleNamespace(image=image))
    assert [flat.holds, middle.holds] == wanted
    assert sharp.holds is middle.holds
    assert size.text.endswith("(0.062 against 0.125)")
    assert size.holds is True


def test_contrast_is_relative_to_the_first_part() -> None:
    stripes = np.tile([0.0, 1.0], (4, 2))
    pictures = {"first_box": gray(stripes), "last_box": gray(0.4 * stripes)}

    def shown(picture: Picture) -> Image:
        return pictures[picture.crop]

    album = SimpleNamespace(shown=shown)
    assert PANES._kept(album, PANES.OURS, ("first_box", "last_box")) == pytest.approx(0.4)
    pictures["last_box"] = pictures["last_box"][:, :1]
    assert PANES._kept(album, PANES.OURS, ("first_box", "last_box")) is None


def test_a_screen_door_has_neighbors_that_differ() -> None:
    texels = gray(np.array([[0, 0, 0, 0.5, 0.7], [0, 0.5, 0, 0, 0]]))
    album = SimpleNamespace(shown=lambda picture: texels)
    assert MAP._broken(album, MAP.CAUSTIC) == pytest.approx(3 / 8)

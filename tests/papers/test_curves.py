"""The pixel of a figure's curves: chosen by its fragments, its light and the part that is shown."""

from __future__ import annotations

from pathlib import Path

import msgspec
import numpy as np
import pytest

from oitbench.image import files, stored
from oitbench.measure.visibility import Curves
from oitbench.papers import Album, Picture, needs_of
from oitbench.papers.curves import curves_at, pixel_with
from oitbench.results.schema import COMPLEXITY, TRANSMITTANCE
from tests.papers.made_up import context, made
from tests.report.made_up import SIDE

FOG = Picture("fog[n=2]", "glow")
NEEDS = needs_of([FOG])


def album_of(folder: Path) -> Album:
    """Return an album whose picture has more fragments below, and is darker to the right."""
    record = made(folder, NEEDS[0])
    assert record.outcome is not None
    counts = np.repeat(np.arange(SIDE)[:, None], SIDE, axis=1)
    light = np.broadcast_to(np.linspace(0.9, 0, SIDE)[None, :, None], (SIDE, SIDE, 3))
    images = {
        COMPLEXITY: stored.store(folder, f"images/{COMPLEXITY}", files.count_channels(counts)),
        TRANSMITTANCE: stored.store(
            folder, f"images/{TRANSMITTANCE}", files.image_channels(light.astype(np.float32))
        ),
    }
    outcome = msgspec.structs.replace(record.outcome, images=record.outcome.images | images)
    crops = {"fog": {"left": (0.0, 0.0, 0.5, 0.75)}}
    return Album(context(folder, [msgspec.structs.replace(record, outcome=outcome)], crops), NEEDS)


def test_a_pixel_has_so_many_fragments_and_a_little_light(tmp_path: Path) -> None:
    album = album_of(tmp_path)
    # Light falls by 0.06 in each column, to 0.18 in the twelfth and 0.12 in the thirteenth.
    assert pixel_with(album, FOG, 5, 5) in ((12, 5), (13, 5))
    assert pixel_with(album, FOG, 0.9, 1) in ((12, 14), (13, 14))
    assert pixel_with(album, FOG, 99, 100) is None


def test_a_pixel_is_inside_of_the_part(tmp_path: Path) -> None:
    part = FOG.part("left")
    assert pixel_with(album_of(tmp_path), part, 5, 5) == (7, 5)
    assert pixel_with(album_of(tmp_path), part, 13, 13) is None


def test_without_counts_there_is_no_pixel(tmp_path: Path) -> None:
    record = made(tmp_path, NEEDS[0])
    assert pixel_with(Album(context(tmp_path, [record]), NEEDS), FOG, 0, 1) is None
    assert pixel_with(Album(context(tmp_path, []), NEEDS), FOG, 0, 1) is None


def test_curves_are_those_of_the_cell(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[object] = []

    def measure(*arguments: object) -> Curves:
        asked.extend(arguments)
        raise KeyboardInterrupt

    monkeypatch.setattr("oitbench.papers.curves.measure", measure)
    with pytest.raises(KeyboardInterrupt):
        curves_at(album_of(tmp_path), FOG, (3, 4), ["a"])
    assert asked == ["fog[n=2]", (3, 4), ["a"], (SIDE, SIDE)]

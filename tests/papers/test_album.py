"""The pictures of a figure: found by name, of one size, in parts, and with reasons if missing."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from oitbench.errors import DeclarationError
from oitbench.papers import Album, Picture, needs_of
from oitbench.papers.album import reduced
from oitbench.truths import EXACT, MATCHED
from tests.papers.made_up import context, made
from tests.report.made_up import SIDE, unfinished

GLOW, MURK = Picture("fog", "glow"), Picture("fog", "murk[n=2]")
NEEDS = needs_of([GLOW, MURK])


def test_needs_name_each_cell_once_with_all_truths() -> None:
    pictures = [
        GLOW,
        None,
        replace(GLOW, truth=MATCHED),
        replace(GLOW, truth=EXACT),
        GLOW.part("a"),
    ]
    (need,) = needs_of(pictures)
    assert (need.scene, need.method, need.view, need.effects) == (
        "fog",
        "glow",
        "main",
        "requested",
    )
    assert need.truths == (MATCHED,)


def test_all_cells_have_the_size_that_most_of_them_have(tmp_path: Path) -> None:
    large = made(tmp_path, NEEDS[0], 0.5, size=(64, 64))
    records = [large, *(made(tmp_path, need) for need in NEEDS)]
    album = Album(context(tmp_path, records), NEEDS)
    assert album.record(GLOW) is records[1]
    assert Album(context(tmp_path, records[:2]), NEEDS).record(GLOW) is large


def test_a_picture_is_that_of_its_view_effects_and_shading(tmp_path: Path) -> None:
    picture = Picture("fog", "glow", view="side", effects="-shadows", shading="slices=8")
    needs = needs_of([picture])
    other = needs_of([replace(picture, view="main")])[0]
    album = Album(context(tmp_path, [made(tmp_path, other), made(tmp_path, needs[0])]), needs)
    record = album.record(picture)
    assert record is not None
    assert (record.view, record.effects, record.shading) == ("side", "-shadows", "slices=8")


def test_truths_and_pictures_are_told_apart(tmp_path: Path) -> None:
    album = Album(context(tmp_path, [made(tmp_path, NEEDS[0], 0.5)]), NEEDS)
    drawn, truth = album.image(GLOW), album.image(replace(GLOW, truth=MATCHED))
    assert drawn is not None
    assert truth is not None
    np.testing.assert_allclose(drawn, truth / 2, rtol=1e-3)
    assert replace(GLOW, label="Glow").traced == replace(GLOW, truth=MATCHED)


def test_a_part_is_cut_from_the_picture(tmp_path: Path) -> None:
    crops = {"fog": {"low": (0.5, 0.75, 0.25, 0.25), "far@side": (0.0, 0.0, 0.5, 0.5)}}
    album = Album(context(tmp_path, [made(tmp_path, NEEDS[0])], crops), NEEDS)
    whole, part = album.image(GLOW), album.image(GLOW.part("low"))
    assert whole is not None
    assert part is not None
    np.testing.assert_array_equal(part, whole[12:16, 8:12])
    with pytest.raises(DeclarationError, match="unknown crop of fog 'far'; known: low"):
        album.image(GLOW.part("far"))


def test_the_distance_of_equal_pictures_is_zero(tmp_path: Path) -> None:
    records = [made(tmp_path, NEEDS[0], 0.3), made(tmp_path, NEEDS[1], 0.3)]
    album = Album(context(tmp_path, records), NEEDS)
    assert album.distance(GLOW, MURK) == 0
    assert (album.distance(GLOW, replace(MURK, truth=EXACT)) or 0) > 0.01
    assert album.distance(GLOW, Picture("fog", "none")) is None


def test_larger_pictures_are_reduced_for_a_comparison() -> None:
    large = np.arange(4 * 6 * 3, dtype=np.float32).reshape(4, 6, 3)
    small = reduced(large, np.zeros((2, 3, 3), np.float32))
    np.testing.assert_allclose(small[0, 0], large[:2, :2].mean(axis=(0, 1)))
    assert small.shape == (2, 3, 3)
    assert reduced(large, np.zeros((2, 4, 3), np.float32)) is large
    assert reduced(small, large) is small


def test_what_is_missing_has_a_reason(tmp_path: Path) -> None:
    failed = unfinished("fog", "murk[n=2]", "failed", "no shader")
    record = made(tmp_path, NEEDS[0], traced=False)
    album = Album(context(tmp_path, [record, failed]), [*NEEDS, *needs_of([Picture("hill", "a")])])
    assert album.why(Picture("hill", "a")) == "not in these results"
    assert album.why(MURK) == "failed: no shader"
    assert album.why(replace(GLOW, truth=MATCHED)) == "no geometry"
    assert [need.method for need in album.lacking] == ["murk[n=2]", "a"]
    assert album.shown(MURK) is None


def test_the_page_of_a_paper_may_show_a_variant(tmp_path: Path) -> None:
    variant = replace(GLOW, method="glow[n=1]")
    needs = needs_of([GLOW])
    records = [made(tmp_path, needs[0]), made(tmp_path, needs_of([variant])[0])]
    album = Album(context(tmp_path, records, variants={"glow": "glow[n=1]"}), needs)
    assert album.record(GLOW) is records[1]
    assert album.lacking == []


def test_a_target_is_drawn_as_its_cell_was(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    calls: list[tuple[object, ...]] = []

    srgb = np.full((SIDE, SIDE, 3), 0.25, np.float32)
    drawn = SimpleNamespace(picture=SimpleNamespace(srgb=srgb))

    def draw(*arguments: object, **named: object) -> list[SimpleNamespace]:
        calls.append((*arguments, named))
        return [drawn]

    monkeypatch.setattr("oitbench.matrix.targets.draw", draw)
    picture = Picture("fog", "glow", target="beta", view="side", shading="slices=8", crop="low")
    needs = needs_of([picture])
    crops = {"fog": {"low@side": (0.0, 0.0, 0.5, 0.5)}}
    album = Album(context(tmp_path, [made(tmp_path, needs[0])], crops), needs)
    image = album.shown(picture)
    assert image is not None
    assert image.shape == (SIDE // 2, SIDE // 2, 3)
    named = {"shading": ["slices=8"], "view": "side"}
    assert calls == [("fog", "glow", ["beta"], (SIDE, SIDE), 1, "requested", named)]

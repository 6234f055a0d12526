"""Captions: their verdicts follow from the results."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from oitbench.papers import (
    Album,
    Finding,
    Picture,
    alike,
    caption,
    darker,
    even,
    faithful,
    less,
    nearer,
    needs_of,
    unlike,
)
from oitbench.truths import EXACT
from tests.papers.made_up import context, made

GLOW, MURK = Picture("fog", "glow"), Picture("fog", "murk")
NEEDS = needs_of([GLOW, MURK])


def album_of(folder: Path, glow: float, murk: float) -> Album:
    records = [made(folder, NEEDS[0], glow), made(folder, NEEDS[1], murk)]
    return Album(context(folder, records), NEEDS)


@pytest.mark.parametrize(("murk", "word"), [(0.5, "Reproduced"), (0.1, "Not reproduced")])
def test_the_verdict_changes_with_the_errors(tmp_path: Path, murk: float, word: str) -> None:
    album = album_of(tmp_path, 0.2, murk)
    text = caption(album, "Two fogs.", [nearer(album, GLOW, [MURK], EXACT, "glow is nearer")])
    errors = [album.error(picture, EXACT) or 0 for picture in (GLOW, MURK)]
    assert (
        text == f"Two fogs. {word}: glow is nearer (FLIP {errors[0]:.4f} against {errors[1]:.4f})."
    )


def test_equal_errors_are_no_better(tmp_path: Path) -> None:
    album = album_of(tmp_path, 0.2, 0.2)
    assert nearer(album, GLOW, [MURK], EXACT, "").holds is False


def test_likeness_is_measured_between_pictures(tmp_path: Path) -> None:
    same, apart = album_of(tmp_path, 0.3, 0.3), album_of(tmp_path, 0.3, 0.9)
    assert [alike(same, GLOW, MURK, "").holds, unlike(same, GLOW, MURK, "").holds] == [True, False]
    assert [alike(apart, GLOW, MURK, "").holds, unlike(apart, GLOW, MURK, "").holds] == [
        False,
        True,
    ]


def test_faithful_pictures_have_a_small_error(tmp_path: Path) -> None:
    album = album_of(tmp_path, 0.0, 0.9)
    assert faithful(album, GLOW, EXACT, "").holds is True
    assert faithful(album, MURK, EXACT, "").holds is False


@pytest.mark.parametrize(("glow", "murk", "dark"), [(0.5, 0.1, True), (0.1, 0.5, False)])
def test_tones_are_compared(tmp_path: Path, glow: float, murk: float, dark: bool) -> None:
    album = album_of(tmp_path, glow, murk)
    found = darker(album, GLOW, MURK, "glow is darker")
    tones = [album.tone(picture) for picture in (GLOW, MURK)]
    assert found.text == (
        f"glow is darker (mean displayed value {tones[0]:.2f} against {tones[1]:.2f})"
    )
    assert found.holds is dark
    assert even(album, GLOW, MURK, "").holds is not dark


def test_tones_that_hardly_differ_are_even(tmp_path: Path) -> None:
    album = album_of(tmp_path, 0.12, 0.1)
    assert darker(album, GLOW, MURK, "").holds is False
    assert even(album, GLOW, MURK, "").holds is True


def test_the_truth_of_one_cell_can_judge_another(tmp_path: Path) -> None:
    album, truth = album_of(tmp_path, 0.2, 0.5), replace(GLOW, truth=EXACT)
    errors = [album.distance(picture, truth) for picture in (GLOW, MURK)]
    found = nearer(album, GLOW, [MURK], truth, "glow is nearer")
    assert found.holds is True
    assert found.text == f"glow is nearer (FLIP {errors[0]:.4f} against {errors[1]:.4f})"


@pytest.mark.parametrize(("value", "holds"), [(0.126, True), (0.5, False), (0.75, False)])
def test_numbers_are_compared(value: float, holds: bool) -> None:
    found = less(value, 0.5, "it is less", 1)
    assert found == Finding(f"it is less ({value:.1f} against 0.5)", holds)
    assert less(None, 0.5, "a") == less(value, None, "a") == Finding("a", None)


def test_without_pictures_there_is_no_verdict(tmp_path: Path) -> None:
    album = Album(context(tmp_path, [made(tmp_path, NEEDS[0])]), NEEDS)
    found = [
        nearer(album, MURK, [GLOW], EXACT, "a"),
        nearer(album, GLOW, [MURK], EXACT, "b"),
        alike(album, GLOW, MURK, "c"),
        faithful(album, MURK, EXACT, "d"),
        darker(album, MURK, GLOW, "e"),
    ]
    assert caption(album, "Fog.", found) == (
        "Fog. These results cannot tell: a; b; c; d; e."
        " 1 of the 2 cells of this figure are not in these results."
    )


def test_all_kinds_of_verdicts_are_named(tmp_path: Path) -> None:
    found = [Finding("a", True), Finding("b", None), Finding("c", False), Finding("d", True)]
    text = caption(album_of(tmp_path, 0.1, 0.1), "Fog.", found)
    assert text == "Fog. Reproduced: a; d. Not reproduced: c. These results cannot tell: b."

"""Families of methods: byte groups, strength of pictures, and winners."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import msgspec
import numpy as np
import pytest

from oitbench.image import files, metrics, stored
from oitbench.report.families import (
    BLENDING,
    CURVES,
    EQUAL,
    LISTS,
    byte_groups,
    bytes_text,
    cases,
    compare,
    lowest,
)
from oitbench.results.records import Results
from oitbench.results.schema import COMPLEXITY, TRANSMITTANCE, Memory, Record
from tests.report.made_up import FACTS, finished

FAMILY_OF = {"nodes": LISTS, "wave": CURVES, "mean": BLENDING}
COUNTS = np.array([[0, 1], [2, 4]])
PASSED = np.array([[1.0, 0.5], [0.81, 0.0]], np.float32)


def sized(
    folder: Path, method: str, size: float, scene: str = "panes", error: float = 0.1
) -> Record:
    made = finished(folder, scene, method, error, name=method.partition("[")[0])
    return with_outcome(made, memory=Memory(1, 8 * size, []))


def with_outcome(made: Record, **fields: object) -> Record:
    assert made.outcome is not None
    outcome = msgspec.structs.replace(made.outcome, **fields)
    return msgspec.structs.replace(made, outcome=outcome)


def measured(folder: Path, made: Record, objects: int = 3) -> Record:
    """Return the record with maps of its fragments and of their transmittance."""
    assert made.outcome is not None
    maps: Mapping[str, files.Channels] = {
        COMPLEXITY: files.count_channels(COUNTS),
        TRANSMITTANCE: files.image_channels(np.repeat(PASSED[..., None], 3, axis=-1)),
    }
    images = {kind: stored.store(folder, f"images/{kind}", maps[kind]) for kind in maps}
    statistics = msgspec.structs.replace(made.outcome.statistics, objects=objects)
    return with_outcome(made, images=made.outcome.images | images, statistics=statistics)


def results(folder: Path, *records: Record) -> Results:
    return Results(folder, records, FACTS)


def test_methods_join_the_list_of_nearly_equal_bytes(tmp_path: Path) -> None:
    sizes = {"nodes[k=4]": 32, "nodes": 64, "wave[r=1]": 36, "wave[r=2]": 56, "wave": 76.8}
    others = {"wave[r=9]": 44, "nodes[k=9]": 200}
    made = [sized(tmp_path, name, size) for name, size in {**sizes, **others}.items()]
    groups = byte_groups(
        results(tmp_path, *made),
        ["nodes", "nodes[k=4]", "nodes[k=9]"],
        [n for n in {**sizes, **others} if "wave" in n],
    )
    assert [dict(group.bytes) for group in groups] == [
        {"nodes[k=4]": 32, "wave[r=1]": 36},
        {"nodes": 64, "wave[r=2]": 56, "wave": 76.8},
    ]
    assert [group.title for group in groups] == [
        "32 to 36 bytes per pixel",
        "56 to 77 bytes per pixel",
    ]


def test_methods_whose_bytes_depend_on_the_picture_are_left_out(tmp_path: Path) -> None:
    made = [
        sized(tmp_path, "nodes", 32),
        sized(tmp_path, "wave", 32),
        sized(tmp_path, "wave", 33, "other"),
    ]
    assert byte_groups(results(tmp_path, *made), ["nodes"], ["wave"]) == []


def test_bytes_in_words() -> None:
    assert bytes_text([8, 8.0]) == "8 bytes per pixel"
    assert bytes_text([9, 11, 10]) == "9 to 11 bytes per pixel"


def test_the_strength_of_a_picture_is_that_of_equal_layers(tmp_path: Path) -> None:
    made = measured(tmp_path, sized(tmp_path, "nodes", 32, "panes[layers=4,seed=7,alpha=0.5]"))
    (case,) = cases(results(tmp_path, made), metrics.FLIP_LDR)
    assert case.layers == pytest.approx(7 / 3)
    # One layer of 0.5, two of 0.1, four of which one is opaque.
    assert case.opacity == pytest.approx((0.5 + 0.1 + 1) / 3)
    assert (case.row, case.seed, case.stack) == ("panes[alpha=0.5]", "7", False)
    assert case.rmse == {"nodes": made.metric("exact", metrics.RMSE)}
    assert case.flip == {"nodes": made.metric("exact", metrics.FLIP_LDR)}
    lists = measured(tmp_path, sized(tmp_path, "nodes", 32), objects=0)
    assert cases(results(tmp_path, lists), metrics.FLIP_LDR)[0].stack


def test_pictures_without_maps_or_with_effects_left_out_have_no_strength(tmp_path: Path) -> None:
    bare = sized(tmp_path, "nodes", 32, "bare")
    whole, shaded = (measured(tmp_path, sized(tmp_path, "nodes", 32, name)) for name in "ab")
    reduced = msgspec.structs.replace(whole, effects="-shadows")
    shaded = msgspec.structs.replace(shaded, shading="slices=8")
    assert cases(results(tmp_path, bare, reduced, shaded), metrics.FLIP_LDR) == []
    assert len(cases(results(tmp_path, bare, whole), metrics.FLIP_LDR)) == 1


def test_the_winner_has_the_lowest_error(tmp_path: Path) -> None:
    made = [
        measured(tmp_path, sized(tmp_path, method, size, error=error))
        for method, size, error in (
            ("nodes", 32, 0.2), ("wave", 36, 0.1), ("wave[r=1]", 500, 0.01), ("mean", 9, 0.01)
        )
    ]  # fmt: skip
    found = compare(results(tmp_path, *made), FAMILY_OF, metrics.FLIP_LDR)
    (group,), (case,) = found.groups, found.cases
    assert found.blending == "9 bytes per pixel"
    assert found.of(group, CURVES) == ["wave"]
    assert found.of(group, BLENDING) == ["mean"]
    assert found.winner(case, group) == found.winner(case, group, by_flip=True) == CURVES
    alone = compare(results(tmp_path, *made[:2]), FAMILY_OF, metrics.FLIP_LDR)
    assert alone.blending == ""
    unseen = replace(case, rmse={"wave": 9e-5, "nodes": 0.0})
    assert found.winner(unseen, group) == EQUAL
    seen = replace(case, rmse={"wave": 2e-4, "nodes": 0.0})
    assert found.winner(seen, group) == LISTS
    lost = replace(case, rmse={"wave": 0.1})
    assert found.winner(lost, group) == ""


def test_the_lowest_error_is_that_of_known_methods() -> None:
    assert lowest({"a": 2.0, "b": 1.0}, ["a", "b", "c"]) == "b"
    assert lowest({"a": 2.0}, ["c"]) is None

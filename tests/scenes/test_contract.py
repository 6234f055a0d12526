"""The contract of all scenes: building, documentation, effects and parameters.

Each scene also has a file of its own tests.
"""

from __future__ import annotations

import dataclasses
import math
import re
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest

from oitbench.effects import Effect
from oitbench.errors import UsageError
from oitbench.parameters import AnyParameter, text
from oitbench.scene import Scene
from tests.scenes.cases import CASES, EFFECTS, FULL, SMALL, name_of
from tests.scenes.helpers import COLLECTION, build, particles, with_detail

MOST_TRIANGLES = {"bottles": 160_000, "courtyard": 90_000, "engine": 140_000, "foliage": 140_000}
"""Limits that differ from 60,000."""
FRACTION = ("-0.1", "1.5", "nan")
IMPOSSIBLE = {
    **dict.fromkeys(("alpha", "alpha_high", "alpha_low", "clarity", "collimation"), FRACTION),
    **dict.fromkeys(("coverage", "opacity", "reflection"), FRACTION),
    **dict.fromkeys(("count", "height", "layers", "width"), ("0", "1.5")),
    "detail": ("-1", "nan", "101"),
    "distance": ("0.1", "nan"),
    "extinction": ("-1", "nan"),
    "seed": ("-1", "0.5"),
}
"""Values that no parameter of this name may accept."""


def leaves(value: Any) -> Iterator[np.ndarray]:
    """Yield all numbers and texts of a scene as arrays, in a fixed order."""
    if dataclasses.is_dataclass(value):
        for field in dataclasses.fields(value):
            yield from leaves(getattr(value, field.name))
    elif isinstance(value, tuple):
        for item in value:
            yield from leaves(item)
    elif isinstance(value, Effect):
        yield np.asarray(value.value)
    elif value is not None:
        yield np.asarray(value)


def transparent_triangles(scene: Scene) -> int:
    return sum(len(item.mesh.triangles) for item in scene.transparent)


def all_triangles(scene: Scene) -> int:
    """Return the number of triangles, or of fragments for a scene without geometry."""
    if scene.lists is not None:
        return scene.lists.z.size
    return sum(len(item.mesh.triangles) for item in scene.objects)


@pytest.mark.parametrize("case", CASES)
def test_building_a_scene_is_repeatable(case: str) -> None:
    label = with_detail(case, SMALL)
    first, second = (COLLECTION.build_scene(label) for _ in range(2))
    assert first.name.startswith(name_of(case))
    assert first.transparent or first.lists is not None or first.medium is not None
    for one, other in zip(leaves(first), leaves(second), strict=True):
        assert one.dtype == other.dtype
        np.testing.assert_array_equal(one, other)
        # Only the far plane of the camera may be infinite.
        assert one.dtype.kind not in "fiu" or np.isfinite(one).all() or one == math.inf


@pytest.mark.parametrize("name", COLLECTION.scenes)
def test_a_scene_documents_itself_and_its_parameters(name: str) -> None:
    plugin = COLLECTION.scenes[name]
    assert re.match(r"[^\n]{20,100}\.\n", plugin.doc)
    assert "detail" in plugin.parameters
    assert all(parameter.help for parameter in plugin.parameters.values())
    documented = re.findall(r"^([a-z_, ]+) : (?:float|int|str|bool)$", plugin.doc, re.MULTILINE)
    assert sorted(", ".join(documented).split(", ")) == sorted(plugin.parameters)


@pytest.mark.parametrize("detail", [SMALL, FULL])
@pytest.mark.parametrize("case", CASES)
def test_a_scene_requests_the_effects_that_it_claims(case: str, detail: float) -> None:
    effects = build(with_detail(case, detail)).effects
    assert effects
    assert effects == EFFECTS.get(case, effects)


@pytest.mark.parametrize(
    "name", [name for name, plugin in COLLECTION.scenes.items() if "seed" in plugin.parameters]
)
def test_another_seed_gives_another_scene(name: str) -> None:
    one, other = (build(f"{name}[detail={SMALL},seed={seed}]") for seed in (1, 2))
    changed = [not np.array_equal(*pair) for pair in zip(leaves(one), leaves(other), strict=True)]
    assert sum(changed) > 1  # not only the name
    for before, after in zip(particles(one), particles(other), strict=True):
        assert not np.array_equal(before.mesh.positions, after.mesh.positions)


def wrong_values(name: str, parameter: AnyParameter) -> Iterator[str]:
    """Yield values that the parameter must refuse."""
    yield from IMPOSSIBLE.get(name, ())
    if parameter.choices:
        yield "nonsense"
    elif isinstance(parameter.default, bool):
        yield "maybe"
    else:
        yield "nonsense"
        for bound, step in ((parameter.low, -1), (parameter.high, 1)):
            if bound is not None:
                yield text(type(parameter.default)(bound + step))
        if isinstance(parameter.default, float):
            yield "nan"


def edge_values(parameter: AnyParameter) -> Iterator[str]:
    """Yield the values at the bounds of the parameter, except expensive ones."""
    yield from map(text, parameter.choices)
    if isinstance(parameter.default, bool):
        yield from ("true", "false")
    for bound in (parameter.low, parameter.high):
        if bound is not None and bound <= 10:
            yield text(type(parameter.default)(bound))


@pytest.mark.parametrize("name", COLLECTION.scenes)
def test_errors_about_values_out_of_bounds_name_the_parameter(name: str) -> None:
    parameters = COLLECTION.scenes[name].parameters
    for key, parameter in parameters.items():
        for value in wrong_values(key, parameter):
            with pytest.raises(UsageError, match=rf"{name}.*\b{key}\b"):
                build(f"{name}[{key}={value}]")
    with pytest.raises(UsageError, match="nonsense"):
        build(f"{name}[nonsense=1]")


@pytest.mark.parametrize("name", COLLECTION.scenes)
def test_values_at_the_bounds_are_accepted_or_contradict_another_parameter(name: str) -> None:
    for key, parameter in COLLECTION.scenes[name].parameters.items():
        for value in edge_values(parameter):
            label = f"{name}[{key}={value}" + ("]" if key == "detail" else f",detail={SMALL}]")
            try:
                scene = build(label)
            except UsageError as error:
                reason = str(error).partition("]: ")[2]
                named = [other for other in COLLECTION.scenes[name].parameters if other in reason]
                assert key in named, label
                assert len(named) == 2
            else:
                assert scene.objects or scene.lists is not None, label


@pytest.mark.parametrize("name", COLLECTION.scenes)
def test_detail_scales_the_number_of_triangles(name: str) -> None:
    # A plane of the stack is two triangles up to detail 1.
    details = (1, 16) if name == "layer_stack" else (SMALL, FULL)
    coarse, fine = (build(f"{name}[detail={detail}]") for detail in details)
    every = all_triangles(fine) / all_triangles(coarse)
    assert every > 1.5
    if transparent_triangles(fine) != transparent_triangles(coarse):
        assert transparent_triangles(fine) > 3 * transparent_triangles(coarse)
    else:
        assert every > 3


@pytest.mark.parametrize("name", COLLECTION.scenes)
def test_the_number_of_triangles_is_limited(name: str) -> None:
    scene = build(f"{name}[detail={FULL}]")
    assert scene.lists is not None or all_triangles(scene) < MOST_TRIANGLES.get(name, 60_000)

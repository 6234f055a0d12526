"""The overview of methods."""

from __future__ import annotations

import pytest

from oitbench.gl.device import Device
from oitbench.stability import overview
from oitbench.stability.overview import Overview
from tests.helpers import method


@pytest.mark.parametrize("count", [2, 4])
def test_a_list_of_k_nodes_is_exact_for_k_layers(device: Device, count: int) -> None:
    (found,) = overview.measure(device, [method(f"k_buffer[k={count}]")])
    assert found.exact_layers == count
    assert found.bytes == 8 * count


def test_sorted_methods_are_measured_on_sortable_layers(overviews: dict[str, Overview]) -> None:
    assert overviews["sorted_over"].cells[2] == "≥ 64 if sortable"
    assert overviews["alpha_blend"].cells[2] == "1"


def test_random_methods_are_exact_in_the_mean(overviews: dict[str, Overview]) -> None:
    assert overviews["hashed_alpha"].cells[2] == "in the mean"


def test_peeling_needs_a_pass_for_each_layer_and_one_more(overviews: dict[str, Overview]) -> None:
    assert overviews["depth_peeling"].passes == overview.DEPTH + 1


def test_colored_transmission_can_depend_on_a_parameter(overviews: dict[str, Overview]) -> None:
    found = [overviews[name].colored for name in ("weighted_blended", "adaptive", "a_buffer")]
    assert found == ["no", "with `channels=rgb`", "yes"]


def test_the_first_known_failure_is_shown() -> None:
    assert overview.first_failure(method("weighted_average")) == "depth is ignored"


def test_a_table_has_one_line_for_each_method(overviews: dict[str, Overview]) -> None:
    lines = overview.table([overviews["alpha_blend"]]).splitlines()
    assert [line.count(" | ") for line in lines] == [len(overview.HEADINGS) - 1] * 3

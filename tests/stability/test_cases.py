"""The hard cases: the exact method passes them, and known failures break them."""

from __future__ import annotations

from pathlib import Path

import pytest

from oitbench.gl.device import Device
from oitbench.stability.cases import cases
from oitbench.stability.result import BREAKS, DOES_NOT_APPLY, HOLDS
from tests.helpers import collection, run_checks
from tests.stability.helpers import CHECKS, examine, writing


def test_hard_cases_are_all_checks_that_are_not_identities() -> None:
    assert [check.name for check in cases()] == [c.name for c in CHECKS.values() if not c.identity]


def test_the_exact_method_holds_everything_that_applies(device: Device) -> None:
    chosen = [check for check in CHECKS.values() if check.repeat]
    found = run_checks(device, [collection().truth()], chosen)
    assert [result.check for result in found if result.status == BREAKS] == []
    skipped = {result.check for result in found if result.status == DOES_NOT_APPLY}
    assert skipped == {"resolution_independent", "scatter"}
    assert not any(result.failed for result in found)


@pytest.mark.parametrize("name", ["perfect diffuser", "camera in glass", "light in glass"])
def test_pixels_that_are_not_finite_fail_at_every_limit(
    device: Device, tmp_path: Path, name: str
) -> None:
    (found,) = examine(device, writing(tmp_path, "vec4(1.0 / (fragment.z - fragment.z))"), name)
    assert found.failed
    assert found.nonfinite.inf > 0


def test_half_floats_lose_faint_layers(device: Device) -> None:
    half, single = (
        examine(device, f"alpha_blend[precision={name}]", "200 faint layers")[0]
        for name in ("half", "float")
    )
    assert (half.status, single.status) == (BREAKS, HOLDS)
    assert half.error is not None
    assert half.error > 0.01

"""Methods, checks and results for tests of the suite."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from oitbench.gl.device import Device
from oitbench.method.declaration import Method
from oitbench.stability import suite
from oitbench.stability.check import Check
from oitbench.stability.result import HOLDS, CheckResult, Status
from tests.helpers import foreign_method, method, run_checks, write_method

CHECKS = {check.name: check for check in suite.checks()}
COVERAGE = "expresses = Effect.COVERAGE\n"


def examine(device: Device, chosen: Method | str, *checks: str | Check) -> list[CheckResult]:
    """Return the results of some checks of one method."""
    chosen = method(chosen) if isinstance(chosen, str) else chosen
    selected = [CHECKS[check] if isinstance(check, str) else check for check in checks]
    return run_checks(device, [chosen], selected)


def writing(folder: Path, color: str) -> Method:
    """Return a method that writes `color`, an expression in GLSL, for each fragment.

    It promises `single_layer_exact`.
    """
    written = write_method(
        folder / "writing",
        '(Gather("gather.glsl", writes={"color": REPLACE}),)',
        members=f'{COVERAGE}promises = promise("single_layer_exact")',
        gather=f"void gather(Fragment fragment) {{ color = {color}; }}",
    )
    return foreign_method(written)


def made_up(check: str = "swept layer", status: Status = HOLDS, **facts: Any) -> CheckResult:
    """Return a result of a hard case or, with `identity=True`, of an identity."""
    given = {"identity": False, "promised": False, **facts}
    return CheckResult(
        method="some[k=2]", name="some", check=check, sentence="", status=status, **given
    )

"""`oitbench run`: refused input, machines without a driver, and how a run ends."""

from __future__ import annotations

from pathlib import Path

import pytest

from oitbench.results.store import Store
from tests.cli.helpers import NO_EGL, SMALL, Call, spawn


@pytest.mark.usefixtures("empty_folder")
@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("--scene", "layer_stak"), "unknown scene 'layer_stak'; did you mean layer_stack"),
        (("--method", "a_bufer"), "unknown method 'a_bufer'; did you mean a_buffer"),
        (("--method", "a_buffer[nod=precise]"), "parameter of a_buffer 'nod'; did you mean"),
        (("--method", "a_buffer[node=tiny]"), "node cannot be tiny; choose from precise"),
        (("--method", "a_buffer[node"), "cannot read 'a_buffer[node'"),
        (("--method", "no/such/folder"), "is no method; it has no method.py"),
        (("--scene", "layer_stack[alpha=nan]"), "alpha is nan"),
        (("--scene", "layer_stack[count=0]"), "count is 0; it must be at least 1"),
        (("--size", "0x5"), "0x5"),
        (("--size", "big"), "'big'"),
        (("--preset", "huge"), "huge"),
        (("--effects", "-fog"), "unknown effect 'fog'"),
        (("--timeout", "-1"), "timeout is -1 s"),
        (("--timeout", "inf"), "timeout is inf s"),
        (("--timeout", "nan"), "timeout is nan s"),
        (("--timeout", "soon"), "cannot read timeout 'soon'; give seconds, or none"),
        (("--memory", "inf"), "memory is inf GiB"),
        (("--memory", "nan"), "memory is nan GiB"),
        (("--memory", "0.01"), "memory is 0.01 GiB; give at least 0.25"),
        (("--workers", "-1"), "-1"),
        (("--dask", "nonsense"), "no Dask scheduler answers at nonsense; start one by: dask"),
        (("--collection", "no/such/folder"), "is no collection"),
    ],
)
def test_wrong_input_is_refused_and_nothing_is_written(
    call: Call, arguments: tuple[str, ...], message: str
) -> None:
    call("run", *arguments).assert_refused(message)


def test_without_egl_the_error_names_the_missing_package(tmp_path: Path) -> None:
    answer = spawn(
        "run", "--scene", "layer_stack", "--out", str(tmp_path / "out"), *SMALL, **NO_EGL
    )
    answer.assert_no_driver()


def test_a_folder_that_cannot_be_written_to_is_named(call: Call) -> None:
    answer = call("run", "--scene", "layer_stack", "--out", "/proc/results", *SMALL)
    assert answer.code == 2
    assert "/proc/results cannot be written to" in answer.err


def test_the_end_of_a_run_names_cells_reasons_and_the_next_command(
    call: Call, plugins: Path, tmp_path: Path
) -> None:
    out = tmp_path / "out"
    chosen = ["--scene", "calm", "--method", "weighted_sum", "--method", "unstable"]
    arguments = ["--preset", "guard", "--collection", plugins, *SMALL, "--out", out, *chosen]
    answer = call("run", *arguments)
    assert answer.code == 1, answer
    lines = answer.out.splitlines()
    row = next(line.split() for line in lines if line.split()[:1] == ["unstable"])
    assert row[1:4] == ["calm", "unstable", "requested"]
    assert row[4] == "pixels:"
    assert lines[-2].startswith(f"{out}: 1 ok, 1 unstable; 0 kept from before")
    assert lines[-1] == f"next: oitbench report {out} --open"
    # An unstable cell is finished: it is kept, and named again.
    answer = call("run", *arguments)
    assert answer.code == 1, answer
    assert "nothing to do; 2 kept from before" in answer.out
    assert "pixels:" in answer.out
    # A failed one does not stop the run, and is tried again by the same command.
    answer = call("run", "--force", "--method", "broken", *arguments)
    assert answer.code == 1, answer
    assert f"{out}: 1 failed, 1 ok, 1 unstable" in answer.out
    again = next(line for line in answer.out.splitlines() if line.startswith("failed cells again"))
    command = (
        f"failed cells again: oitbench run --method broken --preset guard --collection {plugins}"
    )
    assert again.startswith(command)


def test_a_run_whose_cells_are_well_exits_with_0(call: Call, tmp_path: Path) -> None:
    arguments = ("--preset", "guard", *SMALL, "--out", tmp_path / "out")
    chosen = ("--scene", "layer_stack[count=3]", "--method", "weighted_sum")
    answer = call("run", *arguments, *chosen)
    assert answer.code == 0, answer
    assert "reason" not in answer.out


def test_a_folder_that_another_run_has_is_refused_in_one_line(call: Call, tmp_path: Path) -> None:
    arguments = ("--preset", "guard", *SMALL, "--scene", "layer_stack", "--method", "weighted_sum")
    with Store.open(tmp_path):
        call("run", *arguments, "--out", tmp_path).assert_refused("is in use by process")

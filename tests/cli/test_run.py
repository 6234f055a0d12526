"""`oitbench run`: refused input, and machines without a driver."""

from __future__ import annotations

from pathlib import Path

import pytest

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
        (("--workers", "0"), "0"),
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

"""The command line as a whole: help, version and unknown commands."""

from __future__ import annotations

import pytest

from oitbench.cli import VERBS
from tests.cli.helpers import Call, spawn


def test_help_lists_all_commands() -> None:
    answer = spawn("--help")
    assert answer.code == 0
    assert all(f"\n  {verb} " in answer.out for verb in VERBS)


@pytest.mark.parametrize("arguments", [("--version",), ("run", "--help"), ("render", "-h")])
def test_help_and_version_exit_with_0(call: Call, arguments: tuple[str, ...]) -> None:
    answer = call(*arguments)
    assert answer.code == 0
    assert answer.out


def test_an_unknown_command_is_refused_with_a_suggestion(call: Call) -> None:
    call("rnu").assert_refused("unknown command 'rnu'; did you mean run")


def test_a_shell_learns_how_a_line_may_go_on(call: Call, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("_OITBENCH_COMPLETE", "bash_complete")
    monkeypatch.setenv("COMP_WORDS", "oitbench repo")
    monkeypatch.setenv("COMP_CWORD", "1")
    assert call().out.split() == ["plain,report"]

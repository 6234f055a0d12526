"""The command line, called in the process of the tests."""

from __future__ import annotations

import sys

import pytest

from oitbench.cli import main
from tests.cli.helpers import Answer, Call


@pytest.fixture
def call(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Call:
    """Return a function that calls `oitbench` with some arguments."""

    def run(*arguments: object) -> Answer:
        monkeypatch.setattr(sys, "argv", ["oitbench", *map(str, arguments)])
        code: object = 0
        try:
            main()
        except SystemExit as stop:
            code = stop.code or 0
        assert isinstance(code, int)
        printed = capsys.readouterr()
        return Answer(code, printed.out, printed.err)

    return run

"""The file of a plugin is loaded as it is."""

from __future__ import annotations

import os
import sys
from pathlib import Path

import pytest

from oitbench.loading import load_module


@pytest.fixture(autouse=True)
def _python_stores_bytecode(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "dont_write_bytecode", False)


def test_a_file_that_changes_within_a_second_is_loaded_anew(tmp_path: Path) -> None:
    """Its size and the second of its change are those of the file before."""
    path = tmp_path / "metric.py"
    for value in (1, 2):
        path.write_text(f"kept = {value}\n")
        os.utime(path, (1e9, 1e9))
        module = load_module(path)
        assert module.kept == value


def test_no_bytecode_is_stored_beside_plugins(tmp_path: Path) -> None:
    path = tmp_path / "metric.py"
    path.write_text("kept = 1\n")
    load_module(path)
    assert list(tmp_path.iterdir()) == [path]

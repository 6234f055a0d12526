"""PYTHON.md: its blocks run in order, and print what the page shows."""

from __future__ import annotations

import contextlib
import io
import re
from pathlib import Path
from typing import Any

import pytest

from oitbench.gl.device import Device
from oitbench.places import own_folder

PAGE = own_folder() / "PYTHON.md"
BLOCK = re.compile(r"^```python\n(.*?)^```\n(?:\n```text\n(.*?)^```$)?", re.MULTILINE | re.DOTALL)


def blocks() -> list[tuple[str, str]]:
    """Return the code of each block, and the output that the page shows; "" for none."""
    return BLOCK.findall(PAGE.read_text(encoding="utf-8"))


def run(blocks: list[tuple[str, str]]) -> list[str]:
    """Return what each block prints; they share their names."""
    names: dict[str, Any] = {}
    found = []
    for code, _ in blocks:
        printed = io.StringIO()
        with contextlib.redirect_stdout(printed):
            exec(compile(code, str(PAGE), "exec"), names)
        found.append(printed.getvalue())
    return found


def test_the_page_prints_what_it_shows(
    device: Device, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    known = blocks()
    assert len(known) == PAGE.read_text(encoding="utf-8").count("```python")
    found = run(known)
    assert all(printed for _, printed in known)
    if device.software:  # Numbers differ in the last digit on other renderers.
        assert found == [text for _, text in known]
    assert (tmp_path / "glass_bars.html").is_file()

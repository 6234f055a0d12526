"""`--open`: pages in the browser."""

from __future__ import annotations

import webbrowser
from pathlib import Path

import pytest

from tests.cli.helpers import Call
from tests.report.made_up import finished, store


@pytest.mark.parametrize("found", [True, False])
def test_the_page_is_opened_if_asked_for(
    call: Call, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, found: bool
) -> None:
    opened: list[str] = []

    def show(url: str) -> bool:
        opened.append(url)
        return found

    monkeypatch.setattr(webbrowser, "open", show)
    folder = store(tmp_path / "results", finished(tmp_path / "results", "panes", "murk", 0.1))
    assert call("report", folder, "--section", "memory").code == 0
    assert opened == []
    answer = call("report", folder, "--section", "memory", "--open")
    page = folder / "report" / "index.html"
    assert opened == [page.as_uri()]
    assert ("no browser was found" in answer.err) != found

"""A package with an adapter, installed beside the suite for the duration of a test."""

from __future__ import annotations

from pathlib import Path

import pytest

from oitbench.engines.known import GROUP

MADE_UP = Path(__file__).with_name("made_up_engine.py")


@pytest.fixture
def abacus(tmp_path_factory: pytest.TempPathFactory, monkeypatch: pytest.MonkeyPatch) -> str:
    """Install the engine `abacus`, and return its name."""
    folder = tmp_path_factory.mktemp("package")
    facts = folder / "abacus-1.0.dist-info"
    facts.mkdir()
    (folder / "abacus_engine.py").write_bytes(MADE_UP.read_bytes())
    (facts / "METADATA").write_text("Metadata-Version: 2.1\nName: abacus\nVersion: 1.0\n")
    (facts / "entry_points.txt").write_text(f"[{GROUP}]\nabacus = abacus_engine:Abacus\n")
    monkeypatch.syspath_prepend(folder)
    return "abacus"

"""A run that others are compared with."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.results.helpers import write_run


@pytest.fixture
def before(tmp_path: Path) -> Path:
    return write_run(tmp_path / "before")

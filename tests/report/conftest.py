"""Figures of reports have few pixels in tests, to save time."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from oitbench.report import figures


@pytest.fixture(scope="package", autouse=True)
def coarse_figures() -> Iterator[None]:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(figures, "DOTS_PER_INCH", 40)
        yield

"""Figures have few pixels in tests, to save time."""

from __future__ import annotations

from tests.report.conftest import coarse_figures

__all__ = ["coarse_figures"]

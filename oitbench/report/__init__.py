"""Reports: what a report file builds, helpers for figures of one look, and the page of them all."""

from __future__ import annotations

from oitbench.report.artifacts import (
    Artifact,
    Column,
    Figure,
    ImageGrid,
    Note,
    Table,
    Tile,
    decimal,
    fixed,
    write_table,
)
from oitbench.report.page import write

__all__ = [
    "Artifact",
    "Column",
    "Figure",
    "ImageGrid",
    "Note",
    "Table",
    "Tile",
    "decimal",
    "fixed",
    "write",
    "write_table",
]

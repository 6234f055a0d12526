"""Reports: the parts of a page, figures with one look, and the page that holds all reports.

A report is a file with a `title`, a function `build` from a `ReportContext` to artifacts, and
optionally a number `order`. Its docstring is the text of its section on the page.
"""

from __future__ import annotations

from oitbench.report.artifacts import (
    Artifact,
    Column,
    Figure,
    ImageGrid,
    Note,
    Stack,
    Table,
    Tile,
    decimal,
    fixed,
    write_table,
)
from oitbench.report.context import ReportContext
from oitbench.report.page import write

__all__ = [
    "Artifact",
    "Column",
    "Figure",
    "ImageGrid",
    "Note",
    "ReportContext",
    "Stack",
    "Table",
    "Tile",
    "decimal",
    "fixed",
    "write",
    "write_table",
]

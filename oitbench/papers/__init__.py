"""The figures of papers, redrawn from results: pictures in rows, and what of them reproduced.

A figure is a report with `needs`, the cells that it shows. `reports/papers/PAPER.toml` lists the
figures of a paper, and why some are not drawn.
"""

from __future__ import annotations

from oitbench.papers import curves
from oitbench.papers.album import Album
from oitbench.papers.captions import (
    Finding,
    alike,
    caption,
    darker,
    even,
    faithful,
    less,
    nearer,
    unlike,
)
from oitbench.papers.listing import Paper, read_paper
from oitbench.papers.picture import Picture, needs_of
from oitbench.papers.plates import Row, plate

__all__ = [
    "Album",
    "Finding",
    "Paper",
    "Picture",
    "Row",
    "alike",
    "caption",
    "curves",
    "darker",
    "even",
    "faithful",
    "less",
    "nearer",
    "needs_of",
    "plate",
    "read_paper",
    "unlike",
]

"""Tables on the terminal."""

from __future__ import annotations

import sys
from collections.abc import Iterable, Sequence
from itertools import zip_longest

_WIDE = 200
"""Columns of a table in a file or a pipe, so that labels stay whole."""


def print_table(
    titles: Sequence[str], rows: Iterable[Sequence[str]], styles: Iterable[str | None] = ()
) -> None:
    """Print a table; `styles` are those of the rows in rich's notation, if they have any."""
    from rich import box
    from rich.console import Console
    from rich.table import Table

    table = Table(box=box.SIMPLE)
    for title in titles:
        table.add_column(title, overflow="fold")
    for row, style in zip_longest(list(rows), styles):
        table.add_row(*row, style=style)
    width = None if sys.stdout.isatty() else _WIDE
    Console(width=width, markup=False, highlight=False).print(table)

"""`oitbench compare`: compare a run with a baseline, or with another run."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import TYPE_CHECKING

import click

from oitbench.cli import options
from oitbench.errors import UsageError

if TYPE_CHECKING:
    from oitbench.results.comparison import Comparison

_WIDE = 200


@click.command()
@click.argument("results", type=click.Path(path_type=Path))
@click.argument("baseline", type=click.Path(path_type=Path))
@click.option("--json", "as_json", is_flag=True, help="Print the comparison as JSON.")
@click.option("--html", is_flag=True, help="Also write a page, with the pictures that changed.")
@click.option(
    "-o",
    "--out",
    type=click.Path(file_okay=False, path_type=Path),
    help="Folder of the page. Default: `compare` in the results folder.",
)
@options.open_page
def command(
    results: Path, baseline: Path, as_json: bool, html: bool, out: Path | None, opens: bool
) -> None:
    """Compare RESULTS with BASELINE, a baseline file or another results folder.

    The exit code is 1 if a quality metric became worse by more than its tolerance, if a count
    changed, or if RESULTS lacks a cell. New cells and differences of method times are printed, but
    never change the exit code.
    """
    from oitbench.results.comparison import compare

    if not html and (out is not None or opens):
        raise UsageError("--out and --open are of the page; add --html")
    comparison = compare(results, baseline)
    if html:
        from oitbench.report.comparing import page

        path = page.write(comparison, results, baseline, out or results / "compare")
        click.echo(path, err=as_json)
        if opens:
            options.show_page(path)
    show(comparison, as_json)


def show(comparison: Comparison, as_json: bool = False) -> None:
    """Print a comparison; exit with 1 if there is a regression."""
    if as_json:
        click.echo(json.dumps(comparison.facts(), indent=2, allow_nan=False))
    else:
        if comparison.differences:
            _print_table(comparison)
        click.echo(comparison)
    sys.exit(0 if comparison.passed else 1)


def _print_table(comparison: Comparison) -> None:
    from rich import box
    from rich.console import Console
    from rich.table import Table

    table = Table(box=box.SIMPLE)
    for title in ("verdict", "cell", "field", "baseline", "now"):
        table.add_column(title, overflow="fold")
    for item in comparison.differences:
        style = "red" if item.regression else "green" if item.verdict == "better" else None
        values = ("" if value is None else str(value) for value in (item.before, item.now))
        table.add_row(item.verdict, item.cell, item.field, *values, style=style)
    # Keep whole labels in files and pipes.
    width = None if sys.stdout.isatty() else _WIDE
    Console(width=width, markup=False, highlight=False).print(table)

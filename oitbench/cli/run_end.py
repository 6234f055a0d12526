"""How `oitbench run` ends: what went wrong and why, where the time went, and what to type next."""

from __future__ import annotations

import shlex
import sys
from pathlib import Path
from typing import TYPE_CHECKING

import click
from rich import box
from rich.console import Console
from rich.table import Table

if TYPE_CHECKING:
    from oitbench.matrix.run import Summary

_WIDE = 200
_SLOWEST = 5
"""Number of scenes that are named."""
_WORDS = {"building": "building scenes", "metrics": "metrics", "rest": "rest"}


def print_end(out: Path, summary: Summary, quiet: bool = False, report: bool = True) -> None:
    """Print the cells that a user should look at, the times, the summary, and the next commands.

    Parameters
    ----------
    out : Path
        The results folder.
    summary : Summary
    quiet : bool
        Print only what went wrong, and the summary.
    report : bool
        Also print the command of the report.
    """
    if summary.warning:
        click.echo(f"disturbed: {summary.warning}", err=True)
    for fault in summary.faults:
        click.echo(f"metric: {fault}", err=True)
    if quiet:
        click.echo(f"{out}: {summary}")
        return
    if summary.troubled:
        _print(_troubled(summary))
    if summary.statuses:
        _print(_times(summary))
        click.echo(f"slowest scenes: {_slowest(summary)}\n")
    click.echo(f"{out}: {summary}")
    if any(not record.finished for record in summary.troubled):
        again = [argument for argument in sys.argv[1:] if argument != "--force"]
        click.echo(f"failed cells again: {shlex.join(['oitbench', *again])}")
    if report:
        click.echo(f"next: {shlex.join(['oitbench', 'report', str(out), '--open'])}")


def _print(table: Table) -> None:
    # Keep whole labels in files and pipes.
    width = None if sys.stdout.isatty() else _WIDE
    Console(width=width, markup=False, highlight=False).print(table)


def _troubled(summary: Summary) -> Table:
    table = Table(box=box.SIMPLE)
    for title in ("status", "scene", "method", "effects", "reason"):
        table.add_column(title, overflow="fold")
    for record in summary.troubled:
        table.add_row(record.status, record.seen, record.method, record.effects, record.reason)
    return table


def _times(summary: Summary) -> Table:
    """Return the seconds by kind of work; those of several workers are added."""
    table = Table("where the time went", box=box.SIMPLE)
    for title in ("seconds", "share"):
        table.add_column(title, justify="right")
    times = {**summary.spent, "rest": summary.rest}
    whole = sum(times.values())
    for kind, seconds in sorted(times.items(), key=lambda item: item[0] == "rest"):
        table.add_row(_WORDS.get(kind, kind), f"{seconds:.1f}", f"{seconds / whole:.0%}")
    return table


def _slowest(summary: Summary) -> str:
    found = sorted(summary.scenes.items(), key=lambda item: -item[1])
    return ", ".join(f"{label} {seconds:.1f} s" for label, seconds in found[:_SLOWEST])

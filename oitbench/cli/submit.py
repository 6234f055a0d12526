"""`oitbench submit`: check results of a frozen suite, and pack them."""

from __future__ import annotations

import sys
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import click

if TYPE_CHECKING:
    from oitbench.results.schema import Record
    from oitbench.suites.submission import Verdict

_WIDE = 200


@click.command()
@click.argument("results", type=click.Path(path_type=Path))
@click.option("--check", is_flag=True, help="Only check; write no archive.")
@click.option(
    "--suite",
    default="oitbench-1",
    show_default=True,
    help="Name of the suite, or its file.",
)
def command(results: Path, check: bool, suite: str) -> None:
    """Check that RESULTS are complete, unmodified and of a frozen suite, and write RESULTS.zip.

    Each method must have all scenes of the suite. Scenes, references, pictures and records must be
    those of the suite and of the run; the metrics are computed again from the pictures. SUITE.md
    says what to do with the archive.

    The exit code is 1 if anything is missing or wrong; then there is no archive.
    """
    from rich.console import Console
    from rich.progress import track

    from oitbench.suites import submission
    from oitbench.suites.archive import pack
    from oitbench.suites.description import read_suite

    console = Console(stderr=True)

    def watch(records: Sequence[Record]) -> Iterable[Record]:
        hidden = not console.is_terminal
        return track(records, "cells", console=console, transient=True, disable=hidden)

    chosen = read_suite(suite)
    verdict = submission.check(results, chosen, watch)
    if verdict.faults:
        _print_faults(verdict)
        count = len(verdict.faults)
        faults = f"{count} fault{'' if count == 1 else 's'}"
        click.echo(f"{results}: no results of {chosen.name}: {faults}")
        sys.exit(1)
    methods = f"{len(verdict.methods)} method{'' if len(verdict.methods) == 1 else 's'}"
    scenes = f"{len(chosen.scenes)} scene{'' if len(chosen.scenes) == 1 else 's'}"
    click.echo(f"{results}: complete and unmodified: {methods} in {scenes} of {chosen.name}")
    if not check:
        click.echo(f"{pack(results)}: to be sent")


def _print_faults(verdict: Verdict) -> None:
    from rich import box
    from rich.console import Console
    from rich.table import Table

    table = Table(box=box.SIMPLE)
    for title in ("scene", "method", "missing or wrong"):
        table.add_column(title, overflow="fold")
    for fault in verdict.faults:
        table.add_row(fault.scene, fault.method, fault.reason)
    # Keep whole labels in files and pipes.
    width = None if sys.stdout.isatty() else _WIDE
    Console(width=width, markup=False, highlight=False).print(table)

"""`oitbench stability`: what methods promise, and what they survive."""

from __future__ import annotations

import sys
from pathlib import Path

import click

from oitbench.cli import options

_WIDTH = 120
"""Columns of a terminal below which the table would be cut."""


@click.command()
@click.option(
    "--method",
    "methods",
    multiple=True,
    help="NAME[param=v,w] or a method's folder; repeatable. All, with their grids, without.",
)
@click.option(
    "--out",
    type=click.Path(file_okay=False, path_type=Path),
    default=Path("results") / "stability",
    show_default=True,
    help="Where stability.json and stability.csv are written.",
)
@click.option("--json", "as_json", is_flag=True, help="Print the findings for programs.")
@options.collections
def command(
    methods: tuple[str, ...], out: Path, as_json: bool, collections: tuple[Path, ...]
) -> None:
    """Hold methods to their promised identities and take them through hard cases.

    A named method runs as it is named; a bare name stands for all of its variants. The exit code is
    1 if a promise is broken, a pixel is NaN, infinite or negative, or a picture changes from one
    run to the next.
    """
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn

    from oitbench.gl.device import Device
    from oitbench.plugins import Collection
    from oitbench.stability import files, suite

    collection = Collection.load(collections)
    bare = [text for text in methods if text in collection.methods]
    chosen = suite.variants(collection, bare if methods else list(collection.methods))
    chosen += collection.expand_methods(text for text in methods if text not in bare)
    chosen = list({method.label: method for method in chosen}.values())
    device = Device()
    console = Console(stderr=True)
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn())
    with Progress(*columns, console=console, transient=True) as progress:
        task = progress.add_task("checks", total=len(suite.checks()) * len(chosen))
        findings = suite.run(
            device, collection, chosen, report=lambda finding: progress.advance(task)
        )
    facts = {"gl": {"renderer": device.renderer, "version": device.version}}
    device.release()
    files.write(out, findings, facts)
    if as_json:
        click.echo((out / files.JSON).read_text(encoding="utf-8"), nl=False)
    else:
        terminal = Console()
        terminal.width = max(terminal.width, _WIDTH)
        terminal.print(files.table(findings))
        click.echo(out / files.JSON)
    sys.exit(1 if any(finding.failed for finding in findings) else 0)

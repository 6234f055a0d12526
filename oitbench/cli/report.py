"""`oitbench report`: turn a results folder into figures, tables and one page."""

from __future__ import annotations

from pathlib import Path

import click

from oitbench.cli import options


@click.command()
@click.argument("results", type=click.Path(path_type=Path))
@click.option(
    "-o",
    "--out",
    type=click.Path(file_okay=False, path_type=Path),
    help="Folder of the report; RESULTS/report without.",
)
@click.option("--hdr", is_flag=True, help="Show HDR-FLIP instead of FLIP of the displayed image.")
@options.collections
def command(results: Path, out: Path | None, hdr: bool, collections: tuple[Path, ...]) -> None:
    """Write the report of RESULTS: every figure as PNG and PDF, every table as CSV, one page."""
    from oitbench.plugins import Collection
    from oitbench.report import write

    page = write(results, out, Collection.load(collections).reports, hdr=hdr)
    click.echo(page)

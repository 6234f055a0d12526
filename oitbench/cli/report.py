"""`oitbench report`: write figures, tables and one page from a results folder."""

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
    help="Folder of the report. Default: RESULTS/report.",
)
@click.option("--hdr", is_flag=True, help="Show HDR-FLIP instead of FLIP of the displayed image.")
@click.option("--markdown", is_flag=True, help="Only print the main tables, as Markdown.")
@options.collections
def command(
    results: Path, out: Path | None, hdr: bool, markdown: bool, collections: tuple[Path, ...]
) -> None:
    """Write figures (PNG, PDF) and tables (CSV) of RESULTS, and a page that shows them."""
    from oitbench.plugins import Collection
    from oitbench.report import write
    from oitbench.report.markdown import tables
    from oitbench.results.records import Results

    if markdown:
        click.echo(tables(Results.load(results)), nl=False)
        return
    page = write(results, out, Collection.load(collections).reports, hdr=hdr)
    click.echo(page)

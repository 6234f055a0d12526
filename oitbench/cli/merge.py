"""`oitbench merge`: join the results of several machines."""

from __future__ import annotations

from pathlib import Path

import click


@click.command()
@click.argument("results", nargs=-1, required=True, type=click.Path(path_type=Path))
@click.option(
    "-o",
    "--out",
    required=True,
    type=click.Path(path_type=Path),
    help="A new folder.",
)
def command(results: tuple[Path, ...], out: Path) -> None:
    """Join RESULTS, folders of runs of one version of the suite on one or several machines.

    Times of different renderers share no axis, so each renderer has its own results folder in the
    new one, if there are several; a software renderer is another one on another processor. Reports,
    and comparisons of errors between them, take these folders. RESULTS stay as they are.
    """
    from oitbench.results.merging import merge

    merged = merge(results, out)
    for note in merged.notes:
        click.echo(f"note: {note}", err=True)
    for device, folder in merged.folders.items():
        click.echo(f"{folder}: {device}")
    click.echo(f"{out}: {merged.cells} cells")

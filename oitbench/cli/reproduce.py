"""`oitbench reproduce`: the figures of a paper, from exactly the cells that they need."""

from __future__ import annotations

import sys
from pathlib import Path

import click

from oitbench.cli import options
from oitbench.matrix.plan import CELL_SECONDS


@click.command()
@click.argument("paper")
@click.option(
    "--figure",
    "figures",
    metavar="NAME",
    multiple=True,
    help="Draw only this figure, a name of `oitbench list reports`. Repeatable. Default: all.",
)
@click.option(
    "--preset",
    type=click.Choice(["quick", "standard", "paper"]),
    default="standard",
    show_default=True,
    help="Size and rounds of timing, as for `oitbench run`.",
)
@options.size(None, "Pixels of the image. Default: the preset's.")
@click.option(
    "-o",
    "--out",
    type=click.Path(file_okay=False, path_type=Path),
    help="Folder of the results; the page is in its folder `report`. Default: results/PAPER.",
)
@options.execution(CELL_SECONDS)
@click.option("--dry-run", is_flag=True, help="Only list the cells; write nothing.")
@click.option("--quiet", is_flag=True, help="Print only what went wrong, and the last lines.")
@options.open_page
@options.collections
def command(
    paper: str,
    figures: tuple[str, ...],
    preset: str,
    size: tuple[int, int] | None,
    out: Path | None,
    force: bool,
    timeout: float | None,
    memory_gib: float | None,
    workers: int,
    dask: str | None,
    dry_run: bool,
    quiet: bool,
    opens: bool,
    collections: tuple[Path, ...],
) -> None:
    """Run the cells that the figures of PAPER need, and write a page with these figures.

    PAPER is at2011 (adaptive transparency), pt2017 (phenomenological transparency), i3d2016 (its
    first publication), or that of a collection. Cells that an earlier run finished are kept.

    The exit code is 1 if a cell failed, timed out, is unstable or is suspect, or if a figure could
    not be drawn.
    """
    from oitbench.catalog.catalog import Catalog
    from oitbench.cli.dry_run import print_plan
    from oitbench.cli.run_end import print_end
    from oitbench.cli.run_progress import RunProgress
    from oitbench.errors import unknown
    from oitbench.matrix.run import run_matrix
    from oitbench.papers.listing import read_papers
    from oitbench.papers.planning import plan_figures
    from oitbench.report import write

    with Catalog(collections) as catalog:
        papers = read_papers(catalog.places.folders)
        if paper not in papers:
            raise unknown("paper", paper, papers)
        found, files = papers[paper], catalog.places.reports
    folder = out or Path("results") / paper
    matrix = plan_figures(
        found, figures, preset, size, folder, collections, force=force, timeout=timeout,
        workers=workers, memory_gib=memory_gib, dask=dask,
    )  # fmt: skip
    if dry_run:
        print_plan(matrix, (), verbose=True)
        return
    with RunProgress(matrix, quiet) as shown:
        summary = run_matrix(matrix, shown.record, shown.line, shown.stage, shown.timed)
    print_end(folder, summary, quiet, report=False)
    with Catalog(collections) as catalog:
        crops = catalog.crops(sorted({cell.scene.partition("[")[0] for cell in matrix.cells}))
    reports = {name: files[name] for name in figures or found.drawn.values()}
    page = write(folder, None, reports, crops=crops, edition=found.edition)
    for reason in page.missing:
        click.echo(f"figure left out: {reason}", err=True)
    click.echo(page.path)
    if opens:
        options.show_page(page.path)
    sys.exit(1 if page.missing else summary.exit_code)

"""`oitbench report`: write figures, tables and one page from a results folder."""

from __future__ import annotations

import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import click

from oitbench.cli import options
from oitbench.errors import DeclarationError, UsageError
from oitbench.report.sections import SECONDS

if TYPE_CHECKING:
    from oitbench.catalog.catalog import Catalog
    from oitbench.crops import Crop
    from oitbench.papers.listing import Paper


@click.command()
@click.argument("results", type=click.Path(path_type=Path))
@click.option(
    "-o",
    "--out",
    type=click.Path(file_okay=False, path_type=Path),
    help="Folder of the report. Default: `report` in the results folder.",
)
@click.option(
    "--hdr",
    is_flag=True,
    help="Show HDR-FLIP instead of FLIP of the displayed image, and keep half floats in the viewer,"
    " so that exposure recovers light above white.",
)
@click.option(
    "--single-file",
    is_flag=True,
    help="Put all pictures, pixels, tables and figures into the page, however large it becomes.",
)
@click.option("--markdown", is_flag=True, help="Only print the main tables, as Markdown.")
@click.option(
    "--section",
    "sections",
    metavar="NAME",
    multiple=True,
    help="Write this section; `oitbench list reports` prints the names. Repeatable. Default: all"
    " but the figures of papers.",
)
@click.option(
    "--figure",
    "figures",
    metavar="NAME",
    multiple=True,
    help="Only draw the figures of this section, and print the paths of their PNG and PDF files."
    " Repeatable.",
)
@options.open_page
@options.timeout(SECONDS, "Seconds that each section of the page may take.")
@options.collections
def command(
    results: Path,
    out: Path | None,
    hdr: bool,
    single_file: bool,
    markdown: bool,
    sections: tuple[str, ...],
    figures: tuple[str, ...],
    opens: bool,
    timeout: float | None,
    collections: tuple[Path, ...],
) -> None:
    """Write figures (PNG, PDF) and tables (CSV) of RESULTS, and a page that shows them.

    Merged results of several renderers have a page for each, since their times share no axis.

    The exit code is 1 if a section is missing because its report failed.
    """
    from oitbench.catalog.catalog import Catalog
    from oitbench.papers.listing import figures_of, read_papers
    from oitbench.report import bibliography, write
    from oitbench.report.markdown import tables
    from oitbench.results.records import Results, parts

    folders = parts(results)
    if markdown:
        for folder in folders:
            heading = f"# {folder.name}\n\n" if len(folders) > 1 else ""
            click.echo(heading + tables(Results.load(folder)), nl=False)
        return
    with Catalog(collections) as catalog:
        found, papers = catalog.places.reports, read_papers(catalog.places.folders)
        records = [record for folder in folders for record in Results.load(folder).records]
        crops = catalog.crops(sorted({record.scene.partition("[")[0] for record in records}))
        if figures:
            paths = _draw(catalog, folders, papers, figures, out, hdr, crops, timeout)
            click.echo("\n".join(map(str, paths)))
            return
        portraits = {name: catalog.portrait(name) for name in sorted({r.name for r in records})}
        bibliographies = bibliography.files(catalog.places.folders)
    apart = figures_of(papers.values())
    reports = {name: found[name] for name in sections or found if sections or name not in apart}
    missing = False
    for folder in folders:
        place = out / folder.name if out is not None and len(folders) > 1 else out
        page = write(
            folder,
            place,
            reports,
            hdr=hdr,
            single_file=single_file,
            crops=crops,
            portraits=portraits,
            bibliographies=bibliographies,
            timeout=timeout,
        )
        for reason in page.missing:
            click.echo(f"section left out: {reason}", err=True)
        click.echo(page.path)
        if opens:
            options.show_page(page.path)
        missing |= bool(page.missing)
    sys.exit(1 if missing else 0)


def _draw(
    catalog: Catalog,
    folders: Sequence[Path],
    papers: Mapping[str, Paper],
    names: Sequence[str],
    out: Path | None,
    hdr: bool,
    crops: Mapping[str, Mapping[str, Crop]],
    timeout: float | None,
) -> list[Path]:
    """Draw the figures of some reports alone, and return their files."""
    from oitbench.papers.planning import check_results
    from oitbench.report.context import ReportContext
    from oitbench.report.page import folder_of
    from oitbench.report.sections import build_sections
    from oitbench.results.records import Results

    owners = {report: name for name, paper in papers.items() for report in paper.drawn.values()}
    reports = {name: catalog.path("report", name) for name in names}
    paths: list[Path] = []
    for folder in folders:
        results = Results.load(folder)
        for name in names:
            if name in owners:
                check_results(catalog, results, name, owners[name], folder)
        place = folder_of(results, out if len(folders) == 1 or out is None else out / folder.name)
        context = ReportContext(results, place, hdr, crops, sheets=True)
        for section in build_sections(context, reports, timeout):
            if section.error:
                raise DeclarationError(section.error)
            if not section.figures:
                raise UsageError(f"{section.name} draws no figure; leave out --figure")
            paths += section.figures
    return paths

"""`oitbench report`: write figures, tables and one page from a results folder."""

from __future__ import annotations

import sys
from pathlib import Path

import click

from oitbench.cli import options
from oitbench.report.sections import SECONDS


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
    help="Write this section; `oitbench list reports` prints the names. Repeatable. Default: all.",
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
    opens: bool,
    timeout: float | None,
    collections: tuple[Path, ...],
) -> None:
    """Write figures (PNG, PDF) and tables (CSV) of RESULTS, and a page that shows them.

    Merged results of several renderers have a page for each, since their times share no axis.

    The exit code is 1 if a section is missing because its report failed.
    """
    from oitbench.catalog.catalog import Catalog
    from oitbench.report import write
    from oitbench.report.bibliography import NAME
    from oitbench.report.markdown import tables
    from oitbench.results.records import Results, parts

    folders = parts(results)
    if markdown:
        for folder in folders:
            heading = f"# {folder.name}\n\n" if len(folders) > 1 else ""
            click.echo(heading + tables(Results.load(folder)), nl=False)
        return
    with Catalog(collections) as catalog:
        found = catalog.places.reports
        records = [record for folder in folders for record in Results.load(folder).records]
        crops = catalog.crops(sorted({record.scene.partition("[")[0] for record in records}))
        portraits = {name: catalog.portrait(name) for name in sorted({r.name for r in records})}
        bibliographies = [
            path
            for path in (f / "reports" / NAME for f in catalog.places.folders)
            if path.is_file()
        ]
    reports = {name: found[name] for name in sections or found}
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

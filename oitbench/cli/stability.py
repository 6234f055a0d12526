"""`oitbench stability`: checks of promised identities, and hard cases."""

from __future__ import annotations

import sys
from collections.abc import Iterable
from pathlib import Path

import click

from oitbench.catalog.catalog import Catalog, Choice
from oitbench.cli import options
from oitbench.stability.check import METHOD_SECONDS
from oitbench.workers import memory

_WIDTH = 120
"""Smallest width of the table in characters, so that no label is cut."""


@click.command()
@click.option(
    "--method",
    "methods",
    multiple=True,
    help="NAME or a method's folder, for all variants of the method; NAME[param=v,w], for these"
    " variants only. Repeatable. Default: all variants of all methods.",
)
@click.option(
    "--out",
    type=click.Path(file_okay=False, path_type=Path),
    default=Path("results") / "stability",
    show_default=True,
    help="Folder of stability.json and stability.csv.",
)
@click.option("--json", "as_json", is_flag=True, help="Print the content of stability.json.")
@options.timeout(METHOD_SECONDS, "Seconds that each check of a method may take.")
@options.memory
@options.collections
def command(
    methods: tuple[str, ...],
    out: Path,
    as_json: bool,
    timeout: float | None,
    memory_gib: float | None,
    collections: tuple[Path, ...],
) -> None:
    """Check the identities that methods promise, and render hard cases.

    Each check renders scenes with a known answer. One table counts the checks that hold, of those
    that apply to the method. Another one shows those that break: the expected and the measured
    value of the worst channel. A hard case, or an identity that is not promised, may break; the
    files list the checks of all variants.

    The exit code is 1 if a promise is broken, a shader fails, a pixel is NaN, infinite or negative,
    or an image changes from one run to the next. It is also 1 if a method crashes, takes too long
    or needs too much memory: that method is not rendered again, and all others are checked.
    """
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn

    from oitbench.stability import files, suite, summary
    from oitbench.stability.laboratory import Laboratory

    limit = memory.limit(memory_gib, 1)
    with Catalog(collections) as catalog:
        chosen = _choose(catalog, methods or catalog.names("method"))
        laboratory = Laboratory(catalog, chosen, limit, timeout)
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn())
    console = Console(stderr=True)
    # In a file or a pipe, the bar would end in an empty line.
    hidden = not console.is_terminal
    with (
        laboratory,
        Progress(*columns, console=console, transient=True, disable=hidden) as progress,
    ):
        task = progress.add_task("checks", total=len(suite.checks()) * len(chosen))
        gl = laboratory.renderer()
        results = suite.run(
            [choice.label for choice in chosen],
            laboratory.examine,
            report=lambda result: progress.advance(task),
        )
    files.write(out, results, gl)
    if as_json:
        click.echo((out / files.JSON).read_text(encoding="utf-8"), nl=False)
    else:
        terminal = Console()
        terminal.width = max(terminal.width, _WIDTH)
        terminal.print(summary.table(results))
        rows = summary.broken(results)
        if rows:
            terminal.print(summary.broken_table(rows))
        for line in (*summary.idle(results), *summary.without_image(results)):
            click.echo(line)
        click.echo(out / files.JSON)
    sys.exit(1 if any(result.failed for result in results) else 0)


def _choose(catalog: Catalog, texts: Iterable[str]) -> list[Choice]:
    """Return what the selectors select; a bare name or a folder selects all variants."""
    from oitbench.stability import suite

    chosen: dict[str, Choice] = {}
    for text in texts:
        found = catalog.expand_methods([text])
        if "[" not in text and not found[0].error:
            entry = catalog.entry("method", found[0].name)
            found = catalog.expand_methods(suite.variants(entry.name, entry.parameters))
        chosen |= {choice.label: choice for choice in found}
    return list(chosen.values())

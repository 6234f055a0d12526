"""`oitbench stability`: checks of promised identities, and hard cases."""

from __future__ import annotations

import sys
from pathlib import Path

import click

from oitbench.cli import options

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
@options.collections
def command(
    methods: tuple[str, ...], out: Path, as_json: bool, collections: tuple[Path, ...]
) -> None:
    """Check the identities that methods promise, and render hard cases.

    Each check renders scenes with a known answer. The table counts the checks that hold, of those
    that apply to the method. A hard case, or an identity that is not promised, may fail.

    The exit code is 1 if a promise is broken, a shader fails, a pixel is NaN, infinite or negative,
    or an image changes from one run to the next.
    """
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn

    from oitbench.catalog.checked import load_checked
    from oitbench.gl.device import Device
    from oitbench.method.declaration import Method
    from oitbench.results.schema import Renderer
    from oitbench.stability import files, suite, summary

    collection = load_checked(
        collections, lambda catalog: catalog.expand_methods(methods or catalog.names("method"))
    )
    chosen: dict[str, Method] = {}
    for text in methods or collection.methods:
        found = collection.expand_methods([text])
        if "[" not in text:
            found = suite.variants(collection, [found[0].name])
        chosen |= {method.label: method for method in found}
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn())
    console = Console(stderr=True)
    # In a file or a pipe, the bar would end in an empty line.
    hidden = not console.is_terminal
    with (
        Device() as device,
        Progress(*columns, console=console, transient=True, disable=hidden) as progress,
    ):
        task = progress.add_task("checks", total=len(suite.checks()) * len(chosen))
        results = suite.run(
            device,
            collection,
            list(chosen.values()),
            report=lambda result: progress.advance(task),
        )
        gl = Renderer(device.renderer, version=device.version, software=device.software)
    files.write(out, results, gl)
    if as_json:
        click.echo((out / files.JSON).read_text(encoding="utf-8"), nl=False)
    else:
        terminal = Console()
        terminal.width = max(terminal.width, _WIDTH)
        terminal.print(summary.table(results))
        for line in summary.listing(results):
            click.echo(line)
        click.echo(out / files.JSON)
    sys.exit(1 if any(result.failed for result in results) else 0)

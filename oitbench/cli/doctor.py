"""`oitbench doctor`: check this machine."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path

import click

from oitbench.catalog.catalog import Catalog
from oitbench.catalog.messages import Kind
from oitbench.cli import options
from oitbench.cli.checks import Checked, CheckOpenGL, CheckPathTracer, Finding, Nothing
from oitbench.errors import OitbenchError
from oitbench.workers import memory
from oitbench.workers.process import Process

_SECONDS = 120.0
_KINDS: tuple[Kind, ...] = ("method", "scene", "report")


@click.command()
@options.collections
def command(collections: tuple[Path, ...]) -> None:
    """Check OpenGL, the path tracer and the plugins; exit with 1 if something is missing."""
    well = True
    for finding in (*_machine(), *_plugins(collections)):
        click.echo(f"{'ok  ' if finding.well else 'FAIL'}  {finding.name}: {finding.value}")
        well = well and finding.well
    sys.exit(0 if well else 1)


def _machine() -> Iterator[Finding]:
    with Process("oitbench.cli.checks", Nothing(), Checked, memory.share(1)) as worker:
        for request, name in ((CheckOpenGL(), "OpenGL"), (CheckPathTracer(), "path tracer")):
            try:
                yield from worker.ask(request, Checked, _SECONDS).findings
            except OitbenchError as error:
                yield Finding(name, str(error), well=False)


def _plugins(collections: tuple[Path, ...]) -> Iterator[Finding]:
    try:
        catalog = Catalog(collections)
    except OitbenchError as error:
        yield Finding("collections", str(error), well=False)
        return
    with catalog:
        for problem in catalog.problems:
            yield Finding("collections", problem, well=False)
        for kind in _KINDS:
            names = catalog.names(kind)
            errors = filter(None, (catalog.entry(kind, name, check=True).error for name in names))
            found = "; ".join(errors)
            yield Finding(f"{kind}s", found or f"{len(names)}: {', '.join(names)}", not found)

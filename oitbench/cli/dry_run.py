"""`oitbench run --dry-run`: the cells of a run, and what they would take."""

from __future__ import annotations

import shlex
import shutil
import sys
from collections.abc import Sequence
from pathlib import Path

import click
from rich import box
from rich.console import Console
from rich.progress import Progress, SpinnerColumn, TextColumn
from rich.table import Table

from oitbench.matrix.cell import Cell
from oitbench.matrix.estimate import Estimate, SceneEstimate, estimate
from oitbench.matrix.forecast import duration
from oitbench.matrix.plan import Matrix
from oitbench.method.ablation import REQUESTED
from oitbench.workers.memory import GIB

_WIDE = 200
_WORDS = {"building": "building scenes"}


def print_plan(matrix: Matrix, engines: Sequence[str], verbose: bool) -> None:
    """Print the cells by scene, and the estimate.

    Parameters
    ----------
    matrix : Matrix
    engines : sequence of str
        Names of other engines, whose rows are not part of the estimate.
    verbose : bool
        Print each cell, too.
    """
    console = Console(stderr=True, highlight=False)
    columns = SpinnerColumn(), TextColumn("{task.description}", markup=False)
    hidden = not console.is_terminal
    with Progress(*columns, console=console, transient=True, disable=hidden) as progress:
        task = progress.add_task("starting")
        found = estimate(
            matrix,
            lambda labels, stage: progress.update(task, description=f"{labels}: {stage}"),
        )
    width = None if sys.stdout.isatty() else _WIDE
    Console(width=width, markup=False, highlight=False).print(_table(found.scenes))
    if verbose:
        _print_cells(found.scenes)
    for cell, reason in matrix.unusable.items():
        click.echo(f"fails: {_named(cell)}: {reason}")
    for line in _lines(found, matrix, engines):
        click.echo(line)


def _table(scenes: Sequence[SceneEstimate]) -> Table:
    table = Table("scene", box=box.SIMPLE)
    for title in ("methods", "cells", "done", "to do", "time"):
        table.add_column(title, justify="right")
    for scene in scenes:
        counts = scene.methods, len(scene.done) + len(scene.todo), len(scene.done), len(scene.todo)
        seconds = sum(scene.seconds.values())
        table.add_row(scene.label, *map(str, counts), duration(seconds) if seconds else "")
    return table


def _print_cells(scenes: Sequence[SceneEstimate]) -> None:
    for scene in scenes:
        for state, cells in (("done", scene.done), ("to do", scene.todo)):
            for cell in cells:
                click.echo(f"{state}: {_named(cell)}")


def _named(cell: Cell) -> str:
    """Return the labels of a cell, with its settings that are not the usual ones."""
    effects = "" if cell.effects == REQUESTED else f"effects {cell.effects}"
    settings = [f"{cell.size[0]}x{cell.size[1]}", f"ssaa {cell.ssaa}", effects, cell.shading]
    return f"{cell.seen} {cell.method}, {', '.join(filter(None, settings))}"


def _lines(found: Estimate, matrix: Matrix, engines: Sequence[str]) -> list[str]:
    done = sum(len(scene.done) for scene in found.scenes)
    lines = [f"cells: {done + found.todo}, {done} done, {found.todo} to do"]
    if found.seconds:
        parts = [
            f"{_WORDS.get(kind, kind)} {duration(seconds)}"
            for kind, seconds in found.seconds.items()
        ]
        lines += [
            f"time: about {duration(found.total)} on a machine as busy as now: {', '.join(parts)}",
            f"memory: about {found.memory / GIB:.1f} GiB for each worker",
            f"disk: about {_size(found.disk)}; {_size(_free(matrix.out))} are free",
        ]
    if found.unknown:
        lines.append(f"not estimated, as nothing could be drawn: {', '.join(found.unknown)}")
    if found.missing:
        counts = ", ".join(f"{count} {kind}" for kind, count in found.missing.items())
        lines.append(
            f"references: {counts} have to be rendered first, which can take hours and is not part"
            " of the estimate"
        )
    if engines:
        lines.append(f"engines: {', '.join(engines)} are not part of the estimate")
    again = [argument for argument in sys.argv[1:] if argument not in ("--dry-run", "--verbose")]
    return [*lines, f"next: {shlex.join(['oitbench', *again])}"]


def _size(count: float) -> str:
    return f"{count / GIB:.1f} GiB" if count >= 0.95 * GIB else f"{count / 2**20:.0f} MiB"


def _free(folder: Path) -> int:
    """Return the bytes that are free where a folder is, or will be."""
    while not folder.exists():
        folder = folder.absolute().parent
    return shutil.disk_usage(folder).free

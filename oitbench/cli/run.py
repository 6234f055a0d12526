"""`oitbench run`: the benchmark matrix."""

from __future__ import annotations

import shlex
import sys
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import click

from oitbench.cli import config, options
from oitbench.matrix.plan import CELL_SECONDS
from oitbench.truths import TRUTHS
from oitbench.views import MAIN

if TYPE_CHECKING:
    from oitbench.engines.record import EngineRow
    from oitbench.matrix.plan import Matrix
    from oitbench.matrix.run import Summary

_WIDE = 200


@click.command()
@config.option
@click.option(
    "--preset",
    type=click.Choice(["quick", "standard", "paper", "guard", "noise"]),
    default="quick",
    show_default=True,
    help="Size, parameter grid and rounds of timing. noise: random methods over 1 to 64 frames,"
    " with and without sub-pixels.",
)
@click.option(
    "--scene",
    "scenes",
    multiple=True,
    help="NAME[param=v,w], or a .glb, .gltf, .obj or .ply file. Repeatable."
    " Default: all of the preset.",
)
@click.option(
    "--method",
    "methods",
    multiple=True,
    help="NAME[param=v,w], or the folder of a method. Repeatable. Default: all of the preset.",
)
@click.option(
    "--engine",
    "engines",
    multiple=True,
    metavar="NAME[,NAME]...",
    help="Other engines that draw the scenes too, beside the methods that they compare with: vtk,"
    " pygfx, or that of a package. Repeatable. Default: none.",
)
@options.size(None, "Pixels of the image. Default: the preset's.")
@options.ssaa(None, "Default: 2; noise: 1 and 2.")
@options.effects_axis
@options.shading
@options.views
@click.option(
    "--truth",
    "truths",
    type=click.Choice(list(TRUTHS)),
    multiple=True,
    help="exact: exact compositing; matched: the light transport that the effects stand for; full:"
    " all of it. Repeatable; exact is always scored. Default: all three; guard: exact.",
)
@options.metrics("File of a metric by which cells are scored, too. Repeatable.")
@click.option(
    "--out",
    type=click.Path(path_type=Path),
    default=Path("results"),
    show_default=True,
    help="Folder of the results.",
)
@click.option("--force", is_flag=True, help="Run finished cells again.")
@options.timeout(
    CELL_SECONDS,
    "Seconds that each step of a cell may take: building its scene, tracing it, drawing.",
)
@options.memory
@options.workers("render at once; timing is never parallel")
@options.dask
@click.option(
    "--seed",
    type=click.IntRange(0),
    default=1,
    show_default=True,
    help="Seed of the order in which frames are timed.",
)
@options.collections
@click.pass_context
def command(
    context: click.Context,
    preset: str,
    scenes: tuple[str, ...],
    methods: tuple[str, ...],
    engines: tuple[str, ...],
    size: tuple[int, int] | None,
    ssaa: int | None,
    effects: tuple[str, ...],
    truths: tuple[str, ...],
    shading: tuple[str, ...],
    views: tuple[str, ...],
    metrics: tuple[Path, ...],
    out: Path,
    force: bool,
    timeout: float | None,
    memory_gib: float | None,
    workers: int,
    dask: str | None,
    seed: int,
    collections: tuple[Path, ...],
) -> None:
    """Render scenes with methods, score them against the truths, and account for their cost.

    Finished cells of an earlier run in the same folder are kept if nothing that determines them has
    changed; failed ones are tried again.

    The exit code is 1 if a cell failed, timed out, is unstable or is suspect, or if a metric of a
    file failed.
    """
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn

    from oitbench.engines import known
    from oitbench.matrix.cell import Cell
    from oitbench.matrix.plan import plan_matrix
    from oitbench.matrix.run import run_matrix
    from oitbench.results.schema import TROUBLED, Record

    chosen = known.choose(engines)
    matrix = plan_matrix(
        scenes, methods, preset, size, effects, ssaa, out, collections, seed, force,
        timeout, workers, memory_gib, truths, shading, views or (MAIN,), metrics, dask or "",
    )  # fmt: skip
    matrix = replace(matrix, config=config.text(context, context.params))
    console = Console(stderr=True, highlight=False, soft_wrap=True)
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn())
    # In a file or a pipe, the bar would end in an empty line.
    hidden = not console.is_terminal
    with Progress(*columns, console=console, transient=True, disable=hidden) as progress:
        task = progress.add_task("cells", total=len(matrix.cells))

        def note(line: str) -> None:
            console.print(line, markup=False)

        def show(cell: Cell, record: Record | None) -> None:
            progress.advance(task)
            if record is not None and (record.status in TROUBLED or record.status == "skipped"):
                note(f"{record.status}: {cell.seen} {cell.method}: {record.reason}")

        summary = run_matrix(matrix, show, note)
        rows = _run_engines(matrix, chosen, note)
    _print_end(out, summary)
    faults = [row for row in rows if row.status in TROUBLED]
    sys.exit(1 if faults else summary.exit_code)


def _run_engines(
    matrix: Matrix, engines: Sequence[str], note: Callable[[str], None]
) -> list[EngineRow]:
    """Run the rows of other engines, and print those without a picture or a time."""
    from oitbench.engines.run import Job, run

    def show(row: EngineRow) -> None:
        if row.reason:
            note(f"{row.status}: {row.place.seen} {row.label}: {row.reason}")

    if not engines:
        return []
    cells = [cell.key for cell in matrix.cells]
    return run(
        Job(
            engines, cells, matrix.out, matrix.plugins, matrix.schedule,
            matrix.timeout, matrix.memory_limit,
        ),
        show,
    )  # fmt: skip


def _print_end(out: Path, summary: Summary) -> None:
    """Print the cells that a user should look at, the summary, and the next commands."""
    if summary.warning:
        click.echo(f"disturbed: {summary.warning}", err=True)
    for fault in summary.faults:
        click.echo(f"metric: {fault}", err=True)
    if summary.troubled:
        _print_table(summary)
    click.echo(f"{out}: {summary}")
    if any(not record.finished for record in summary.troubled):
        again = [argument for argument in sys.argv[1:] if argument != "--force"]
        click.echo(f"failed cells again: {shlex.join(['oitbench', *again])}")
    click.echo(f"next: {shlex.join(['oitbench', 'report', str(out)])}")


def _print_table(summary: Summary) -> None:
    from rich import box
    from rich.console import Console
    from rich.table import Table

    table = Table(box=box.SIMPLE)
    for title in ("status", "scene", "method", "effects", "reason"):
        table.add_column(title, overflow="fold")
    for record in summary.troubled:
        table.add_row(record.status, record.seen, record.method, record.effects, record.reason)
    # Keep whole labels in files and pipes.
    width = None if sys.stdout.isatty() else _WIDE
    Console(width=width, markup=False, highlight=False).print(table)

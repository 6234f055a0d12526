"""`oitbench run`: the benchmark matrix."""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import click

from oitbench.cli import config, options
from oitbench.cli.suite import free_options
from oitbench.errors import UsageError
from oitbench.matrix.plan import CELL_SECONDS
from oitbench.truths import TRUTHS
from oitbench.views import MAIN

if TYPE_CHECKING:
    from oitbench.engines.record import EngineRow
    from oitbench.matrix.plan import Matrix


@click.command()
@config.option
@click.option(
    "--suite",
    metavar="NAME",
    help="Frozen suite, such as oitbench-1: it fixes scenes, views, size, sub-pixels, effects,"
    " shading, truths, seed and timing.",
)
@click.option(
    "--preset",
    type=click.Choice(["quick", "standard", "paper", "guard", "noise"]),
    default="quick",
    show_default=True,
    help="Size, parameters and rounds of timing. standard: all methods and scenes, and sweeps of"
    " cost; paper: all parameter grids; noise: random methods over 1 to 64 frames, with and without"
    " sub-pixels.",
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
@options.execution(CELL_SECONDS)
@click.option(
    "--seed",
    type=click.IntRange(0),
    default=1,
    show_default=True,
    help="Seed of the order in which frames are timed.",
)
@click.option(
    "--dry-run",
    is_flag=True,
    help="Only list the cells, and estimate time, memory and disk space; write nothing.",
)
@click.option("--verbose", is_flag=True, help="With --dry-run: list each cell.")
@click.option(
    "--quiet",
    is_flag=True,
    help="Print only what went wrong, and the last line.",
)
@options.collections
@click.pass_context
def command(
    context: click.Context,
    suite: str | None,
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
    dry_run: bool,
    verbose: bool,
    quiet: bool,
    collections: tuple[Path, ...],
) -> None:
    """Render scenes with methods, score them against the truths, and account for their cost.

    Finished cells of an earlier run in the same folder are kept if nothing that determines them has
    changed; failed ones are tried again.

    The exit code is 1 if a cell failed, timed out, is unstable or is suspect, or if a metric of a
    file failed.
    """
    from oitbench.cli.dry_run import print_plan
    from oitbench.cli.run_end import print_end
    from oitbench.cli.run_progress import RunProgress
    from oitbench.engines import known
    from oitbench.matrix.plan import plan_matrix
    from oitbench.matrix.run import run_matrix
    from oitbench.results.schema import TROUBLED
    from oitbench.suites.planning import plan_suite

    if verbose and not dry_run:
        raise UsageError("--verbose needs --dry-run")
    chosen = known.choose(engines)
    given = dict(context.params)
    if suite:
        given = free_options(suite, context)
        matrix = plan_suite(
            suite, methods, collections, out=out, force=force, timeout=timeout, workers=workers,
            memory_gib=memory_gib, metrics=metrics, dask=dask,
        )  # fmt: skip
    else:
        matrix = plan_matrix(
            scenes, methods, preset, size, effects, ssaa, out, collections, seed, force,
            timeout, workers, memory_gib, truths, shading, views or (MAIN,), metrics, dask,
        )  # fmt: skip
    if dry_run:
        print_plan(matrix, chosen, verbose)
        return
    matrix = replace(matrix, config=config.text(context, given))
    with RunProgress(matrix, quiet) as shown:
        summary = run_matrix(matrix, shown.record, shown.line, shown.stage, shown.timed)
        rows = _run_engines(matrix, chosen, shown.line)
    print_end(out, summary, quiet)
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

"""`oitbench run`: the benchmark matrix."""

from __future__ import annotations

from pathlib import Path

import click

from oitbench.cli import options


@click.command()
@click.option(
    "--preset",
    type=click.Choice(["quick", "standard", "paper", "guard"]),
    default="quick",
    show_default=True,
    help="Size, parameter grid and rounds of timing.",
)
@click.option("--scene", "scenes", multiple=True, help="NAME[param=v,w]; repeatable. All without.")
@click.option(
    "--method",
    "methods",
    multiple=True,
    help="NAME[param=v,w] or a method's folder; repeatable. All without.",
)
@options.size(None, "Pixels of the image; the preset's without.")
@options.ssaa
@options.effects_axis
@click.option("--out", type=click.Path(path_type=Path), default=Path("results"), show_default=True)
@click.option("--force", is_flag=True, help="Do finished cells again.")
@click.option("--timeout", type=float, help="Seconds that one cell may take.")
@click.option("--workers", type=click.IntRange(1), default=1, show_default=True)
@click.option("--seed", type=click.IntRange(0), default=1, show_default=True)
@options.collections
def command(
    preset: str,
    scenes: tuple[str, ...],
    methods: tuple[str, ...],
    size: tuple[int, int] | None,
    ssaa: int,
    effects: tuple[str, ...],
    out: Path,
    force: bool,
    timeout: float | None,
    workers: int,
    seed: int,
    collections: tuple[Path, ...],
) -> None:
    """Render scenes with methods, hold them against both truths, and account for their cost.

    Finished cells of an earlier run in the same folder are kept; failed ones are tried again.
    """
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn

    from oitbench.matrix import run as matrix
    from oitbench.matrix.cell import Cell
    from oitbench.results.store import Record

    asked = matrix.plan(
        scenes, methods, preset, size, effects, ssaa, out, collections, seed, force,
        timeout, workers,
    )  # fmt: skip
    console = Console(stderr=True)
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn())
    with Progress(*columns, console=console, transient=True) as progress:
        task = progress.add_task("cells", total=len(asked.cells))

        def report(cell: Cell, record: Record) -> None:
            progress.advance(task)
            if record["status"] not in ("ok", "unstable"):
                console.print(
                    f"{record['status']}: {cell.scene} {cell.method}: {record['reason']}",
                    markup=False,
                    highlight=False,
                )

        outcome = matrix.run(asked, report)
    click.echo(f"{out}: {outcome}")

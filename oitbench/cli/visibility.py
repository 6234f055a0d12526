"""`oitbench visibility`: the visibility that each method gives each depth of one pixel."""

from __future__ import annotations

import re
from pathlib import Path

import click

from oitbench.cli import options
from oitbench.errors import UsageError
from oitbench.measure.visibility import STEP_SECONDS


def _read_pixel(ctx: click.Context, parameter: click.Parameter, value: str) -> tuple[int, int]:
    match = re.fullmatch(r"\s*(\d+)\s*,\s*(\d+)\s*", value)
    if match is None:
        raise UsageError(f"cannot read pixel '{value}'; write column,row as in 128,96")
    return int(match[1]), int(match[2])


@click.command()
@click.argument("scene")
@click.option(
    "--pixel", required=True, callback=_read_pixel, help="Column,row from the top left, from 0."
)
@click.option(
    "--method",
    "methods",
    multiple=True,
    help="NAME[param=v,w] or a method's folder. Repeatable. Default: all, with their defaults.",
)
@options.size("256x256", "Size of the frame that contains the pixel.")
@click.option(
    "-o",
    "--out",
    type=click.Path(file_okay=False, path_type=Path),
    default=Path("results") / "visibility",
    show_default=True,
    help="Folder of visibility.csv, .json, .png and .pdf.",
)
@options.timeout(
    STEP_SECONDS, "Seconds that each step may take: building the scene, measuring one method."
)
@options.memory
@options.collections
def command(
    scene: str,
    pixel: tuple[int, int],
    methods: tuple[str, ...],
    size: tuple[int, int],
    out: Path,
    timeout: float | None,
    memory_gib: float | None,
    collections: tuple[Path, ...],
) -> None:
    """Measure the visibility curves of exact compositing and of methods at one pixel of SCENE."""
    from oitbench.measure.pixel import measure
    from oitbench.report.visibility import write

    curves = measure(scene, pixel, methods, size, collections, timeout, memory_gib)
    for label, reason in curves.reasons.items():
        click.echo(f"skipped {label}: {reason}", err=True)
    click.echo(write(curves, out).png)

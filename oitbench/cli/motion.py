"""`oitbench motion`: what flickers and what pops while a camera moves."""

from __future__ import annotations

import sys
from pathlib import Path

import click

from oitbench.cli import options
from oitbench.filenames import file_name
from oitbench.motion.path import FRAMES, TURNS
from oitbench.motion.run import FRAME_SECONDS
from oitbench.views import MAIN, seen


@click.command()
@click.argument("scene")
@click.option(
    "--method",
    "methods",
    multiple=True,
    required=True,
    help="NAME[param=v,w] or a method's folder. Repeatable. A method with a seed is filmed twice:"
    " with the same random numbers in all frames, and with others in each.",
)
@click.option(
    "--frames",
    type=click.IntRange(2, 10_000),
    help=f"Number of frames. Default: those of the scene's own path, or {FRAMES}.",
)
@click.option(
    "--turns",
    type=float,
    help="Length of an orbit about the target of the scene's camera, in full turns. Default: the"
    f" scene's own path; {TURNS} if it has none.",
)
@click.option(
    "--view",
    default=MAIN,
    show_default=True,
    help="Camera with which an orbit begins; `oitbench list scenes` prints the names.",
)
@options.size("256x256", "Size of each frame in pixels.")
@options.ssaa(2)
@click.option(
    "--out",
    type=click.Path(file_okay=False, path_type=Path),
    help="Folder of motion.json, motion.csv, the frames and the figures. Default:"
    " results/motion/SCENE, where 'oitbench report results' finds it.",
)
@click.option(
    "--clip",
    type=click.Choice(("webp", "gif", "none")),
    default="webp",
    show_default=True,
    help="Format of the clips: exact compositing, the method and its excess change, side by side.",
)
@options.shading
@options.timeout(FRAME_SECONDS, "Seconds that each frame may take.")
@options.memory
@options.collections
def command(
    scene: str,
    methods: tuple[str, ...],
    frames: int | None,
    turns: float | None,
    view: str,
    size: tuple[int, int],
    ssaa: int,
    out: Path | None,
    clip: str,
    shading: tuple[str, ...],
    timeout: float | None,
    memory_gib: float | None,
    collections: tuple[Path, ...],
) -> None:
    """Film methods in SCENE along a path of cameras, and compare them with exact compositing.

    A method pops if its picture jumps however small the step of the camera is, and flickers if it
    changes more than the exact one, or with the random numbers alone.
    """
    from oitbench.motion.run import film
    from oitbench.report import clips, motion
    from oitbench.report.artifacts import writing_to

    out = out or Path("results") / "motion" / file_name(seen(scene, view))
    found = film(
        scene,
        methods,
        out,
        frames=frames,
        turns=turns,
        view=view,
        size=size,
        ssaa=ssaa,
        shading=shading,
        collections=collections,
        timeout=timeout,
        memory_gib=memory_gib,
        on_track=lambda label: click.echo(f"filming {label}", err=True),
    )
    footage = motion.Footage(out, found)
    with writing_to(out):
        strip, plot, table = motion.write(footage, out)
        written = [] if clip == "none" else clips.write(footage, out / "clips", clip)
    headings = [column.title for column in table.columns]
    click.echo(f"| {' | '.join(headings)} |\n|{' --- |' * len(headings)}")
    for row in table.rows:
        cells = [column.text(value) for column, value in zip(table.columns, row, strict=True)]
        click.echo(f"| {' | '.join(cells)} |")
    for label, reason in found.failed.items():
        click.echo(f"failed {label}: {reason}", err=True)
    for path in (strip.png, plot.png, *written):
        click.echo(path)
    sys.exit(1 if found.failed else 0)

"""`oitbench render`: render one picture."""

from __future__ import annotations

from pathlib import Path

import click

from oitbench.cli import options
from oitbench.errors import UsageError
from oitbench.matrix.plan import CELL_SECONDS


@click.command()
@click.argument("scene")
@click.argument("method")
@click.option(
    "-o",
    "--out",
    required=True,
    type=click.Path(dir_okay=False, path_type=Path),
    help="File of the picture: .exr for linear radiance, .png for display.",
)
@options.size("512x512", "Size of the picture in pixels.")
@options.ssaa
@options.effects
@options.shading
@options.timeout(CELL_SECONDS, "Seconds that the picture may take.")
@options.memory
@options.collections
def command(
    scene: str,
    method: str,
    out: Path,
    size: tuple[int, int],
    ssaa: int,
    effects: str,
    shading: tuple[str, ...],
    timeout: float | None,
    memory_gib: float | None,
    collections: tuple[Path, ...],
) -> None:
    """Render SCENE with METHOD. Both are NAME[param=v]; METHOD can also be a folder."""
    from oitbench.image import files as images
    from oitbench.matrix.picture import render

    if out.suffix not in (".exr", ".png"):
        raise UsageError(f"{out}: unknown format of a picture; end the name in .exr or .png")
    image, exposure = render(
        scene, method, size, ssaa, effects, collections, timeout, memory_gib, shading
    )
    if out.suffix == ".exr":
        images.write_exr(out, image)
    else:
        images.write_png(out, images.to_srgb(image, exposure))

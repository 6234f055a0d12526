"""`oitbench render`: render one picture, or the targets behind it."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import click

from oitbench.cli import options
from oitbench.errors import UsageError
from oitbench.filenames import file_name
from oitbench.matrix.plan import CELL_SECONDS
from oitbench.views import MAIN, seen

if TYPE_CHECKING:
    from oitbench.matrix.targets import DrawnTarget


def _read_names(ctx: click.Context, parameter: click.Parameter, value: str | None) -> list[str]:
    names = [part.strip() for part in (value or "").split(",") if part.strip()]
    if value is not None and not names:
        raise UsageError(f"cannot read targets '{value}'; give names, all or list")
    alone = {"all", "list"}.intersection(names)
    if alone and len(names) > 1:
        raise UsageError(f"targets '{value}': give {' or '.join(sorted(alone))} alone")
    return list(dict.fromkeys(names))


@click.command()
@click.argument("scene")
@click.argument("method")
@click.option(
    "-o",
    "--out",
    type=click.Path(dir_okay=False, path_type=Path),
    help="File of the picture: .exr for linear radiance, .png for display.",
)
@click.option(
    "--target",
    "targets",
    metavar="NAME[,NAME]...|all|list",
    callback=_read_names,
    help="Write what the method stores instead, such as beta or shadow_map, texel by texel: .exr"
    " as it is, .png for looking; a line of each file states its range. Several go to FILE-NAME."
    " list: print their names, and write nothing.",
)
@options.size("512x512", "Size of the picture in pixels.")
@click.option(
    "--ssaa",
    type=click.IntRange(1, 16),
    help="Side of the grid of sub-pixels, which are averaged. Default: 2; 1 with --target.",
)
@options.effects
@options.shading
@options.views
@options.timeout(CELL_SECONDS, "Seconds that the picture may take.")
@options.memory
@options.collections
def command(
    scene: str,
    method: str,
    out: Path | None,
    targets: list[str],
    size: tuple[int, int],
    ssaa: int | None,
    effects: str,
    shading: tuple[str, ...],
    views: tuple[str, ...],
    timeout: float | None,
    memory_gib: float | None,
    collections: tuple[Path, ...],
) -> None:
    """Render SCENE with METHOD. Both are NAME[param=v]; METHOD can also be a folder.

    Several views go to FILE@NAME.
    """
    from oitbench.image import files as images
    from oitbench.matrix import picture
    from oitbench.matrix.targets import LIST, draw

    rest = effects, collections, timeout, memory_gib, shading
    if targets == [LIST]:
        _print_list(draw(scene, method, targets, size, ssaa or 1, *rest, *views[:1]))
        return
    if out is None:
        raise UsageError("Missing option '-o' / '--out'.")
    if out.suffix not in (".exr", ".png"):
        raise UsageError(f"{out}: unknown format of a picture; end the name in .exr or .png")
    for view in views or (MAIN,):
        path = out.with_stem(seen(out.stem, view)) if len(views) > 1 else out
        if targets:
            _write(path, targets, draw(scene, method, targets, size, ssaa or 1, *rest, view))
            continue
        image, exposure = picture.render(scene, method, size, ssaa or 2, *rest, view)
        if path.suffix == ".exr":
            images.write_exr(path, image)
        else:
            images.write_png(path, images.to_srgb(image, exposure))


def _print_list(drawn: Sequence[DrawnTarget]) -> None:
    width = max(len(item.facts.name) for item in drawn)
    for item in drawn:
        texels = "x".join(map(str, item.facts.size))
        click.echo(f"{item.facts.name:{width}}  {texels}  {item.facts.format}")


def _write(out: Path, names: Sequence[str], drawn: Sequence[DrawnTarget]) -> None:
    """Write each target to a file, and print a line about it."""
    from oitbench.image import files as images
    from oitbench.matrix.targets import ALL

    several = len(names) > 1 or names == [ALL]
    for item in drawn:
        name = item.facts.name
        path = out.with_stem(f"{out.stem}-{file_name(name)}") if several else out
        picture = item.picture
        text = f"{name}, {item.facts.format}: {picture.text}"
        if out.suffix == ".exr":
            item.write_exr(path)
            click.echo(f"{path}: {name}, {item.facts.format}")
        else:
            images.write_png(path, picture.srgb, text)
            click.echo(f"{path}: {text}")

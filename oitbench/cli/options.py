"""Options that several verbs share."""

from __future__ import annotations

import re
from pathlib import Path

import click

from oitbench.errors import UsageError


class Size(click.ParamType):
    """`WxH` in pixels."""

    name = "WxH"

    def convert(
        self, value: object, param: click.Parameter | None, ctx: click.Context | None
    ) -> tuple[int, int]:
        match = re.fullmatch(r"(\d+)x(\d+)", str(value))
        if match is None:
            raise UsageError(f"cannot read size '{value}'; write it as 640x360")
        width, height = int(match[1]), int(match[2])
        if min(width, height) < 1:
            raise UsageError(f"size {width}x{height} is empty; both sides must be at least 1")
        return width, height


SIZE = Size()
collections = click.option(
    "--collection",
    "collections",
    multiple=True,
    type=click.Path(path_type=Path),
    help="Folder with further methods, scenes or reports; repeatable.",
)
ssaa = click.option(
    "--ssaa",
    type=click.IntRange(1, 16),
    default=2,
    show_default=True,
    help="Side of the sub-pixel grid of accuracy images.",
)
effects = click.option(
    "--effects",
    default="called",
    show_default=True,
    help="called, all, none, or names to leave out, as in -diffusion,-refraction.",
)

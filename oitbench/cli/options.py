"""Options that several verbs share."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

import click

from oitbench.errors import UsageError

Command = TypeVar("Command", bound=Callable[..., Any])


def parse_size(text: str) -> tuple[int, int]:
    """Return (width, height) from `WxH`; raise `UsageError` if it is no size."""
    match = re.fullmatch(r"(\d+)x(\d+)", text)
    if match is None:
        raise UsageError(f"cannot read size '{text}'; write it as 640x360")
    width, height = int(match[1]), int(match[2])
    if min(width, height) < 1:
        raise UsageError(f"size {width}x{height} is empty; both sides must be at least 1")
    return width, height


def _read_size(
    ctx: click.Context, parameter: click.Parameter, value: str | None
) -> tuple[int, int] | None:
    return None if value is None else parse_size(value)


def size(default: str | None, told: str) -> Callable[[Command], Command]:
    """Return the option `--size`, whose value is (width, height) in pixels."""
    return click.option(
        "--size", metavar="WxH", default=default, show_default=True, callback=_read_size, help=told
    )


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
_EFFECTS = (
    "called, all, none, or names to leave out, as in -diffusion,-refraction; with each goes what"
    " means nothing without it, as colored shadows without translucent ones."
)
effects = click.option("--effects", default="called", show_default=True, help=_EFFECTS)
effects_axis = click.option(
    "--effects",
    multiple=True,
    default=("called",),
    show_default=True,
    help=f"{_EFFECTS} Repeatable. 'each': called and, one at a time, without every effect that a"
    " scene calls for and a method draws differently without.",
)

"""Options that several commands share."""

from __future__ import annotations

import math
import re
import webbrowser
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, TypeVar

import click

from oitbench.errors import UsageError, unknown
from oitbench.method.ablation import EACH, REQUESTED
from oitbench.shading import PARAMETERS
from oitbench.views import MAIN
from oitbench.views import parse as parse_views

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


def size(default: str | None, help_text: str) -> Callable[[Command], Command]:
    """Return the option `--size`, whose value is (width, height) in pixels."""
    return click.option(
        "--size",
        metavar="WxH",
        default=default,
        show_default=default is not None,
        callback=_read_size,
        help=help_text,
    )


def kind(kinds: Sequence[str], required: bool = True) -> Callable[[Command], Command]:
    """Return the argument KIND, which may be in the singular or in the plural."""

    def read(ctx: click.Context, parameter: click.Parameter, value: str | None) -> str | None:
        if value is None:
            return None
        for known in (value, f"{value}s", value.removesuffix("s")):
            if known in kinds:
                return known
        raise unknown("kind", value, kinds)

    def complete(ctx: click.Context, parameter: click.Parameter, begun: str) -> list[str]:
        return [name for name in kinds if name.startswith(begun)]

    return click.argument("kind", callback=read, required=required, shell_complete=complete)


def parse_timeout(text: str) -> float | None:
    """Return seconds, or None for no limit; raise `UsageError` if `text` is neither."""
    if text.lower() in ("none", "0"):
        return None
    try:
        seconds = float(text)
    except ValueError:
        raise UsageError(f"cannot read timeout '{text}'; give seconds, or none") from None
    if not 0 < seconds < math.inf:
        raise UsageError(f"timeout is {seconds:g} s; give seconds above 0, or none for no limit")
    return seconds


def _read_timeout(ctx: click.Context, parameter: click.Parameter, value: str) -> float | None:
    return parse_timeout(value)


def metrics(help_text: str) -> Callable[[Command], Command]:
    """Return the option `--metric`, whose value is files of metrics."""
    return click.option(
        "--metric",
        "metrics",
        multiple=True,
        metavar="FILE",
        type=click.Path(path_type=Path),
        help=help_text,
    )


def timeout(default: float, step: str) -> Callable[[Command], Command]:
    """Return the option `--timeout`, whose value is seconds, or None for no limit."""
    return click.option(
        "--timeout",
        metavar="SECONDS|none",
        default=f"{default:g}",
        show_default=True,
        callback=_read_timeout,
        help=f"{step} none or 0: no limit.",
    )


collections = click.option(
    "--collection",
    "collections",
    multiple=True,
    type=click.Path(path_type=Path),
    help="Folder with further methods, scenes or reports. Repeatable.",
)


def workers(doing: str) -> Callable[[Command], Command]:
    """Return the option `--workers`; `doing` tells what so many processes do."""
    return click.option(
        "--workers",
        type=click.IntRange(0),
        default=1,
        show_default=True,
        help=f"Processes that {doing}. 0: everything happens in this process, for debugging; a"
        " crash ends the command, and no time or memory is limited.",
    )


dask = click.option(
    "--dask",
    metavar="ADDRESS",
    help="Scheduler of a Dask cluster whose workers are used instead of processes of this machine,"
    " as in tcp://10.0.0.1:8786. Needs: pip install 'oitbench[cluster]'.",
)
memory = click.option(
    "--memory",
    "memory_gib",
    metavar="GIB",
    type=float,
    help="Memory that each worker process may use, in GiB; work that needs more fails."
    " Default: 75 % of the machine's memory, divided by the number of workers.",
)


def execution(seconds: float) -> Callable[[Command], Command]:
    """Add the options that say how cells are run; a step takes at most `seconds` by default."""
    added: Sequence[Callable[[Command], Command]] = (
        click.option("--force", is_flag=True, help="Run finished cells again."),
        timeout(
            seconds,
            "Seconds that each step of a cell may take: building its scene, tracing it, drawing.",
        ),
        memory,
        workers("render at once; timing is never parallel"),
        dask,
    )

    def decorate(command: Command) -> Command:
        # The last decorator of a command is applied first, and its option is listed last.
        for decorator in reversed(added):
            command = decorator(command)
        return command

    return decorate


def ssaa(default: int | None, text: str = "") -> Callable[[Command], Command]:
    """Return the option `--ssaa`; `text` explains a default of None."""
    return click.option(
        "--ssaa",
        type=click.IntRange(1, 16),
        default=default,
        show_default=default is not None,
        help=f"Side of the sub-pixel grid of accuracy images. {text}".strip(),
    )


open_page = click.option("--open", "opens", is_flag=True, help="Open the page in the browser.")


def show_page(path: Path) -> None:
    """Open a page in the browser; a line says so if there is none."""
    if not webbrowser.open(path.resolve().as_uri()):
        click.echo(f"no browser was found; open {path}", err=True)


_SETTINGS = "; ".join(f"{name}: {item.help}" for name, item in PARAMETERS.items())
shading = click.option(
    "--shading",
    multiple=True,
    metavar="NAME=VALUE,...",
    help=f"Settings of the shading that all methods share. Repeatable. {_SETTINGS}.",
)


def views_or(default: str) -> Callable[[Command], Command]:
    """Return the option `--view`; `default` tells what no view stands for."""
    return click.option(
        "--view",
        "views",
        multiple=True,
        metavar="NAME[,NAME]...",
        callback=lambda ctx, parameter, value: parse_views(value),
        help="Cameras of the scenes; `oitbench list scenes` prints their names. Repeatable."
        f"  [default: {default}]",
    )


views = views_or(MAIN)
_EFFECTS = (
    f"{REQUESTED}: those that the scene requests; all; none; or names to leave out, as in"
    " -diffusion,-refraction. Effects that depend on them, such as colored shadows on translucent"
    " ones, are left out too."
)
effects = click.option("--effects", default=REQUESTED, show_default=True, help=_EFFECTS)
effects_axis = click.option(
    "--effects",
    multiple=True,
    default=(REQUESTED,),
    show_default=True,
    help=f"{_EFFECTS} Repeatable. {EACH}: {REQUESTED}, and the same with each effect left out"
    " in turn that changes the method's picture.",
)

"""Files of options: `oitbench run --config FILE.toml`, and what every run writes to repeat it.

A file holds the long names of options, such as `size = "512x512"`; repeatable ones take lists.
Options of the command line replace those of the file.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, TypeVar

import click

from oitbench.errors import UsageError, unknown

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

Command = TypeVar("Command", bound=Callable[..., Any])
NAME = "config"
_ONCE = (NAME, "force", "help", "dry-run", "verbose", "quiet")
"""Options that are about one run only."""


def option(command: Command) -> Command:
    """Add the option `--config`."""
    return click.option(
        f"--{NAME}",
        type=click.Path(path_type=Path),
        is_eager=True,
        expose_value=False,
        callback=_read,
        metavar="FILE.toml",
        help="File of options by their long names; those given here replace its own. The run.toml"
        " of a results folder repeats its run.",
    )(command)


def _read(context: click.Context, parameter: click.Parameter, path: Path | None) -> None:
    """Take the options of a file as defaults."""
    if path is None:
        return
    try:
        found = tomllib.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise UsageError(f"{path} cannot be read ({error.strerror})") from error
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise UsageError(f"{path} is no TOML file: {error}") from error
    context.default_map = _defaults(context.command, found, path)


def _defaults(command: click.Command, found: Mapping[str, Any], path: Path) -> dict[str, Any]:
    """Return values by the names of click's parameters."""
    options = _options(command)
    defaults: dict[str, Any] = {}
    for name, value in found.items():
        if name not in options:
            error = unknown("option", name, options)
            raise UsageError(f"{path}: {error}")
        option = options[name]
        several = isinstance(value, list)
        if several and not option.multiple:
            raise UsageError(f"{path}: {name} takes one value, not a list")
        values = value if several else [value]
        if not all(isinstance(item, str | int | float) for item in values):
            raise UsageError(f"{path}: {name} takes text or numbers, not {value!r}")
        defaults[str(option.name)] = values if option.multiple else value
    return defaults


def _options(command: click.Command) -> dict[str, click.Option]:
    """Return the options of a command that a file may hold, by their long names."""
    found = {}
    for parameter in command.params:
        if isinstance(parameter, click.Option):
            name = max(parameter.opts, key=len).removeprefix("--")
            if name not in _ONCE:
                found[name] = parameter
    return found


def text(context: click.Context, given: Mapping[str, Any]) -> str:
    """Return the file that repeats a command.

    Parameters
    ----------
    context : click.Context
    given : mapping of str to object
        Values of options by the names of click's parameters, as the command received them. Others
        keep their defaults.
    """
    lines = []
    for name, option in _options(context.command).items():
        if option.name not in given:
            continue
        value = given[option.name]
        if value is None and isinstance(option.default, str):
            value = "none"
        if value is None or value == ():
            continue
        shown = [*map(_shown, value)] if option.multiple else _shown(value)
        lines.append(f"{name} = {json.dumps(shown, ensure_ascii=True)}\n")
    return "".join(lines)


def _shown(value: Any) -> str | int | float:
    """Return a value as the command line takes it."""
    if isinstance(value, tuple):
        return "x".join(map(str, value))
    return value if isinstance(value, int | float) else str(value)

"""The command line: one file per verb, imported when it is called."""

from __future__ import annotations

import importlib
import sys

import click

from oitbench.errors import OitbenchError, unknown

VERBS = (
    "run",
    "render",
    "list",
    "stability",
    "visibility",
    "reference",
    "report",
    "compare",
    "baseline",
    "doctor",
)


class _Verbs(click.Group):
    """The group of all verbs; each is in the module of its name."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        return [*VERBS]

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        if cmd_name not in VERBS:
            return None
        module = importlib.import_module(f"oitbench.cli.{cmd_name.replace('-', '_')}")
        command: click.Command = module.command
        return command

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        if args and args[0] not in VERBS and not args[0].startswith("-"):
            raise unknown("command", args[0], VERBS)
        return super().resolve_command(ctx, args)


@click.group(cls=_Verbs, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(package_name="oitbench")
def group() -> None:
    """Benchmark order-independent transparency: accuracy, time, memory and traffic."""


def main() -> None:
    """Run the command line. An error that a user can fix is one line, with exit code 2."""
    try:
        group.main(standalone_mode=False)
    except click.exceptions.Exit as stop:
        sys.exit(stop.exit_code)
    except click.ClickException as error:
        click.echo(f"oitbench: {error.format_message()}", err=True)
        sys.exit(error.exit_code)
    except OitbenchError as error:
        click.echo(f"oitbench: {error}", err=True)
        sys.exit(2)
    except (KeyboardInterrupt, click.exceptions.Abort):
        click.echo("oitbench: stopped; finished cells are kept, run again to resume", err=True)
        sys.exit(130)

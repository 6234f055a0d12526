"""The command line: one file per verb, imported when it is called."""

from __future__ import annotations

import errno
import importlib
import io
import keyword
import os
import signal
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress

import click

from oitbench.errors import OitbenchError, unknown

VERBS = (
    "run",
    "render",
    "list",
    "stability",
    "visibility",
    "motion",
    "fit",
    "reference",
    "import",
    "new",
    "score",
    "merge",
    "report",
    "reproduce",
    "submit",
    "choose",
    "compare",
    "baseline",
    "doctor",
)
_COMPLETE = "_OITBENCH_COMPLETE"
"""Variable of the environment through which shells ask for completions."""
_FULL = (errno.ENOSPC, errno.EDQUOT, errno.EIO)


class _Verbs(click.Group):
    """The group of all verbs; each is in the module of its name."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        return [*VERBS]

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        if cmd_name not in VERBS:
            return None
        name = cmd_name.replace("-", "_")
        # A keyword of Python is no name of a module.
        name = f"{name}_" if keyword.iskeyword(name) else name
        module = importlib.import_module(f"oitbench.cli.{name}")
        command: click.Command = module.command
        return command

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        if args and args[0] not in VERBS and not args[0].startswith("-"):
            raise unknown("command", args[0], VERBS)
        return super().resolve_command(ctx, args)


@click.group(
    cls=_Verbs,
    context_settings={"help_option_names": ["-h", "--help"]},
    invoke_without_command=True,
)
@click.version_option(package_name="oitbench")
@click.pass_context
def group(context: click.Context) -> None:
    """Benchmark order-independent transparency: accuracy, time, memory and traffic."""
    if context.invoked_subcommand is None:
        click.echo(context.get_help())


class _SignalError(KeyboardInterrupt):
    """A signal asks this process to end."""


def main() -> None:
    """Run the command line. An error that a user can fix is one line, with exit code 2."""
    _accept_all_characters()
    _complete_words()
    with _signals_raised():
        code = _run()
    sys.exit(code)


def _complete_words() -> None:
    """Answer the shell that asks how a line may go on, and end."""
    from click.shell_completion import shell_complete

    instruction = os.environ.get(_COMPLETE)
    if instruction is not None:
        sys.exit(shell_complete(group, {}, "oitbench", _COMPLETE, instruction))


def _run() -> int:
    """Run the command line and return its exit code."""
    try:
        # `group.main` would hide a closed pipe.
        with group.make_context("oitbench", sys.argv[1:]) as context:
            group.invoke(context)
        if sys.stdout is not None:
            sys.stdout.flush()
    except click.exceptions.Exit as stop:
        return stop.exit_code
    except BrokenPipeError:
        return _end_of_pipe()
    except SystemExit as stop:
        # This is how rich reports a closed pipe.
        if isinstance(stop.__context__, BrokenPipeError):
            return _end_of_pipe()
        raise
    except click.ClickException as error:
        return _complain(error.format_message(), error.exit_code)
    except OitbenchError as error:
        return _complain(str(error))
    except OSError as error:
        if error.errno not in _FULL:
            raise
        _discard_output()
        return _complain(f"the output cannot be written ({error.strerror}); free some space")
    except (KeyboardInterrupt, click.exceptions.Abort) as error:
        number = error.args[0] if isinstance(error, _SignalError) else signal.SIGINT
        return _complain(_stopped(), 128 + number)
    return 0


def _stopped() -> str:
    """Return what the end of a command by a signal costs."""
    verb = next((argument for argument in sys.argv[1:] if argument in VERBS), "")
    if verb == "run" and "--dry-run" in sys.argv:
        return "the estimate was stopped; nothing is kept of it"
    if verb == "run":
        return "run was stopped; finished cells are kept, run again to resume"
    return f"{verb} was stopped" if verb else "stopped"


def _complain(message: str, code: int = 2) -> int:
    with suppress(OSError):
        click.echo(f"oitbench: {message}", err=True)
    return code


def _end_of_pipe() -> int:
    """Return the exit code of programs whose reader has gone, as in `oitbench list | head -1`."""
    _discard_output()
    return 128 + signal.SIGPIPE


def _accept_all_characters() -> None:
    """Write escapes instead of characters that the encoding of an output lacks."""
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")


def _discard_output() -> None:
    """Discard what is still buffered, which cannot be written when Python exits either."""
    if sys.stdout is None:
        return
    with suppress(OSError):
        sys.stdout.flush()
    nothing = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nothing, sys.stdout.fileno())
    os.close(nothing)


@contextmanager
def _signals_raised() -> Iterator[None]:
    """Raise `_SignalError` on SIGTERM and SIGHUP, so that no worker process is left behind.

    A signal that is ignored, as under `nohup`, stays ignored.
    """
    received: list[int] = []

    def stop(number: int, frame: object) -> None:
        received.append(number)
        # A second signal must not interrupt the end.
        if len(received) == 1:
            raise _SignalError(number)

    changed = [n for n in (signal.SIGTERM, signal.SIGHUP) if signal.getsignal(n) is signal.SIG_DFL]
    for number in changed:
        signal.signal(number, stop)
    try:
        yield
    finally:
        for number in changed:
            signal.signal(number, signal.SIG_DFL)

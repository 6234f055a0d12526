"""`oitbench choose`: the methods that fit a platform, from stored results alone."""

from __future__ import annotations

import json
import re
import sys
from pathlib import Path
from typing import TYPE_CHECKING

import click

from oitbench.errors import UsageError, unknown
from oitbench.method.demands import CLASSES

if TYPE_CHECKING:
    from oitbench.choosing.choice import Choice

_UNITS = {"us": 1e-3, "µs": 1e-3, "ms": 1.0, "s": 1e3}


def parse_time(text: str) -> float:
    """Return milliseconds from text such as `5ms`; raise `UsageError` if it is no time."""
    match = re.fullmatch(r"(\d+\.?\d*|\.\d+) ?(us|µs|ms|s)", text.strip())
    if match is None or not float(match[1]):
        raise UsageError(f"cannot read time '{text}'; write it as 5ms, 500us or 0.1s")
    return float(match[1]) * _UNITS[match[2]]


def _read_time(ctx: click.Context, parameter: click.Parameter, value: str | None) -> float | None:
    return None if value is None else parse_time(value)


def _read_class(ctx: click.Context, parameter: click.Parameter, value: str | None) -> str | None:
    if value is not None and value not in CLASSES:
        raise unknown("class", value, CLASSES)
    return value


_COUNT = click.IntRange(1)


@click.command()
@click.argument("results", nargs=-1, required=True, type=click.Path(path_type=Path))
@click.option(
    "--scene",
    "scenes",
    multiple=True,
    metavar="NAME",
    help="Scene of the results; without parameters and view, all of its name. Repeatable."
    " Default: all.",
)
@click.option(
    "--class",
    "capability_class",
    metavar="CLASS",
    callback=_read_class,
    help="Highest capability class of the platform, which offers those before it, too:"
    f" {'; '.join(f'{key} ({name})' for key, name in CLASSES.items())}.",
)
@click.option("--bits", type=_COUNT, help="Bits of tile memory at a pixel, all samples included.")
@click.option("--passes", type=_COUNT, help="Draws of the same geometry in a frame, at most.")
@click.option("--targets", type=_COUNT, help="Color targets of a pass, at most.")
@click.option("--no-dual-source", is_flag=True, help="There is no dual-source blending.")
@click.option("--no-interlock", is_flag=True, help="No framebuffer fetch and no interlock.")
@click.option("--no-atomics", is_flag=True, help="There are no buffers with atomics.")
@click.option("--msaa", type=_COUNT, help="Samples per pixel that frames have.")
@click.option(
    "--time",
    "milliseconds",
    metavar="TIME",
    callback=_read_time,
    help="Largest method time, such as 5ms.",
)
@click.option(
    "--renderer", default="", metavar="NAME", help="Part of the name of the OpenGL renderer."
)
@click.option("--json", "as_json", is_flag=True, help="Print the answer as JSON.")
def command(
    results: tuple[Path, ...],
    scenes: tuple[str, ...],
    capability_class: str | None,
    bits: int | None,
    passes: int | None,
    targets: int | None,
    no_dual_source: bool,
    no_interlock: bool,
    no_atomics: bool,
    msaa: int | None,
    milliseconds: float | None,
    renderer: str,
    as_json: bool,
) -> None:
    """Choose the methods in RESULTS, folders of runs, that fit a platform.

    Prints what each method that fits loses in each scene, the best by FLIP, and why the others do
    not fit. Nothing is rendered. The exit code is 1 if nothing fits.
    """
    from oitbench.choosing.choice import choose
    from oitbench.choosing.constraints import Constraints
    from oitbench.choosing.facts import facts

    limits = Constraints(
        capability_class, bits, passes, targets, not no_dual_source, not no_interlock,
        not no_atomics, msaa, milliseconds,
    )  # fmt: skip
    choice = choose(results, scenes, limits, renderer)
    if as_json:
        click.echo(json.dumps(facts(choice), indent=2, allow_nan=False, ensure_ascii=False))
    else:
        _print(choice)
    sys.exit(0 if choice.fits else 1)


def _print(choice: Choice) -> None:
    from oitbench.choosing import facts

    click.echo(f"{choice.renderer}: {choice.constraints}")
    if choice.constraints.milliseconds is not None and choice.software:
        click.echo("This renderer runs on the CPU; its times say little about a GPU.")
    rows = list(facts.scene_rows(choice))
    if rows:
        click.echo("\nMethods that fit (*: lowest FLIP, with ties; loss: to the best of all)")
        click.echo(facts.aligned([facts.HEADINGS, *rows]))
    for line in (*facts.legend(rows), *facts.unscored(choice)):
        click.echo(line)
    if choice.means and len(choice.scenes) > 1:
        click.echo("\nMethods that fit in all scenes, by mean FLIP")
        click.echo(facts.aligned([facts.MEAN_HEADINGS, *facts.mean_rows(choice)]))
    misfits = list(facts.misfit_rows(choice))
    if misfits:
        click.echo("\nMethods that do not fit, and why")
        click.echo(facts.aligned(misfits))
    click.echo(f"\n{_verdict(choice)}")


def _verdict(choice: Choice) -> str:
    if choice.chosen:
        return f"best: {', '.join(choice.chosen)}"
    if choice.fits:
        return "best: no method fits, and has an error, in all scenes; name scenes by --scene"
    return "nothing fits; loosen a constraint, or run other methods or parameters"

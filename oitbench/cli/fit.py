"""`oitbench fit`: the parameters of a method with the smallest error in some scenes."""

from __future__ import annotations

from pathlib import Path

import click

from oitbench.cli import options
from oitbench.fitting.fit import STEP_SECONDS


@click.command()
@click.argument("method")
@click.argument("scenes", nargs=-1, required=True)
@options.size("128x128", "Size of each view.")
@click.option(
    "--views",
    type=click.IntRange(2),
    default=6,
    show_default=True,
    help="Views of each scene; every other one is held out.",
)
@click.option(
    "--degrees",
    type=click.FloatRange(0, 360, min_open=True),
    default=10.0,
    show_default=True,
    help="Angle between neighboring views, on a circle about the target of the camera.",
)
@click.option(
    "--evaluations",
    type=click.IntRange(1),
    default=120,
    show_default=True,
    help="Largest number of sets of parameters that are rendered.",
)
@options.timeout(STEP_SECONDS, "Seconds that each step may take: a scene's views, an evaluation.")
@options.memory
@options.collections
def command(
    method: str,
    scenes: tuple[str, ...],
    size: tuple[int, int],
    views: int,
    degrees: float,
    evaluations: int,
    timeout: float | None,
    memory_gib: float | None,
    collections: tuple[Path, ...],
) -> None:
    """Fit the decimal parameters of METHOD to SCENES, against exact compositing.

    Minimizes the mean squared error of the displayed pictures over the views for training. Prints
    the label with the best parameters, and the errors before and after, also on views held out.
    Fits all decimal parameters with two bounds that METHOD does not set.
    """
    from oitbench.fitting.fit import fit

    fitted = fit(
        method, scenes, size, views, degrees, evaluations, collections, timeout, memory_gib
    )
    click.echo(fitted.label)
    click.echo(f"{fitted.evaluations} evaluations; mean squared errors, before and after")
    width = max(len(item.scene) for item in fitted.errors)
    for item in fitted.errors:
        trained, held = (
            "{:.3g} -> {:.3g}".format(*pair) for pair in (item.training, item.held_out)
        )
        click.echo(f"{item.scene:<{width}}  training {trained}  held out {held}")

"""`oitbench baseline`: save the metrics of a run, and compare later runs with them."""

from __future__ import annotations

from pathlib import Path

import click

DEFAULT = Path("baseline.json")


@click.group()
def command() -> None:
    """Save the metrics and counts of a run, and compare later runs with them."""


@command.command()
@click.argument("results", type=click.Path(path_type=Path))
@click.option(
    "-o",
    "--out",
    type=click.Path(dir_okay=False, path_type=Path),
    default=DEFAULT,
    show_default=True,
    help="File of the baseline.",
)
def save(results: Path, out: Path) -> None:
    """Write the baseline of RESULTS: a small file to commit, without times and paths."""
    from oitbench.results.baseline import save as save_baseline

    rows = save_baseline(results, out).rows
    click.echo(f"{out}: {len(rows)} cells")


@command.command()
@click.argument("results", type=click.Path(path_type=Path))
@click.option(
    "--baseline",
    type=click.Path(path_type=Path),
    default=DEFAULT,
    show_default=True,
    help="The baseline file.",
)
@click.option("--json", "as_json", is_flag=True, help="Print the comparison as JSON.")
def check(results: Path, baseline: Path, as_json: bool) -> None:
    """Compare RESULTS with a baseline; exit with 1 on a regression."""
    from oitbench.cli.compare import show
    from oitbench.results.comparison import compare

    show(compare(results, baseline), as_json)

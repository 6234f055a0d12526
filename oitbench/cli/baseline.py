"""`oitbench baseline`: save the metrics of a run, and compare later runs with them."""

from __future__ import annotations

from pathlib import Path

import click

DEFAULT = Path("baseline.json")
_baseline = click.argument("baseline", type=click.Path(path_type=Path), default=DEFAULT)


@click.group()
def command() -> None:
    """Save the metrics and counts of a run, and compare later runs with them."""


@command.command()
@click.argument("results", type=click.Path(path_type=Path))
@_baseline
def save(results: Path, baseline: Path) -> None:
    """Write the baseline of RESULTS: a small file to commit, without times and paths.

    The default of BASELINE is baseline.json.
    """
    from oitbench.results.baseline import save as save_baseline

    rows = save_baseline(results, baseline).rows
    click.echo(f"{baseline}: {len(rows)} cells")


@command.command()
@click.argument("results", type=click.Path(path_type=Path))
@_baseline
@click.option("--json", "as_json", is_flag=True, help="Print the comparison as JSON.")
def check(results: Path, baseline: Path, as_json: bool) -> None:
    """Compare RESULTS with BASELINE, by default baseline.json; exit with 1 on a regression."""
    from oitbench.cli.compare import show
    from oitbench.results.comparison import compare

    show(compare(results, baseline), as_json)

"""`oitbench list`: methods, scenes, effects, settings of shading and reports by name."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

import click

from oitbench.catalog.catalog import Catalog
from oitbench.catalog.messages import Entry, Kind
from oitbench.cli import options
from oitbench.effects import REQUESTED_BY
from oitbench.errors import UsageError, unknown
from oitbench.parameters import AnyParameter, text
from oitbench.shading import PARAMETERS
from oitbench.stability.check import METHOD_SECONDS
from oitbench.workers import memory

KINDS = ("methods", "scenes", "effects", "shading", "reports")
_SINGULAR: dict[str, Kind] = {"methods": "method", "scenes": "scene", "reports": "report"}


def _read_kind(ctx: click.Context, parameter: click.Parameter, value: str | None) -> str | None:
    """Accept singular and plural."""
    if value is None or value in KINDS:
        return value
    if f"{value}s" in KINDS:
        return f"{value}s"
    raise unknown("kind", value, KINDS)


@click.command()
@click.argument("kind", callback=_read_kind, required=False)
@click.option("--json", "as_json", is_flag=True, help="Print the list as JSON.")
@click.option(
    "--measure",
    is_flag=True,
    help="Render stacks of layers with all methods; print their table. A method that crashes, or"
    f" takes longer than {METHOD_SECONDS:g} s, is left out; the exit code is then 1.",
)
@options.collections
def command(kind: str | None, as_json: bool, measure: bool, collections: tuple[Path, ...]) -> None:
    """List methods, scenes, effects, settings of shading or reports, with their parameters.

    The default is all of them. `oitbench list methods --measure` prints the table of methods of the
    README.
    """
    if measure:
        _print_overview(collections, kind)
        return
    with Catalog(collections) as catalog:
        found = {name: _entries(catalog, name) for name in ([kind] if kind else KINDS)}
    if as_json:
        click.echo(json.dumps(found[kind] if kind else found, indent=2))
        return
    for name, entries in found.items():
        if len(found) > 1:
            click.secho(name, bold=True)
        width = max((len(entry["name"]) for entry in entries), default=0)
        for entry in entries:
            click.echo(f"  {entry['name']:{width}}  {entry['title']}")
            for key, parameter in entry.get("parameters", {}).items():
                click.echo(f"  {'':{width}}    {key}={parameter['summary']}")
            if entry.get("views"):
                click.echo(f"  {'':{width}}    views: {', '.join(entry['views'])}")


def _print_overview(collections: tuple[Path, ...], kind: str | None) -> None:
    from oitbench.stability import overview
    from oitbench.stability.laboratory import Laboratory

    if kind != "methods":
        raise UsageError("--measure needs methods: oitbench list methods --measure")
    with Catalog(collections) as catalog:
        methods = catalog.expand_methods(catalog.names("method"))
        laboratory = Laboratory(catalog, methods, memory.share(1))
    with laboratory:
        rows = [row for method in methods for row in laboratory.overview(method.label)]
    click.echo(overview.table(rows), nl=False)
    for label, reason in laboratory.lost.items():
        click.echo(f"failed {label}: {reason}", err=True)
    sys.exit(1 if laboratory.lost else 0)


def _entries(catalog: Catalog, kind: str) -> list[dict[str, Any]]:
    if kind == "effects":
        return [
            {"name": str(effect.name).lower(), "title": f"requested by {reason}"}
            for effect, reason in REQUESTED_BY.items()
        ]
    if kind == "shading":
        return [
            {"name": name, "title": found["summary"], **found}
            for name, parameter in PARAMETERS.items()
            for found in [_parameter(parameter)]
        ]
    single = _SINGULAR[kind]
    return [
        _facts(single, catalog.entry(single, name)) | _views(catalog, single, name)
        for name in catalog.names(single)
    ]


def _views(catalog: Catalog, kind: Kind, name: str) -> dict[str, Any]:
    """Return the names of the views of a scene, which is built for that."""
    return {"views": catalog.entry(kind, name, check=True).views} if kind == "scene" else {}


def _facts(kind: Kind, entry: Entry) -> dict[str, Any]:
    if entry.error:
        return {"name": entry.name, "title": f"cannot be loaded: {entry.error}"}
    facts: dict[str, Any] = {"name": entry.name, "title": entry.title}
    if kind == "method":
        facts |= {"expresses": entry.expresses, "promises": entry.promises}
    if kind != "report":
        facts["quick"] = entry.quick
    parameters = {key: _parameter(value) for key, value in entry.parameters.items()}
    return facts | {"parameters": parameters}


def _parameter(parameter: AnyParameter) -> dict[str, Any]:
    allowed = "|".join(text(choice) for choice in parameter.choices)
    summary = text(parameter.default)
    if allowed:
        summary += f"  ({allowed})"
    if parameter.help:
        summary += f"  {parameter.help}"
    return {"default": parameter.default, "choices": list(parameter.choices), "summary": summary}

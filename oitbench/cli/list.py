"""`oitbench list`: methods, scenes, effects and reports by name."""

from __future__ import annotations

import ast
import json
from pathlib import Path
from typing import Any

import click

from oitbench.cli import options
from oitbench.effects import REQUESTED_BY
from oitbench.errors import DeclarationError, UsageError, unknown
from oitbench.parameters import AnyParameter, text
from oitbench.plugins import Collection

KINDS = ("methods", "scenes", "effects", "reports")


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
    "--measure", is_flag=True, help="Render stacks of layers with all methods; print their table."
)
@options.collections
def command(kind: str | None, as_json: bool, measure: bool, collections: tuple[Path, ...]) -> None:
    """List methods, scenes, effects or reports, with their parameters. Default: all of them.

    `oitbench list methods --measure` prints the table of methods of the README.
    """
    collection = Collection.load(collections)
    if measure:
        _print_overview(collection, kind)
        return
    found = {name: _entries(collection, name) for name in ([kind] if kind else KINDS)}
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


def _print_overview(collection: Collection, kind: str | None) -> None:
    from oitbench.gl.device import Device
    from oitbench.stability import overview

    if kind != "methods":
        raise UsageError("--measure needs methods: oitbench list methods --measure")
    with Device() as device:
        rows = overview.measure(device, collection.expand_methods(list(collection.methods)))
    click.echo(overview.table(rows), nl=False)


def _entries(collection: Collection, kind: str) -> list[dict[str, Any]]:
    if kind == "effects":
        return [
            {"name": str(effect.name).lower(), "title": f"requested by {reason}"}
            for effect, reason in REQUESTED_BY.items()
        ]
    if kind == "reports":
        return [_report(name, collection.reports.path(name)) for name in collection.reports]
    plugins = getattr(collection, kind)
    return [_entry(plugins, name) for name in plugins]


def _entry(plugins: Any, name: str) -> dict[str, Any]:
    try:
        plugin = plugins[name]
    except DeclarationError as error:
        return _broken(name, error)
    return {
        "name": name,
        "title": _title(plugin.doc if hasattr(plugin, "doc") else plugin.__doc__),
        "parameters": {key: _parameter(value) for key, value in plugin.parameters.items()},
    }


def _report(name: str, path: Path) -> dict[str, Any]:
    """Return the entry of a report; the file is only parsed, since importing reports is slow."""
    try:
        doc = ast.get_docstring(ast.parse(path.read_bytes()))
    except (SyntaxError, ValueError) as error:
        return _broken(name, error)
    return {"name": name, "title": _title(doc), "parameters": {}}


def _broken(name: str, error: Exception) -> dict[str, Any]:
    return {"name": name, "title": f"cannot be loaded: {error}"}


def _title(doc: str | None) -> str:
    return (doc or "").strip().partition("\n")[0]


def _parameter(parameter: AnyParameter) -> dict[str, Any]:
    allowed = "|".join(text(choice) for choice in parameter.choices)
    summary = text(parameter.default)
    if allowed:
        summary += f"  ({allowed})"
    if parameter.help:
        summary += f"  {parameter.help}"
    return {"default": parameter.default, "choices": list(parameter.choices), "summary": summary}

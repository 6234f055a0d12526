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
from oitbench.errors import OitbenchError, UsageError
from oitbench.measure.survey import SCENE_SECONDS
from oitbench.method.demands import Demands
from oitbench.parameters import AnyParameter, text
from oitbench.shading import PARAMETERS
from oitbench.stability.check import METHOD_SECONDS
from oitbench.workers import memory

KINDS = ("methods", "scenes", "effects", "shading", "reports")
_SINGULAR: dict[str, Kind] = {"methods": "method", "scenes": "scene", "reports": "report"}


@click.command()
@options.kind(KINDS, required=False)
@click.option("--json", "as_json", is_flag=True, help="Print the list as JSON.")
@click.option(
    "--measure",
    is_flag=True,
    help="Render stacks of layers with all methods; print their table. A method that crashes, or"
    f" takes longer than {METHOD_SECONDS:g} s, is left out; the exit code is then 1.",
)
@click.option(
    "--class",
    "classes",
    is_flag=True,
    help="Print the table of what methods demand of a platform, which follows from what they"
    " declare, with all effects that they show. A method that cannot be loaded is left out; the"
    " exit code is then 1.",
)
@click.option(
    "--method",
    "methods",
    multiple=True,
    help="NAME[param=v,w], for --class. Repeatable. Default: all, with their defaults.",
)
@click.option(
    "--stats",
    is_flag=True,
    help="Count triangles, draws, fragments and depth complexity of all views of scenes; print"
    " their table. A scene that fails is left out; the exit code is then 1.",
)
@click.option(
    "--scene",
    "scenes",
    multiple=True,
    help="NAME[param=v,w], for --stats. Repeatable. Default: all, with their defaults.",
)
@options.size("1280x720", "Size of the frames that --stats counts, in pixels.")
@options.timeout(SCENE_SECONDS, "Seconds that a scene, or one of its views, may take with --stats.")
@options.memory
@options.collections
def command(
    kind: str | None,
    as_json: bool,
    measure: bool,
    classes: bool,
    methods: tuple[str, ...],
    stats: bool,
    scenes: tuple[str, ...],
    size: tuple[int, int],
    timeout: float | None,
    memory_gib: float | None,
    collections: tuple[Path, ...],
) -> None:
    """List methods, scenes, effects, settings of shading or reports, with their parameters.

    The default is all of them. `oitbench list methods --measure` and `--class` print the tables of
    methods of the README, and `oitbench list scenes --stats` what scenes ask of a renderer.
    """
    if measure:
        _print_overview(collections, kind)
        return
    if classes or methods:
        if kind != "methods" or not classes:
            raise UsageError("--class needs methods: oitbench list methods --class")
        _print_classes(methods, as_json, collections)
        return
    if stats or scenes:
        if kind != "scenes" or not stats:
            raise UsageError("--stats needs scenes: oitbench list scenes --stats")
        _print_statistics(scenes, size, as_json, timeout, memory_gib, collections)
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
            if entry.get("no_msaa"):
                click.echo(f"  {'':{width}}    one sample per pixel: {entry['no_msaa']}")
            if entry.get("views"):
                click.echo(f"  {'':{width}}    views: {', '.join(entry['views'])}")


def _print_classes(texts: tuple[str, ...], as_json: bool, collections: tuple[Path, ...]) -> None:
    from oitbench.method.demand_table import facts, table

    found: dict[str, Demands] = {}
    lost: dict[str, OitbenchError] = {}
    with Catalog(collections) as catalog:
        for choice in catalog.expand_methods(texts or catalog.names("method")):
            try:
                found[choice.label] = catalog.demands(choice)
            except OitbenchError as error:
                lost[choice.label] = error
    if as_json:
        click.echo(json.dumps([facts(*row) for row in found.items()], indent=2))
    else:
        click.echo(table(found), nl=False)
    for label, reason in lost.items():
        click.echo(f"failed {label}: {reason}", err=True)
    sys.exit(1 if lost else 0)


def _print_statistics(
    texts: tuple[str, ...],
    size: tuple[int, int],
    as_json: bool,
    timeout: float | None,
    memory_gib: float | None,
    collections: tuple[Path, ...],
) -> None:
    from oitbench.measure import survey

    limit = memory.limit(memory_gib, 1)
    with Catalog(collections) as catalog:
        chosen = catalog.expand_scenes(texts or catalog.names("scene"))
        rows = list(survey.survey(catalog, chosen, size, limit, timeout))
    if as_json:
        click.echo(json.dumps([survey.facts(row, size) for row in rows], indent=2))
    else:
        click.echo(survey.table(rows, size), nl=False)
    for row in rows:
        if row.error:
            click.echo(f"failed {row.scene}: {row.error}", err=True)
    sys.exit(1 if any(row.error for row in rows) else 0)


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
    return [_facts(single, _entry(catalog, single, name)) for name in catalog.names(single)]


def _entry(catalog: Catalog, kind: Kind, name: str) -> Entry:
    """Return an entry; that of a scene has the names of its views if it can be built."""
    if kind != "scene":
        return catalog.entry(kind, name)
    checked = catalog.entry(kind, name, check=True)
    return catalog.entry(kind, name) if checked.error else checked


def _facts(kind: Kind, entry: Entry) -> dict[str, Any]:
    if entry.error:
        return {"name": entry.name, "title": f"cannot be loaded: {entry.error}"}
    facts: dict[str, Any] = {"name": entry.name, "title": entry.title}
    if kind == "method":
        facts |= {"expresses": entry.expresses, "promises": entry.promises}
        facts["no_msaa"] = entry.no_msaa
    if kind == "scene":
        facts["views"] = entry.views
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

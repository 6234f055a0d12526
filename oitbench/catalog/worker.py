"""The far end of a catalog: loads the files of plugins and describes them."""

from __future__ import annotations

import ast
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any

from oitbench import parameters as selectors
from oitbench.catalog.messages import (
    AxesFound,
    Demand,
    DemandsFound,
    Describe,
    Entry,
    Inspect,
    Inspected,
    Nothing,
    Portrait,
    Portray,
    Reply,
    Request,
    Resolve,
    Resolved,
)
from oitbench.catalog.outline import outline
from oitbench.effects import names
from oitbench.errors import DeclarationError, OitbenchError, locate
from oitbench.fingerprints.code import method_fingerprint
from oitbench.method.ablation import effects_axis
from oitbench.method.declaration import Method
from oitbench.method.demands import default_demands
from oitbench.places import Places
from oitbench.plugins import Collection, installed_folder
from oitbench.workers.serve import OnStep, serve

_COARSE = 0.02
"""Detail of a scene that is built for the names of its views alone."""


def _begin(settings: Nothing, on_step: OnStep) -> Callable[[Request], Reply]:
    collection = Collection(Places())

    def answer(request: Request) -> Reply:
        if isinstance(request, Resolve):
            return Resolved(installed_folder(request.value))
        if isinstance(request, Describe):
            return _describe(collection, request)
        if isinstance(request, Inspect):
            return _inspect(collection, request)
        if isinstance(request, Demand):
            return _demands(collection, request)
        if isinstance(request, Portray):
            return _portrait(collection, request)
        for name, path in request.method_paths.items():
            collection.places.methods.add(name, path)
        collection.places.scenes.add(request.scene.partition("[")[0], request.scene_path)
        effects = collection.build_scene(request.scene).effects
        methods = collection.expand_methods(request.methods)
        return AxesFound([list(effects_axis(effects, method)) for method in methods])

    return answer


def _describe(collection: Collection, request: Describe) -> Entry:
    path = request.path
    try:
        if request.kind == "method":
            return _method(collection, request.name, path)
        if request.kind == "scene":
            return _scene(collection, request.name, path, request.check)
        return _report(collection, request.name, path, request.check)
    except DeclarationError as error:
        return Entry(request.name, error=str(error))


def _inspect(collection: Collection, request: Inspect) -> Inspected:
    from oitbench.importing.scene import read_scene

    path = request.path
    collection.places.scenes.add(request.scene.partition("[")[0], path)
    values: dict[str, Any] = collection.scene_values(request.scene)
    imported = read_scene(path, **values)
    return Inspected(list(imported.notes), dict(imported.files))


def _demands(collection: Collection, request: Demand) -> DemandsFound:
    return DemandsFound(default_demands(_selected(collection, request)))


def _portrait(collection: Collection, request: Portray) -> Portrait:
    method = _selected(collection, request)
    parameters = {key: _parameter(method, key) for key in method.parameters}
    return Portrait(
        method.label,
        method.__doc__ or "",
        method.family,
        parameters,
        sorted(method.promised),
        [effect.lower() for effect in names(method.expresses)],
        default_demands(method),
        outline(method),
        method_fingerprint(method),
    )


def _parameter(method: Method, key: str) -> tuple[str, str, str]:
    """Return the value of a parameter, its choices, and its meaning."""
    parameter = method.parameters[key]
    choices = ", ".join(map(selectors.text, parameter.choices))
    return selectors.text(method.values[key]), choices, parameter.help


def _selected(collection: Collection, request: Demand | Portray) -> Method:
    collection.places.methods.add(request.label.partition("[")[0], request.path)
    (method,) = collection.expand_methods([request.label])
    return method


def _method(collection: Collection, name: str, path: Path) -> Entry:
    collection.places.methods.add(name, path)
    method = collection.methods[name]
    default = method()
    return Entry(
        name,
        _title(method.__doc__),
        dict(method.parameters),
        bool(default.quick),
        sorted(default.promises),
        [effect.lower() for effect in names(default.expresses)],
        default.no_msaa,
    )


def _scene(collection: Collection, name: str, path: Path, check: bool) -> Entry:
    collection.places.scenes.add(name, path)
    scene = collection.scenes[name]
    views: list[str] = []
    if check:
        with suppress(OitbenchError):
            coarse = f"[detail={_COARSE:g}]" if "detail" in scene.parameters else ""
            views = list(collection.build_scene(f"{name}{coarse}").view_names)
    title = _title(scene.doc)
    return Entry(
        name, title, dict(scene.parameters), bool(scene.quick), views=views, crops=dict(scene.crops)
    )


def _report(collection: Collection, name: str, path: Path, check: bool) -> Entry:
    """Return the entry of a report; by default its file is only parsed, which is fast."""
    if check:
        collection.places.reports.add(name, path)
        module = collection.reports[name]
        return Entry(name, _title(module.__doc__), needs=list(getattr(module, "needs", ())))
    try:
        return Entry(name, _title(ast.get_docstring(ast.parse(path.read_bytes()))))
    except (SyntaxError, ValueError, OSError) as error:
        raise DeclarationError(locate(error, path)) from error


def _title(doc: str | None) -> str:
    return (doc or "").strip().partition("\n")[0]


def main() -> None:
    """Serve the catalog that started this process."""
    serve(Nothing, Request, _begin)

"""Loads methods, scenes and reports from their files into this process."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import partial
from importlib.metadata import EntryPoint, entry_points
from pathlib import Path
from types import ModuleType
from typing import Any, TypeVar

from oitbench import crops as declared_crops
from oitbench import parameters as selectors
from oitbench.crops import Crop
from oitbench.effects import Effect
from oitbench.errors import (
    CapabilityError,
    DeclarationError,
    SceneError,
    UsageError,
    locate,
    printable,
)
from oitbench.loading import load_module
from oitbench.method.declaration import Method
from oitbench.method.views import View
from oitbench.parameters import AnyParameter, Parameter, Value
from oitbench.places import GROUP, IMPORTED, WRITTEN, Names, Places, own_folder
from oitbench.scene import Scene

Plugin = TypeVar("Plugin")
NEAREST, FARTHEST = 1e-3, 1e3
"""Bounds of the near plane of a scene, meters."""


@dataclass(frozen=True)
class ScenePlugin:
    """A scene's file.

    Parameters
    ----------
    name, doc : str
    parameters : mapping of str to Parameter
    build : callable
        From a name and the values of all parameters to a `Scene`.
    quick : bool
        Whether the quick preset includes the scene.
    subject : str
        The thing that it shows, such as "smoke"; "" if its file does not say.
    crops : mapping of str to Crop
        Parts of its picture by name.
    """

    name: str
    doc: str
    parameters: Mapping[str, AnyParameter]
    build: Callable[..., Scene]
    quick: bool = True
    subject: str = ""
    crops: Mapping[str, Crop] = field(default_factory=dict)


class Plugins(Mapping[str, Plugin]):
    """Plugins of one kind by name. A file is loaded when it is first used.

    So a broken file only affects those who use it, and listing names costs nothing. Looking up a
    name raises `UsageError` with near names, or `DeclarationError` if its file fails.
    """

    def __init__(self, paths: Names, load: Callable[[Path], Plugin]) -> None:
        self._paths, self._load = paths, load
        self._loaded: dict[str, Plugin] = {}

    def path(self, name: str) -> Path:
        """Return the file of the plugin `name`."""
        return self._paths[name]

    def __getitem__(self, name: str) -> Plugin:
        path = self.path(name)
        if name not in self._loaded:
            self._loaded[name] = self._load(path)
        return self._loaded[name]

    def __contains__(self, name: object) -> bool:
        return name in self._paths

    def __iter__(self) -> Iterator[str]:
        return iter(self._paths)

    def __len__(self) -> int:
        return len(self._paths)


class Collection:
    """All plugins that can be used by name, loaded into this process when they are used.

    Parameters
    ----------
    places : Places
        Where their files are.

    Attributes
    ----------
    methods : Plugins of type of Method
    scenes : Plugins of ScenePlugin
    reports : Plugins of module
    folders : list of Path
        Collection folders; each may have `methods`, `scenes`, `reference`, `reports` and `glsl`.
    """

    def __init__(self, places: Places) -> None:
        self.places, self.folders = places, places.folders
        self.methods: Plugins[type[Method]] = Plugins(places.methods, _load_method)
        self.scenes: Plugins[ScenePlugin] = Plugins(places.scenes, _load_scene)
        self.reports: Plugins[ModuleType] = Plugins(places.reports, _load_report)

    @classmethod
    def load(cls, extra: Iterable[Path] = ()) -> Collection:
        """Find the suite's own collection, installed ones, and the folders `extra`, in this order.

        Raises
        ------
        UsageError
            A folder does not exist or is no collection, or two plugins have one name.
        DeclarationError
            An installed collection cannot be imported.
        """
        installed = map(installed_folder, installed_collections())
        return cls(Places((own_folder(), *installed, *map(Path, extra))))

    def expand_methods(self, texts: Iterable[str]) -> list[Method]:
        """Return all methods that the selectors `NAME[param=v,w]` or `FOLDER[param=v]` select."""
        chosen: dict[str, Method] = {}
        for text in texts:
            parsed = selectors.parse(text)
            name = self.places.find_method(parsed.name)
            method = self.methods[name]
            for values in selectors.expand(
                selectors.Selector(name, parsed.grid), method.parameters
            ):
                item = method(**values)
                chosen[item.label] = item
        return list(chosen.values())

    def expand_scenes(self, texts: Iterable[str]) -> list[str]:
        """Return the canonical labels of all scenes that `NAME[param=v,w]` or `FILE[…]` select."""
        chosen: dict[str, None] = {}
        for text in texts:
            parsed = self._parse_scene(text)
            plugin = self.scenes[parsed.name]
            for values in selectors.expand(parsed, plugin.parameters):
                chosen[selectors.label(parsed.name, values, plugin.parameters)] = None
        return list(chosen)

    def _parse_scene(self, text: str) -> selectors.Selector:
        parsed = selectors.parse(text)
        return selectors.Selector(self.places.find_scene(parsed.name), parsed.grid)

    def build_scene(self, text: str) -> Scene:
        """Build the one scene that `text` selects.

        Raises
        ------
        SceneError
            The scene's own code fails, or describes something that cannot be rendered.
        UsageError
            The name or a parameter is unknown, or `text` selects several scenes.
        """
        name, values = self._assigned(text)
        plugin, path = self.scenes[name], self.scenes.path(name)
        label = selectors.label(name, values, plugin.parameters)
        try:
            scene = plugin.build(name=label, **values)
        except (CapabilityError, UsageError):
            raise
        except (Exception, SystemExit) as error:
            message = locate(error, path)
            owner = f"scene {label}: "
            raise SceneError(message if owner in message else f"{owner}{message}") from error
        if not isinstance(scene, Scene):
            raise SceneError(f"scene {label}: {path}: build returns {scene!r}; return a Scene")
        return scene

    def scene_values(self, text: str) -> dict[str, Value]:
        """Return the values of all parameters of the one scene that `text` selects."""
        return self._assigned(text)[1]

    def _assigned(self, text: str) -> tuple[str, dict[str, Value]]:
        parsed = self._parse_scene(text)
        found = list(selectors.expand(parsed, self.scenes[parsed.name].parameters))
        if len(found) != 1:
            raise UsageError(f"'{text}' selects {len(found)} scenes; name one")
        return parsed.name, found[0]

    def truth(self) -> Method:
        """Return the suite's own method that renders the exact truth, with its parameters."""
        own = own_folder() / "methods"
        for name in self.methods:
            if self.methods.path(name).parent.parent != own:
                continue
            try:
                method = self.methods[name]
            except DeclarationError:
                continue  # the error is raised for those who use that method
            if method.truth is not None:
                return method(**method.truth)
        raise UsageError("the suite has no method that serves as the exact truth; reinstall it")


def installed_collections() -> list[str]:
    """Return the objects `MODULE:NAME` that installed packages register as collections."""
    return [entry.value for entry in entry_points(group=GROUP)]


def installed_folder(value: str) -> Path:
    """Return the folder of an installed collection; its package is imported.

    Raises
    ------
    DeclarationError
        The package cannot be imported.
    """
    try:
        found: Any = EntryPoint(value, value, GROUP).load()
    except (Exception, SystemExit) as error:
        raise DeclarationError(locate(error)) from error
    return Path(str(found.__path__[0] if isinstance(found, ModuleType) else found))


def _load_method(path: Path) -> type[Method]:
    module = load_module(path)
    found = [
        value
        for value in vars(module).values()
        if isinstance(value, type)
        and issubclass(value, Method)
        and value.__module__ == module.__name__
    ]
    if len(found) != 1:
        raise DeclarationError(f"{path}: defines {len(found)} methods; define exactly one")
    method, folder = found[0], path.parent
    if method.truth is not None and folder.parent != own_folder() / "methods":
        raise DeclarationError(
            f"{path}: only the suite's own method can be the truth; drop 'truth'"
        )
    method.name = _checked_name(path, folder.name)
    _check_class(path, method)
    method.__doc__ = module.__doc__
    shared = folder.parent.parent / "glsl"
    of_collection = folder.parent.name == "methods" and shared.is_dir()
    method.folders = (folder, shared) if of_collection else (folder,)
    return method


def _check_class(path: Path, method: type[Method]) -> None:
    """Raise `DeclarationError` if promises, effects or views of a method have a wrong type."""
    try:
        default = method()
        promises, effects, views = default.promises, default.expresses, default.views
    except Exception as error:
        raise DeclarationError(locate(error, path)) from error
    if not isinstance(promises, frozenset):
        raise DeclarationError(f'{path}: promises is {promises!r}; write oit.promise("NAME NAME")')
    if not isinstance(effects, Effect):
        raise DeclarationError(f"{path}: expresses is {effects!r}; combine oit.Effect by |")
    if not isinstance(views, Mapping) or not all(isinstance(v, View) for v in views.values()):
        raise DeclarationError(f"{path}: views is {views!r}; map names to oit.View")


def _load_scene(path: Path) -> ScenePlugin:
    if path.suffix.lower() == WRITTEN:
        from oitbench.importing.written import read_written

        name = _checked_name(path, path.stem)
        return ScenePlugin(name, f"Built in Python: {path.name}.", {}, partial(read_written, path))
    if path.suffix.lower() in IMPORTED:
        from oitbench.importing.scene import PARAMETERS, read_scene

        def build(**values: Any) -> Scene:
            return read_scene(path, **values).scene

        name = _checked_name(path, path.stem)
        return ScenePlugin(name, f"Imported from {path.name}.", PARAMETERS, build)
    module = load_module(path)
    _require(module, path, "scene", "parameters", "build")
    parameters = module.parameters
    if not isinstance(parameters, Mapping) or not all(
        isinstance(key, str) and isinstance(item, Parameter) for key, item in parameters.items()
    ):
        raise DeclarationError(f"{path}: parameters is {parameters!r}; map names to oit.Parameter")
    build = module.build
    if hasattr(module, "near"):
        parameters = {**parameters, "near": _near_plane(path, module.near)}
        build = partial(_build_seen_from, build)
    try:
        crops = declared_crops.check(getattr(module, "crops", {}))
    except ValueError as error:
        raise DeclarationError(f"{path}: {error}") from error
    return ScenePlugin(
        _checked_name(path, path.stem), module.__doc__ or "", parameters, build,
        getattr(module, "quick", True), _subject(path, getattr(module, "subject", "")), crops,
    )  # fmt: skip


def _subject(path: Path, subject: object) -> str:
    """Return the subject of a scene, checked."""
    if not isinstance(subject, str) or len(subject.splitlines()) > 1:
        raise DeclarationError(f"{path}: subject is {subject!r}; give a few words, as 'smoke'")
    return subject


def _near_plane(path: Path, near: object) -> Parameter[float]:
    """Return the parameter `near` of a scene that states its near plane."""
    if not isinstance(near, float) or not NEAREST <= near <= FARTHEST:
        raise DeclarationError(
            f"{path}: near is {near!r}; give a float from {NEAREST:g} to {FARTHEST:g} (meters)"
        )
    return Parameter(
        near, low=NEAREST, high=FARTHEST, help="distance of the near plane from the camera, m"
    )


def _build_seen_from(build: Callable[..., Scene], *, near: float, **values: Any) -> Scene:
    """Return what `build` returns, with the camera's near plane `near` meters away."""
    scene = build(**values)
    if not isinstance(scene, Scene):
        return scene
    camera = replace(scene.camera, near=near / scene.meters_per_unit)
    return replace(scene, camera=camera)


def _load_report(path: Path) -> ModuleType:
    module = load_module(path)
    _require(module, path, "report", "title", "build")
    return module


def _checked_name(path: Path, name: str) -> str:
    """Return the name of a plugin; raise `DeclarationError` if no record could hold it."""
    if printable(name) != name:
        raise DeclarationError(
            f"{path}: the name is not printable UTF-8; rename the file or folder"
        )
    return name


def _require(module: ModuleType, path: Path, kind: str, *members: str) -> None:
    """Raise `DeclarationError` unless a plugin defines all of these members."""
    for member in members:
        if not hasattr(module, member):
            raise DeclarationError(f"{path}: defines no '{member}'; every {kind} needs one")

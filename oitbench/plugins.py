"""Finds methods, scenes and reports by path, wherever the package is installed."""

from __future__ import annotations

import importlib.util
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from importlib.metadata import entry_points
from pathlib import Path
from types import ModuleType
from typing import Any, TypeVar

from oitbench import parameters as selectors
from oitbench.effects import Effect
from oitbench.errors import (
    CapabilityError,
    DeclarationError,
    SceneError,
    UsageError,
    locate,
    unknown,
)
from oitbench.method.declaration import Method
from oitbench.parameters import AnyParameter, Value
from oitbench.scene import Scene

Plugin = TypeVar("Plugin")
KINDS = ("methods", "scenes", "reference", "reports")


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
    """

    name: str
    doc: str
    parameters: Mapping[str, AnyParameter]
    build: Callable[..., Scene]
    quick: bool = True


class Plugins(Mapping[str, Plugin]):
    """Plugins of one kind by name. A file is loaded when it is first used.

    So a broken file only affects those who use it, and listing names costs nothing. Looking up a
    name raises `UsageError` with near names, or `DeclarationError` if its file fails.
    """

    def __init__(self, kind: str, load: Callable[[Path], Plugin]) -> None:
        self.kind, self._load = kind, load
        self._paths: dict[str, Path] = {}
        self._loaded: dict[str, Plugin] = {}

    def add(self, name: str, path: Path) -> None:
        """Add the plugin of `path`.

        Raises
        ------
        UsageError
            Another file already has that name.
        """
        known = self._paths.setdefault(name, path)
        if known != path:
            raise UsageError(f"two {self.kind}s are named '{name}': {known} and {path}; rename one")

    def path(self, name: str) -> Path:
        """Return the file of the plugin `name`."""
        if name not in self._paths:
            raise unknown(self.kind, name, self._paths)
        return self._paths[name]

    def __getitem__(self, name: str) -> Plugin:
        path = self.path(name)
        if name not in self._loaded:
            self._loaded[name] = self._load(path)
        return self._loaded[name]

    def __contains__(self, name: object) -> bool:
        return name in self._paths

    def __iter__(self) -> Iterator[str]:
        return iter(sorted(self._paths))

    def __len__(self) -> int:
        return len(self._paths)


class Collection:
    """All plugins that can be used by name.

    Attributes
    ----------
    methods : Plugins of type of Method
    scenes : Plugins of ScenePlugin
    reports : Plugins of module
    folders : list of Path
        Collection folders; each may have `methods`, `scenes`, `reference`, `reports` and `glsl`.
    """

    def __init__(self) -> None:
        self.methods: Plugins[type[Method]] = Plugins("method", _load_method)
        self.scenes: Plugins[ScenePlugin] = Plugins("scene", _load_scene)
        self.reports: Plugins[ModuleType] = Plugins("report", _load)
        self.folders: list[Path] = []

    @classmethod
    def load(cls, extra: Iterable[Path] = ()) -> Collection:
        """Find the suite's own collection, installed ones, and the folders `extra`, in this order.

        Raises
        ------
        UsageError
            A folder does not exist or is no collection, or two plugins have one name.
        """
        collection = cls()
        for folder in (own_folder(), *_installed(), *map(Path, extra)):
            collection.add(folder)
        return collection

    def add(self, folder: Path) -> None:
        """Add the plugins of one collection folder."""
        folder = folder.resolve()
        if not any((folder / kind).is_dir() for kind in KINDS):
            raise UsageError(f"{folder} is no collection; it has none of {', '.join(KINDS)}")
        if folder in self.folders:
            return
        self.folders.append(folder)
        for path in _children(folder / "methods", "*/method.py"):
            self.methods.add(path.parent.name, path)
        for path in _children(folder / "scenes", "*.py"):
            self.scenes.add(path.stem, path)
        for path in _children(folder / "reports", "*.py"):
            self.reports.add(path.stem, path)

    def add_method(self, folder: Path) -> type[Method]:
        """Add the method of one folder, which holds `method.py` and its shaders."""
        path = folder.resolve() / "method.py"
        if not path.is_file():
            raise UsageError(f"{folder} is no method; it has no method.py")
        self.methods.add(path.parent.name, path)
        return self.methods[path.parent.name]

    def expand_methods(self, texts: Iterable[str]) -> list[Method]:
        """Return all methods that the selectors `NAME[param=v,w]` or `FOLDER[param=v]` select.

        A known name takes precedence over a folder of that name in the working directory.
        """
        chosen: dict[str, Method] = {}
        for text in texts:
            parsed = selectors.parse(text)
            folder = Path(parsed.name)
            here = parsed.name not in self.methods and (folder / "method.py").is_file()
            if "/" in parsed.name or here:
                method = self.add_method(folder)
            else:
                method = self.methods[parsed.name]
            parsed = selectors.Selector(method.name, parsed.grid)
            for values in selectors.expand(parsed, method.parameters):
                item = method(**values)
                chosen[item.label] = item
        return list(chosen.values())

    def expand_scenes(self, texts: Iterable[str]) -> list[str]:
        """Return the canonical labels of all scenes that the selectors `NAME[param=v,w]` select."""
        chosen: dict[str, None] = {}
        for text in texts:
            parsed = selectors.parse(text)
            plugin = self.scenes[parsed.name]
            for values in selectors.expand(parsed, plugin.parameters):
                chosen[selectors.label(parsed.name, values, plugin.parameters)] = None
        return list(chosen)

    def build_scene(self, text: str) -> Scene:
        """Build the one scene that `text` selects.

        Raises
        ------
        SceneError
            The scene's own code fails, or describes something that cannot be rendered.
        UsageError
            The name or a parameter is unknown, or `text` selects several scenes.
        """
        parsed = selectors.parse(text)
        plugin = self.scenes[parsed.name]
        assignments = list(selectors.expand(parsed, plugin.parameters))
        if len(assignments) != 1:
            raise UsageError(f"'{text}' selects {len(assignments)} scenes; name one")
        values: dict[str, Value] = assignments[0]
        label = selectors.label(parsed.name, values, plugin.parameters)
        path = self.scenes.path(parsed.name)
        try:
            scene = plugin.build(name=label, **values)
        except (CapabilityError, UsageError):
            raise
        except Exception as error:
            message = locate(error, path)
            owner = f"scene {label}: "
            raise SceneError(message if owner in message else f"{owner}{message}") from error
        if not isinstance(scene, Scene):
            raise SceneError(f"scene {label}: {path}: build returns {scene!r}; return a Scene")
        return scene

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


def own_folder() -> Path:
    """Return the suite's own collection: inside an installed package, else the checkout."""
    package = Path(__file__).resolve().parent
    inside = package / "collection"
    return inside if inside.is_dir() else package.parent


def _installed() -> Iterator[Path]:
    """Yield the folders that installed packages register as `oitbench.collections`."""
    for entry in entry_points(group="oitbench.collections"):
        value: Any = entry.load()
        if isinstance(value, ModuleType):
            yield Path(str(value.__path__[0]))
        else:
            yield Path(str(value))


def _children(folder: Path, pattern: str) -> list[Path]:
    return [
        path
        for path in sorted(folder.glob(pattern))
        if not path.name.startswith("_") and not path.parent.name.startswith("_")
    ]


def _load(path: Path) -> ModuleType:
    """Load a plugin's file under a private name that no other module has."""
    # Signs become their code points, so that `my-method` and `my_method` stay two modules.
    name = "oitbench_plugin_" + "_".join(
        "".join(c if c.isalnum() else f"_{ord(c):x}_" for c in part)
        for part in path.with_suffix("").parts[1:]
    )
    specification = importlib.util.spec_from_file_location(name, path)
    assert specification is not None
    assert specification.loader is not None
    module = importlib.util.module_from_spec(specification)
    sys.modules[name] = module
    try:
        specification.loader.exec_module(module)
    except Exception as error:
        del sys.modules[name]
        raise DeclarationError(locate(error, path)) from error
    return module


def _load_method(path: Path) -> type[Method]:
    module = _load(path)
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
    method.name = folder.name
    _check_class(path, method)
    method.__doc__ = module.__doc__
    shared = folder.parent.parent / "glsl"
    of_collection = folder.parent.name == "methods" and shared.is_dir()
    method.folders = (folder, shared) if of_collection else (folder,)
    return method


def _check_class(path: Path, method: type[Method]) -> None:
    """Raise `DeclarationError` if promises or effects of a method have a wrong type."""
    try:
        default = method()
        promises, effects = default.promises, default.expresses
    except Exception as error:
        raise DeclarationError(locate(error, path)) from error
    if not isinstance(promises, frozenset):
        raise DeclarationError(f'{path}: promises is {promises!r}; write oit.promise("NAME NAME")')
    if not isinstance(effects, Effect):
        raise DeclarationError(f"{path}: expresses is {effects!r}; combine oit.Effect by |")


def _load_scene(path: Path) -> ScenePlugin:
    module = _load(path)
    for member in ("parameters", "build"):
        if not hasattr(module, member):
            raise DeclarationError(f"{path}: defines no '{member}'; every scene needs one")
    return ScenePlugin(
        path.stem, module.__doc__ or "", module.parameters, module.build,
        getattr(module, "quick", True),
    )  # fmt: skip

"""Finds methods, scenes, references and reports by path, wherever the package was installed."""

from __future__ import annotations

import importlib.util
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from importlib.metadata import entry_points
from pathlib import Path
from types import ModuleType
from typing import Any, TypeVar

from oitbench import parameters as selector
from oitbench.errors import DeclarationError, OitbenchError, SceneError, UsageError, unknown
from oitbench.method.declaration import Method
from oitbench.parameters import Parameter, Value
from oitbench.scene import Scene

Plugin = TypeVar("Plugin")
KINDS = ("methods", "scenes", "reference", "reports")


@dataclass(frozen=True)
class ScenePlugin:
    """A scene's file: what it is, what it can be asked for, and how it is built.

    `quick` tells whether the preset that should take two minutes renders it when none is named.
    """

    name: str
    doc: str
    parameters: Mapping[str, Parameter]
    build: Callable[..., Scene]
    quick: bool = True


class Plugins(Mapping[str, Plugin]):
    """Plugins of one kind by name; a file is loaded when it is first asked for.

    So a stranger's broken file hurts only who asks for it, and listing names costs nothing.
    Looking up a name raises `UsageError` with near names, or `DeclarationError` if its file fails.
    """

    def __init__(self, kind: str, load: Callable[[Path], Plugin]) -> None:
        self.kind, self._load = kind, load
        self._paths: dict[str, Path] = {}
        self._loaded: dict[str, Plugin] = {}

    def add(self, name: str, path: Path) -> None:
        """Add the plugin of `path`, or replace the one of that name."""
        self._paths[name] = path
        self._loaded.pop(name, None)

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
        Where they come from; each may have `methods`, `scenes`, `reference` and `reports`.
    """

    def __init__(self) -> None:
        self.methods: Plugins[type[Method]] = Plugins("method", _method_plugin)
        self.scenes: Plugins[ScenePlugin] = Plugins("scene", _scene_plugin)
        self.reports: Plugins[ModuleType] = Plugins("report", _load)
        self.folders: list[Path] = []

    @classmethod
    def load(cls, extra: Iterable[Path] = ()) -> Collection:
        """Find the suite's own collection, installed ones, and the folders `extra`, in this order.

        Raises
        ------
        UsageError
            A folder does not exist or holds none of the four kinds.
        """
        collection = cls()
        for folder in (own_folder(), *_installed(), *map(Path, extra)):
            collection.add(folder)
        return collection

    def add(self, folder: Path) -> None:
        """Add the plugins of one collection folder; a name that is known is replaced."""
        folder = folder.resolve()
        if not any((folder / kind).is_dir() for kind in KINDS):
            raise UsageError(f"{folder} is no collection; it has none of {', '.join(KINDS)}")
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
        """Return every method that `NAME[param=v,w]` or `path/to/folder[param=v]` stands for."""
        chosen: dict[str, Method] = {}
        for text in texts:
            parsed = selector.parse(text)
            if "/" in parsed.name or (Path(parsed.name) / "method.py").is_file():
                method = self.add_method(Path(parsed.name))
            else:
                method = self.methods[parsed.name]
            parsed = selector.Selector(method.name, parsed.grid)
            for values in selector.expand(parsed, method.parameters):
                item = method(**values)
                chosen[item.label] = item
        return list(chosen.values())

    def expand_scenes(self, texts: Iterable[str]) -> list[str]:
        """Return the canonical label of every scene that `NAME[param=v,w]` stands for."""
        chosen: dict[str, None] = {}
        for text in texts:
            parsed = selector.parse(text)
            plugin = self.scenes[parsed.name]
            for values in selector.expand(parsed, plugin.parameters):
                chosen[selector.variant(parsed.name, values, plugin.parameters)] = None
        return list(chosen)

    def build_scene(self, text: str) -> Scene:
        """Build the one scene that `text` stands for."""
        parsed = selector.parse(text)
        plugin = self.scenes[parsed.name]
        assignments = list(selector.expand(parsed, plugin.parameters))
        if len(assignments) != 1:
            raise UsageError(f"'{text}' stands for {len(assignments)} scenes; name one")
        values: dict[str, Value] = assignments[0]
        label = selector.variant(parsed.name, values, plugin.parameters)
        try:
            return plugin.build(name=label, **values)
        except OitbenchError:
            raise
        except Exception as error:
            # Whose bug it is must be told; the engine goes on.
            raise SceneError(f"scene {label}: {type(error).__name__}: {error}") from error

    def truth(self) -> Method:
        """Return the method that renders the exact truth, with its parameters for it."""
        for name in self.methods:
            try:
                method = self.methods[name]
            except DeclarationError:
                continue  # whoever asks for that method will be told
            if method.truth is not None:
                return method(**method.truth)
        raise UsageError("no method serves as the exact truth; give a collection that has one")


def own_folder() -> Path:
    """Return the suite's own collection: inside an installed package, else the checkout."""
    package = Path(__file__).parent
    inside = package / "collection"
    return inside if inside.is_dir() else package.parent


def folder_of(method: type[Method]) -> Path:
    """Return the folder that `method` was loaded from."""
    return Path(str(sys.modules[method.__module__].__file__)).parent


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
    """Load a plugin's file under a private name, so that it can collide with nothing."""
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
        raise DeclarationError(f"{path}: {type(error).__name__}: {error}") from error
    return module


def _method_plugin(path: Path) -> type[Method]:
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
    method = found[0]
    method.name = path.parent.name
    method.__doc__ = module.__doc__
    return method


def _scene_plugin(path: Path) -> ScenePlugin:
    module = _load(path)
    for member in ("parameters", "build"):
        if not hasattr(module, member):
            raise DeclarationError(f"{path}: defines no '{member}'; every scene needs one")
    return ScenePlugin(
        path.stem, module.__doc__ or "", module.parameters, module.build,
        getattr(module, "quick", True),
    )  # fmt: skip

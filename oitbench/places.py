"""Finds the files of methods, scenes and reports in collections; opens none of them."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path

from msgspec import Struct

from oitbench.errors import UsageError, printable, unknown

KINDS = ("methods", "scenes", "reference", "reports")
GROUP = "oitbench.collections"
"""Entry points under which installed packages register their collection folders."""
IMPORTED = (".glb", ".gltf", ".obj", ".ply")
"""Ends of the names of files of other programs that are scenes by themselves."""
WRITTEN = ".npz"
"""End of the names of files of scenes that were built in Python."""
_FILES = (*IMPORTED, WRITTEN)


class Names(Mapping[str, Path]):
    """Files of plugins of one kind by name, in alphabetical order."""

    def __init__(self, kind: str) -> None:
        self.kind = kind
        self._paths: dict[str, Path] = {}

    def add(self, name: str, path: Path) -> None:
        """Add the plugin of `path`.

        Raises
        ------
        UsageError
            Another file already has that name.
        """
        known = self._paths.setdefault(printable(name), path)
        if known != path:
            raise UsageError(f"two {self.kind}s are named '{name}': {known} and {path}; rename one")

    def __getitem__(self, name: str) -> Path:
        if name not in self._paths:
            raise unknown(self.kind, name, self._paths)
        return self._paths[name]

    def __contains__(self, name: object) -> bool:
        return name in self._paths

    def __iter__(self) -> Iterator[str]:
        return iter(sorted(self._paths))

    def __len__(self) -> int:
        return len(self._paths)


class PluginFiles(Struct, frozen=True):
    """The files of the plugins that a worker needs, as a part of its settings.

    Parameters
    ----------
    collections : list of Path
        All collection folders.
    scenes : list of Path
        Further files that are scenes.
    methods : dict of str to Path
        Further methods by name.
    """

    collections: list[Path]
    scenes: list[Path] = []
    methods: dict[str, Path] = {}

    def places(self) -> Places:
        """Return the places of these plugins."""
        places = Places(self.collections, (), self.scenes)
        for name, path in self.methods.items():
            places.methods.add(name, path)
        return places


class Places:
    """The files of all plugins that can be used by name.

    Attributes
    ----------
    folders : list of Path
        Collection folders; each may have `methods`, `scenes`, `reference`, `reports` and `glsl`.
    methods, scenes, reports : Names
    """

    def __init__(
        self,
        folders: Iterable[Path] = (),
        methods: Iterable[Path] = (),
        scenes: Iterable[Path] = (),
    ) -> None:
        self.folders: list[Path] = []
        self.methods, self.scenes, self.reports = Names("method"), Names("scene"), Names("report")
        for folder in folders:
            self.add(folder)
        for folder in methods:
            self.add_method(folder)
        for path in scenes:
            self.add_scene(path)

    def add(self, folder: Path) -> None:
        """Add the plugins of one collection folder.

        Raises
        ------
        UsageError
            The folder does not exist or is no collection, or two plugins have one name.
        """
        try:
            folder = folder.resolve()
            known = any((folder / kind).is_dir() for kind in KINDS)
        except (OSError, RuntimeError) as error:
            raise UsageError(f"{folder} cannot be read: {error}") from error
        if not known:
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

    def add_method(self, folder: Path) -> str:
        """Add the method of one folder, which holds `method.py` and its shaders; return its name.

        Raises
        ------
        UsageError
            The folder is no method, or another method has its name.
        """
        path = folder.resolve() / "method.py"
        if not path.is_file():
            raise UsageError(f"{folder} is no method; it has no method.py")
        self.methods.add(path.parent.name, path)
        return printable(path.parent.name)

    def find_method(self, text: str) -> str:
        """Return the name of the method that a name or a folder's path selects.

        A known name takes precedence over a folder of that name in the working directory.
        """
        here = text not in self.methods and (Path(text) / "method.py").is_file()
        return self.add_method(Path(text)) if "/" in text or here else text

    def add_scene(self, path: Path) -> str:
        """Add the scene of one file that is a scene by itself; return its name, the file's.

        Raises
        ------
        UsageError
            There is no such file, its name cannot be that of a scene, or another scene has it.
        """
        if not path.is_file():
            raise UsageError(f"{path}: there is no such file")
        name = printable(path.stem)
        if not name.strip() or set(name) & set("[],=@"):
            raise UsageError(f"{path}: a scene cannot have the name '{name}'; rename the file")
        # The name that the user gave decides what the file is, not that of a link's target.
        self.scenes.add(name, path.parent.resolve() / path.name)
        return name

    def find_scene(self, text: str) -> str:
        """Return the name of the scene that a name or the path of a file selects.

        A known name takes precedence over a file of that name in the working directory.
        """
        path = Path(text)
        is_file = path.suffix.lower() in _FILES
        return self.add_scene(path) if text not in self.scenes and is_file else text

    def files(self, methods: Iterable[str] = ()) -> PluginFiles:
        """Return the files that a worker needs for any scene and the `methods` of some names."""
        chosen = {name: self.methods[name] for name in methods}
        return PluginFiles(list(self.folders), list(self.scene_files), chosen)

    @property
    def scene_files(self) -> tuple[Path, ...]:
        """The files that were added by their paths."""
        return tuple(path for path in self.scenes.values() if path.suffix.lower() in _FILES)


def own_folder() -> Path:
    """Return the suite's own collection: inside an installed package, else the checkout."""
    package = Path(__file__).resolve().parent
    inside = package / "collection"
    return inside if inside.is_dir() else package.parent


def _children(folder: Path, pattern: str) -> list[Path]:
    return [
        path
        for path in sorted(folder.glob(pattern))
        if not path.name.startswith("_") and not path.parent.name.startswith("_")
    ]

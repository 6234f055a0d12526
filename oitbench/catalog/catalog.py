"""The near end: what a command knows about plugins, and the selection of some of them."""

from __future__ import annotations

import itertools
import logging
from collections.abc import Iterable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from importlib.metadata import entry_points
from pathlib import Path

from oitbench import parameters as selectors
from oitbench.catalog.messages import (
    Axes,
    AxesFound,
    Demand,
    DemandsFound,
    Describe,
    Entry,
    Inspect,
    Inspected,
    Kind,
    Nothing,
    Portrait,
    Portray,
    Reply,
    Resolve,
    Resolved,
)
from oitbench.crops import Crop
from oitbench.errors import DeclarationError, OitbenchError, SceneError
from oitbench.method.demands import Demands
from oitbench.parameters import Selector
from oitbench.places import GROUP, IMPORTED, Names, Places, own_folder
from oitbench.workers import memory
from oitbench.workers.messages import Step
from oitbench.workers.process import Process

LOAD_SECONDS = 30.0
"""Time in which each file of a plugin must be loaded by default."""
_LOADING, _READING = Step("loading the file"), Step("reading the file")
_FILE_SECONDS = 300.0
_LOG = logging.getLogger(__name__)


@dataclass(frozen=True)
class Choice:
    """A method or a scene with values of its parameters.

    Parameters
    ----------
    label : str
        Canonical, except if the plugin cannot be used.
    name : str
    error : str
        Why the plugin cannot be used, in one line; else empty.
    """

    label: str
    name: str
    error: str = ""


class Catalog:
    """All plugins that can be used by name; a context manager.

    A worker loads the files, each when it is first asked for.

    Parameters
    ----------
    extra : iterable of path
        Further collection folders.
    memory_limit : int, optional
        Bytes that the worker may use. Default: the share of a single worker.
    load_seconds : float
        Time in which each file must be loaded.

    Attributes
    ----------
    places : Places
    problems : list of str
        Why installed collections cannot be used, one line for each.

    Raises
    ------
    UsageError
        A folder does not exist or is no collection, or two plugins have one name.
    """

    def __init__(
        self,
        extra: Iterable[Path | str] = (),
        memory_limit: int | None = None,
        load_seconds: float = LOAD_SECONDS,
    ) -> None:
        limit = memory.share(1) if memory_limit is None else memory_limit
        self._worker = Process("oitbench.catalog.worker", Nothing(), Reply, limit)
        self._load_seconds = load_seconds
        self._entries: dict[tuple[Kind, str], Entry] = {}
        self._inspected: dict[str, Inspected] = {}
        self.problems: list[str] = []
        # It needs longest, so it starts first.
        self._worker.start()
        try:
            self.places = Places((own_folder(), *self._installed(), *map(Path, extra)))
        except BaseException:
            self._worker.stop()
            raise

    def __enter__(self) -> Catalog:
        return self

    def __exit__(self, *error: object) -> None:
        self._worker.stop()

    def _installed(self) -> Iterator[Path]:
        """Yield the folders that installed packages register as collections."""
        for entry in entry_points(group=GROUP):
            try:
                request = Resolve(entry.value)
                found = self._worker.ask(
                    request, Resolved, self._load_seconds, _LOADING, retry=True
                )
            except OitbenchError as error:
                self.problems.append(f"collection {entry.value}: {error}")
                _LOG.warning("%s", self.problems[-1])
                continue
            yield found.folder

    def names(self, kind: Kind) -> list[str]:
        """Return the names of all plugins of a kind."""
        return list(self._paths(kind))

    def path(self, kind: Kind, name: str) -> Path:
        """Return the file of a plugin; raise `UsageError` with near names if there is none."""
        return self._paths(kind)[name]

    def _paths(self, kind: Kind) -> Names:
        places = self.places
        return {"method": places.methods, "scene": places.scenes, "report": places.reports}[kind]

    def entry(self, kind: Kind, name: str, check: bool = False) -> Entry:
        """Return the description of a plugin.

        Parameters
        ----------
        kind, name : str
        check : bool
            Whether to load the file of a report, which is slow, and not only to parse it; and to
            build a scene, with little detail, for the names of its views.

        Raises
        ------
        UsageError
            There is no such plugin.
        """
        path = self.path(kind, name)
        if (kind, name) in self._entries and not check:
            return self._entries[kind, name]
        request = Describe(kind, name, path, check)
        try:
            found = self._worker.ask(request, Entry, self._load_seconds, _LOADING, retry=True)
        except OitbenchError as error:
            found = Entry(name, error=f"{path}: {error}")
        if not (check and found.error):
            # A plugin that fails a check may still be described.
            self._entries[kind, name] = found
        return found

    def expand_methods(self, texts: Iterable[str]) -> list[Choice]:
        """Return all methods that the selectors `NAME[param=v,w]` or `FOLDER[param=v]` select."""
        chosen: dict[str, Choice] = {}
        for text in texts:
            parsed = selectors.parse(text)
            name = self.places.find_method(parsed.name)
            for choice in self._expand("method", Selector(name, parsed.grid)):
                chosen[choice.label] = choice
        return list(chosen.values())

    def expand_scenes(self, texts: Iterable[str]) -> list[Choice]:
        """Return all scenes that the selectors `NAME[param=v,w]` or `FILE[param=v]` select.

        A file is read, and what its scene shows differently is logged as warnings.
        """
        chosen: dict[str, Choice] = {}
        for text in texts:
            parsed = selectors.parse(text)
            name = self.places.find_scene(parsed.name)
            for choice in self._expand("scene", Selector(name, parsed.grid)):
                chosen[choice.label] = choice
        noted: set[tuple[str, str]] = set()
        return [self._checked(choice, noted) for choice in chosen.values()]

    def _checked(self, choice: Choice, noted: set[tuple[str, str]]) -> Choice:
        """Return a choice with the reason why it cannot be used; log what is not `noted` yet."""
        path = self.path("scene", choice.name)
        if choice.error or path.suffix.lower() not in IMPORTED:
            return choice
        try:
            found = self.inspect(choice)
        except OitbenchError as error:
            return replace(choice, error=f"{path}: {error}")
        for note in found.notes:
            if (choice.name, note) not in noted:
                noted.add((choice.name, note))
                _LOG.warning("%s: %s", choice.name, note)
        return choice

    def check_files(self, texts: Iterable[str]) -> None:
        """Read those scenes that are files, `FILE[param=v]`.

        Raises
        ------
        OitbenchError
            A file is missing, damaged or too large.
        """
        for text in texts:
            name = self.places.find_scene(selectors.parse(text).name)
            if name in self.places.scenes and self.path("scene", name) in self.places.scene_files:
                for choice in self.expand_scenes([text]):
                    if choice.error:
                        raise SceneError(choice.error)

    def inspect(self, scene: Choice) -> Inspected:
        """Return what is known of the scene of a file that can be imported; read it once.

        Raises
        ------
        OitbenchError
            The file is damaged, or too large.
        """
        if scene.label not in self._inspected:
            request = Inspect(scene.label, self.path("scene", scene.name))
            self._inspected[scene.label] = self._worker.ask(
                request, Inspected, _FILE_SECONDS, _READING, retry=True
            )
        return self._inspected[scene.label]

    def _expand(self, kind: Kind, parsed: Selector) -> Iterator[Choice]:
        entry = self.entry(kind, parsed.name)
        if entry.error:
            # The parameters are unknown, so the values stay as they were written.
            for texts in itertools.product(*parsed.grid.values()):
                written = {key: (text,) for key, text in zip(parsed.grid, texts, strict=True)}
                yield Choice(selectors.selector(entry.name, written), entry.name, entry.error)
            return
        for values in selectors.expand(parsed, entry.parameters):
            label = selectors.label(entry.name, values, entry.parameters)
            yield Choice(label, entry.name)

    def crops(self, scenes: Iterable[str]) -> dict[str, dict[str, Crop]]:
        """Return the crops of those scenes that are known and can be loaded, by name."""
        known = [name for name in scenes if name in self.places.scenes]
        return {name: self.entry("scene", name).crops for name in known}

    def demands(self, method: Choice) -> Demands:
        """Return what a method demands in a scene that requests all effects that it shows.

        Raises
        ------
        OitbenchError
            The method cannot be loaded, or its plan is wrong.
        """
        if method.error:
            raise DeclarationError(method.error)
        request = Demand(method.label, self.path("method", method.name))
        return self._worker.ask(request, DemandsFound, self._load_seconds, retry=True).demands

    def portrait(self, label: str) -> Portrait | str:
        """Return a method as its file describes it; one line with the reason if it cannot be used.

        Parameters
        ----------
        label : str
            Of the method with its parameters.
        """
        name = label.partition("[")[0]
        if name not in self.places.methods:
            return f"no collection has a method '{name}'; --collection adds one"
        path = self.path("method", name)
        try:
            return self._worker.ask(Portray(label, path), Portrait, self._load_seconds, retry=True)
        except OitbenchError as error:
            return f"{path}: {error}"

    def effects_axes(
        self, scene: Choice, methods: Sequence[Choice], timeout: float | None
    ) -> dict[str, list[str]]:
        """Return the values of "each" on the axis of effects by the label of a method.

        The scene is built. If that fails, or takes longer than `timeout` seconds, nothing is
        returned: the cells of the scene will report why.
        """
        usable = [method for method in methods if not method.error]
        if scene.error or not usable:
            return {}
        request = Axes(
            scene.label,
            [method.label for method in usable],
            self.path("scene", scene.name),
            {method.name: self.path("method", method.name) for method in usable},
        )
        with suppress(OitbenchError):
            found = self._worker.ask(request, AxesFound, timeout, retry=True)
            return {m.label: axis for m, axis in zip(usable, found.axes, strict=True)}
        return {}

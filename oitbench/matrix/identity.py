"""What determines a cell: the fingerprints of its scene, its method, the suite and its truths."""

from __future__ import annotations

from collections.abc import Callable

from oitbench.errors import OitbenchError, UsageError
from oitbench.fingerprints.code import engine_fingerprint, method_fingerprint, metrics_fingerprint
from oitbench.fingerprints.scene import scene_fingerprint
from oitbench.matrix.cell import Cell
from oitbench.method.declaration import Method
from oitbench.plugins import Collection
from oitbench.results.schema import EXACT, PATH_TRACED, Fingerprints
from oitbench.scene import Scene


class Identities:
    """Builds scenes and computes fingerprints of cells; the last scene is kept.

    Parameters
    ----------
    collection : Collection
    on_building : callable
        Called before a scene is built, which may take long.
    """

    def __init__(self, collection: Collection, on_building: Callable[[], None]) -> None:
        self._collection, self._on_building = collection, on_building
        self._label = ""
        self._scene: tuple[Scene, str] | None = None
        self._methods: dict[str, str] = {}
        self._truth: tuple[tuple[str, tuple[int, int], int], str] | None = None

    def scene(self, label: str) -> Scene:
        """Return a scene by its label."""
        return self._described(label)[0]

    def find(self, cell: Cell) -> Fingerprints | None:
        """Return the fingerprints of a cell; None if its scene or its method is broken."""
        try:
            (method,) = self._collection.expand_methods([cell.method])
            return self.of(cell, method)
        except OitbenchError:
            return None

    def of(self, cell: Cell, method: Method) -> Fingerprints:
        """Return the fingerprints of a cell.

        Raises
        ------
        OitbenchError
            The scene cannot be built, or the method's files have changed since they were loaded.
        """
        scene, fingerprint = self._described(cell.scene)
        truths = {EXACT: method_fingerprint(self._collection.truth())}
        if PATH_TRACED in cell.truths:
            truths[PATH_TRACED] = self._path_traced(cell, scene)
        return Fingerprints(
            scene=fingerprint,
            method=self.check_unchanged(method),
            engine=engine_fingerprint(),
            metrics=metrics_fingerprint(),
            truths=truths,
        )

    def check_unchanged(self, method: Method) -> str:
        """Return the fingerprint of a method, which must be that of its first use.

        Raises
        ------
        UsageError
            A file of the method has changed. What was loaded before belongs to the old files.
        """
        current = method_fingerprint(method)
        if self._methods.setdefault(method.label, current) != current:
            raise UsageError(f"{method.name}: its files changed during the run; run again")
        return current

    def _described(self, label: str) -> tuple[Scene, str]:
        if self._scene is None or self._label != label:
            self._scene, self._truth = None, None
            self._on_building()
            scene = self._collection.build_scene(label)
            self._label, self._scene = label, (scene, scene_fingerprint(scene))
        return self._scene

    def _path_traced(self, cell: Cell, scene: Scene) -> str:
        from oitbench.path_traced.references.lookup import truth_fingerprint

        place = (cell.scene, cell.size, cell.ssaa)
        if self._truth is None or self._truth[0] != place:
            self._truth = place, truth_fingerprint(scene, *place, self._collection.folders)
        return self._truth[1]

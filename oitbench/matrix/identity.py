"""What determines a cell: the fingerprints of its scene, its method, the suite and its truths."""

from __future__ import annotations

from collections.abc import Callable

from oitbench.effects import Effect
from oitbench.errors import OitbenchError, UsageError
from oitbench.fingerprints.code import engine_fingerprint, method_fingerprint, metrics_fingerprint
from oitbench.fingerprints.scene import scene_fingerprint
from oitbench.matrix.cell import Cell, choose_effects
from oitbench.method.declaration import Method
from oitbench.plugins import Collection
from oitbench.results.schema import WHOLE, Fingerprints
from oitbench.scene import Scene
from oitbench.truths import EXACT, MATCHED, TRACED, ranking_truth
from oitbench.views import MAIN


class Identities:
    """Builds scenes and computes fingerprints of cells; the last scene is kept with its views.

    Parameters
    ----------
    collection : Collection
    on_building : callable
        Called before a scene is built, which may take long.
    """

    def __init__(self, collection: Collection, on_building: Callable[[], None]) -> None:
        self._collection, self._on_building = collection, on_building
        self._label = ""
        self._views: dict[str, tuple[Scene, str]] = {}
        self._methods: dict[str, str] = {}
        self._truths: dict[tuple[str, int], str] = {}

    def scene(self, cell: Cell) -> Scene:
        """Return the scene of a cell as seen from its view."""
        return self._described(cell)[0]

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
        scene, fingerprint = self._described(cell)
        truths = {EXACT: method_fingerprint(self._collection.truth())}
        chosen = choose_effects(cell.effects, scene.effects)
        for kind in TRACED:
            if kind in cell.truths:
                truths[kind] = self._traced(cell, scene, kind, chosen)
        if scene.effects & ~chosen and ranking_truth(scene.effects) in truths.keys() - {EXACT}:
            truths[WHOLE] = self._traced(cell, scene, MATCHED, ~Effect.NONE)
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

    def _described(self, cell: Cell) -> tuple[Scene, str]:
        if not self._views or self._label != cell.scene:
            self._views, self._truths = {}, {}
            self._on_building()
            scene = self._collection.build_scene(cell.scene)
            self._label, self._views[MAIN] = cell.scene, (scene, scene_fingerprint(scene))
        if cell.view not in self._views:
            scene = self._views[MAIN][0].from_view(cell.view)
            self._views[cell.view] = scene, scene_fingerprint(scene)
        return self._views[cell.view]

    def _traced(self, cell: Cell, scene: Scene, kind: str, chosen: Effect) -> str:
        from oitbench.path_traced.references.lookup import truth_fingerprint
        from oitbench.path_traced.references.wanted import Wanted

        wanted = Wanted(scene, cell.scene, cell.traced_size, cell.ssaa, kind, chosen, cell.view)
        place = wanted.key, wanted.grid
        if place not in self._truths:
            self._truths[place] = truth_fingerprint(wanted, self._collection.folders)
        return self._truths[place]

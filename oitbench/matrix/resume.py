"""Decides which cells of an earlier run are kept: those whose content is the same."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from oitbench.errors import UsageError
from oitbench.image import stored
from oitbench.matrix.cell import Cell
from oitbench.results.schema import FINISHED, WHOLE, Fingerprints, Record, Renderer
from oitbench.results.store import Store
from oitbench.truths import MATCHED, TRUTHS

Identify = Callable[[list[Cell]], Sequence[Fingerprints | None]]
"""Returns the fingerprints of the cells of one scene; None if scene or method is broken."""
_KEPT = FINISHED | {"skipped"}


@dataclass(frozen=True)
class Resume:
    """The cells of an earlier run.

    Parameters
    ----------
    store : Store
    gl : Renderer
        The renderer of this run.
    force : bool
        Run all cells again.
    """

    store: Store
    gl: Renderer
    force: bool = False

    def redone(self, cells: Sequence[Cell], identify: Identify) -> dict[Cell, str]:
        """Return the cells of one scene that are run, each with the reason.

        The reason is empty if there is no earlier result, or none is wanted.

        Parameters
        ----------
        cells : sequence of Cell
        identify : callable
            Called for the cells that have a result, if there are any.
        """
        records = {cell: self.store.find(cell.key) for cell in cells}
        known = {
            cell: record
            for cell, record in records.items()
            if record is not None and record.status in _KEPT and not self.force
        }
        current = identify(list(known)) if known else ()
        reasons = {
            cell: self._reason(record, cell, fingerprints)
            for (cell, record), fingerprints in zip(known.items(), current, strict=True)
        }
        return {
            cell: reasons.get(cell) or "" for cell in cells if reasons.get(cell, "") is not None
        }

    def _reason(self, record: Record, cell: Cell, current: Fingerprints | None) -> str | None:
        """Return why a cell with a result is run again; None if it is kept."""
        if current is None or record.fingerprints is None:
            return "its scene or its method cannot be loaded"
        parts = list(_changes(record, cell, record.fingerprints, current, self.gl))
        if parts:
            return f"{' and '.join(parts)} changed"
        return _damage(record, self.store.folder)


def describe(redone: dict[Cell, str]) -> Iterator[str]:
    """Yield one line for all cells of a scene that are run again for the same reason.

    Parameters
    ----------
    redone : dict of Cell to str
        From `Resume.redone`.
    """
    groups: dict[tuple[str, str], list[str]] = {}
    for cell, reason in redone.items():
        if reason:
            groups.setdefault((cell.seen, reason), []).append(cell.method)
    for (scene, reason), methods in groups.items():
        yield f"redone: {scene} {', '.join(dict.fromkeys(methods))}: {reason}"


def _changes(
    record: Record, cell: Cell, before: Fingerprints, now: Fingerprints, gl: Renderer
) -> Iterator[str]:
    """Yield the names of all parts of a cell that are not what they were."""
    pairs: dict[str, tuple[object, object]] = {
        "the scene": (before.scene, now.scene),
        "the method": (before.method, now.method),
        "the engine": (before.engine, now.engine),
        "the metrics": (before.metrics, now.metrics),
        "the driver": (record.gl, gl),
        "the seed": (record.seed, cell.seed),
        "the number of permutations": (record.permutations, cell.permutations),
        "the choice of truths": (set(record.truths), set(cell.truths)),
    }
    if record.status == "skipped":
        pairs["the limit of layers"] = record.most_layers, cell.most_layers
    # A truth always changes with its scene, which says enough.
    same_scene = before.scene == now.scene
    for truth in before.truths.keys() & now.truths.keys() if same_scene else ():
        name = f"the truth by {TRUTHS[MATCHED if truth == WHOLE else truth]}"
        pairs[name] = before.truths[truth], now.truths[truth]
    yield from (name for name, (old, new) in pairs.items() if old != new)


def _damage(record: Record, folder: Path) -> str | None:
    """Return the first image of a record that is missing or damaged, or None."""
    for image in record.outcome.images.values() if record.outcome else ():
        try:
            stored.verify(folder, image)
        except UsageError as error:
            return str(error)
    return None

"""The far end of estimates: what scoring a cell takes, and what the process uses."""

from __future__ import annotations

import time
from collections.abc import Sequence
from pathlib import Path

from msgspec import Struct

from oitbench.errors import OitbenchError
from oitbench.image import metrics, ties
from oitbench.matrix.cell import Cell, choose_effects
from oitbench.scene import Scene
from oitbench.truths import TRACED


class ProbeTruths(Struct, frozen=True, tag=True):
    """Asks for the traced truths of a cell; renders none."""

    cell: Cell


class ProbeUsage(Struct, frozen=True, tag=True):
    """Asks for the largest memory that the process has had, and for its CPU time so far."""


class ProbedTruth(Struct, frozen=True):
    """A traced truth of a cell.

    `pixels` is its size; None if it has to be rendered first. `jackknife` is the seconds of scoring
    a picture against the means of its parts.
    """

    kind: str
    pixels: int | None
    jackknife: float = 0.0


class TruthsProbed(Struct, frozen=True, tag=True):
    """The traced truths of a cell."""

    truths: list[ProbedTruth]


class UsageProbed(Struct, frozen=True, tag=True):
    """Bytes of memory, now and at most so far, and seconds of CPU time of all threads."""

    resident: int
    peak: int
    cpu: float


def probe_truths(scene: Scene, cell: Cell, folders: Sequence[Path]) -> TruthsProbed:
    """Return the traced truths of a cell; those that this machine cannot render are left out.

    Parameters
    ----------
    scene : Scene
        As seen from the cell's view.
    cell : Cell
    folders : sequence of Path
        Folders of collections.
    """
    from oitbench.path_traced.export.checks import require_traceable
    from oitbench.path_traced.references.lookup import find_finished
    from oitbench.path_traced.references.wanted import Wanted

    chosen = choose_effects(cell.effects, scene.effects)
    found = []
    for kind in TRACED:
        if kind not in cell.truths:
            continue
        wanted = Wanted(scene, cell.scene, cell.traced_size, cell.ssaa, kind, chosen, cell.view)
        try:
            reference = find_finished(wanted, folders)
            if reference is None:
                require_traceable(scene)
        except OitbenchError:
            continue
        if reference is None:
            found.append(ProbedTruth(kind, None))
            continue
        start = time.perf_counter()
        for mean in ties.means_without(reference.parts):
            metrics.flip_ldr(mean, reference.mean, scene.exposure)
        height, width, _ = reference.mean.shape
        found.append(ProbedTruth(kind, width * height, time.perf_counter() - start))
    return TruthsProbed(found)

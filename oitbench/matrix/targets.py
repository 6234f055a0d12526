"""Targets of one frame as pictures: what a method and the shading that all methods share store."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from oitbench.image import values
from oitbench.image.values import Picture, Values
from oitbench.matrix.lone_worker import lone_worker
from oitbench.matrix.plan import CELL_SECONDS
from oitbench.matrix.worker import ALL, LIST, DrawTargets, TargetFacts, TargetsDrawn
from oitbench.method.ablation import REQUESTED
from oitbench.shading import read_shading
from oitbench.views import MAIN
from oitbench.workers.messages import Step

__all__ = ["ALL", "LIST", "DrawnTarget", "TargetFacts", "draw"]
_DRAWING = Step("drawing the targets")


@dataclass(frozen=True)
class DrawnTarget:
    """A target with its values, shape (h, w, components); None if only facts were asked for."""

    facts: TargetFacts
    values: Values | None
    exposure: float

    @property
    def picture(self) -> Picture:
        """The values as a picture."""
        assert self.values is not None
        return values.picture(self.values, self.facts.show, self.exposure, self.facts.unit)

    def write_exr(self, path: Path) -> None:
        """Write the values as they are."""
        assert self.values is not None
        values.write_values(path, self.values, depth=self.facts.depth)


def draw(
    scene: str,
    method: str,
    names: Sequence[str] = (ALL,),
    size: tuple[int, int] = (512, 512),
    ssaa: int = 1,
    effects: str = REQUESTED,
    collections: Iterable[Path | str] = (),
    timeout: float | None = CELL_SECONDS,
    memory_gib: float | None = None,
    shading: Sequence[str] = (),
    view: str = MAIN,
) -> list[DrawnTarget]:
    """Render a frame of `scene` with `method` in a process of its own, and return its targets.

    Parameters
    ----------
    scene, method : str
        `NAME[param=v]`; a method may also be a folder's path.
    names : sequence of str
        Names of targets and views (see `oitbench.gl.frame_targets`), or only `ALL`: all that can
        be read, or only `LIST`: the facts of all, with no values.
    size, ssaa, effects, collections, timeout, memory_gib, shading, view
        As for `oitbench.matrix.picture.render`. Texels are those of sub-pixels.

    Raises
    ------
    OitbenchError
        Something is unknown, out of range, or not available on this machine, or the process ended.
    """
    settings = read_shading(",".join(shading)).label
    with lone_worker(scene, collections, memory_gib) as (worker, folder):
        file = folder / "targets.npz"
        request = DrawTargets(scene, method, size, ssaa, effects, list(names), file, settings, view)
        drawn = worker.ask(request, TargetsDrawn, timeout, _DRAWING)
        if not file.exists():
            return [DrawnTarget(facts, None, drawn.exposure) for facts in drawn.targets]
        with np.load(file) as archive:
            arrays = [archive[str(number)] for number in range(len(drawn.targets))]
    return [
        DrawnTarget(facts, array, drawn.exposure)
        for facts, array in zip(drawn.targets, arrays, strict=True)
    ]

"""One picture of one scene by one method."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path

import numpy as np

from oitbench.image.files import Image
from oitbench.matrix.lone_worker import lone_worker
from oitbench.matrix.plan import CELL_SECONDS
from oitbench.matrix.worker import DrawPicture, PictureDrawn
from oitbench.method.ablation import REQUESTED
from oitbench.shading import read_shading
from oitbench.views import MAIN
from oitbench.workers.messages import Step

_DRAWING = Step("drawing the picture")


def render(
    scene: str,
    method: str,
    size: tuple[int, int] = (512, 512),
    ssaa: int = 2,
    effects: str = REQUESTED,
    collections: Iterable[Path | str] = (),
    timeout: float | None = CELL_SECONDS,
    memory_gib: float | None = None,
    shading: Sequence[str] = (),
    view: str = MAIN,
) -> tuple[Image, float]:
    """Render `scene` with `method` in a process of its own.

    Parameters
    ----------
    scene, method : str
        `NAME[param=v]`; a method may also be a folder's path.
    size : (int, int)
        Width and height in pixels.
    ssaa : int
        Side of the sub-pixel grid that is averaged.
    effects : str
        See `oitbench.matrix.cell.Cell`.
    collections : iterable of path
        Further collection folders.
    timeout : float, optional
        Seconds that the picture may take. None: no limit.
    memory_gib : float, optional
        Memory that the process may use, in GiB. Default: 75 % of the machine's.
    shading : sequence of str
        Settings of shared shading, NAME=value.
    view : str
        Name of the scene's camera; see `Scene.from_view`.

    Returns
    -------
    image : array, shape (h, w, 3), float32
        Linear Rec.709, top row first.
    exposure : float
        The scene's exposure in stops.

    Raises
    ------
    OitbenchError
        Something is unknown, out of range, or not available on this machine, or the process ended.
    """
    settings = read_shading(",".join(shading)).label
    with lone_worker(scene, collections, memory_gib) as (worker, folder):
        file = folder / "image.npy"
        request = DrawPicture(scene, method, size, ssaa, effects, file, settings, view)
        drawn = worker.ask(request, PictureDrawn, timeout, _DRAWING)
        image: Image = np.load(file)
    return image, drawn.exposure

"""One picture of one scene by one method."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from oitbench.errors import UsageError
from oitbench.gl.device import Device
from oitbench.gl.frame import Frame, Image, check_size
from oitbench.gl.uploaded_scene import UploadedScene
from oitbench.image import files
from oitbench.matrix.cell import choose_effects
from oitbench.method.ablation import REQUESTED
from oitbench.plugins import Collection


def render(
    scene: str,
    method: str,
    size: tuple[int, int] = (512, 512),
    ssaa: int = 2,
    effects: str = REQUESTED,
    collections: Iterable[Path | str] = (),
) -> tuple[Image, float]:
    """Render `scene` with `method`.

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

    Returns
    -------
    image : array, shape (h, w, 3), float32
        Linear Rec.709, top row first.
    exposure : float
        The scene's exposure in stops.

    Raises
    ------
    OitbenchError
        Something is unknown, out of range, or not available on this machine.
    """
    collection = Collection.load(map(Path, collections))
    chosen = collection.expand_methods([method])
    if len(chosen) != 1:
        raise UsageError(f"'{method}' selects {len(chosen)} methods; name one")
    described = collection.build_scene(scene)
    running = choose_effects(effects, described.effects) & chosen[0].shows
    fine = (size[0] * ssaa, size[1] * ssaa)
    with Device() as device:
        check_size(device, fine)
        with (
            UploadedScene(device, described) as uploaded,
            Frame(uploaded, chosen[0], fine, running) as frame,
        ):
            frame.render()
            image = files.box_downsample(frame.image(), ssaa)
    return image, described.exposure

"""Block means of the pictures of all cells, and the shaders that each cell compiles."""

from __future__ import annotations

import multiprocessing
from collections.abc import Iterable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from contextlib import ExitStack
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from oitbench.effects import Effect
from oitbench.errors import CapabilityError
from oitbench.gl.device import Device
from oitbench.gl.frame import Frame, Image
from oitbench.gl.uploaded_scene import UploadedScene
from oitbench.places import own_folder
from oitbench.plugins import Collection
from oitbench.scene import Scene
from oitbench.shading import read_shading
from tests.pictures.branches import Place, reached, recorded
from tests.pictures.cells import Cell, running
from tests.pictures.scenes import BLOCK, SCENES, SIZE

SHADOW_MAP = 256
"""Texels along each side of a light's depth maps."""
Means = tuple[float, ...] | None
"""Means of radiance and then of transmittance, over blocks from the top left and over channels.
None if the driver lacks a capability that the cell needs."""


@dataclass(frozen=True)
class Pictures:
    """Results of some cells.

    Parameters
    ----------
    renderer : str
    means : dict of str to Means
        By the cell's name.
    files : dict of str to frozenset of str
        Shaders that each cell includes, relative to the repository.
    branches : set of Place
        Branches of shaders that at least one cell reaches.
    """

    renderer: str
    means: dict[str, Means] = field(default_factory=dict)
    files: dict[str, frozenset[str]] = field(default_factory=dict)
    branches: set[Place] = field(default_factory=set)


def pictures(cells: Sequence[Cell], processes: int = 2) -> Pictures:
    """Return the pictures of cells, rendered by several processes."""
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(processes, mp_context=context) as pool:
        parts = list(pool.map(_pictures, [cells[k::processes] for k in range(processes)]))
    whole = Pictures(parts[0].renderer)
    for part in parts:
        whole.means.update(part.means)
        whole.files.update(part.files)
        whole.branches.update(part.branches)
    return whole


def _pictures(cells: Sequence[Cell]) -> Pictures:
    with Device() as device:
        found = Pictures(device.renderer)
        with recorded() as sources:
            analyzed: set[str] = set()
            for cell, means in means_of(device, cells):
                found.means[str(cell)] = means
                # Sources of programs that several cells share are assembled for each of them.
                found.files[str(cell)] = frozenset(
                    _file(name) for places in sources.values() for name in {p for p, _ in places}
                )
                for text in sources.keys() - analyzed:
                    found.branches.update((_file(p), n) for p, n in reached(text, sources[text]))
                analyzed |= sources.keys()
                sources.clear()
    return found


def _file(name: str) -> str:
    """Return the name of a shader, as a source has it, relative to the repository."""
    root = f"{own_folder()}/"
    return name.removeprefix(root)


def means_of(device: Device, cells: Iterable[Cell]) -> Iterator[tuple[Cell, Means]]:
    """Yield the means of each cell; cells of one scene should follow each other."""
    collection = Collection.load()
    kept, scene = ("", ""), None
    with ExitStack() as stack:
        for cell in cells:
            if scene is None or (cell.scene, cell.shading) != kept:
                stack.close()
                kept, scene = (cell.scene, cell.shading), SCENES[cell.scene]()
                settings = replace(read_shading(cell.shading), shadow_map=SHADOW_MAP)
                uploaded = stack.enter_context(UploadedScene(device, scene, settings))
            yield cell, _means(uploaded, scene, cell, collection)


def _means(uploaded: UploadedScene, scene: Scene, cell: Cell, collection: Collection) -> Means:
    (method,) = collection.expand_methods([cell.method])
    effects: Effect = running(cell, method, scene.effects)
    try:
        with Frame(uploaded, method, SIZE, effects) as frame:
            frame.render()
            light = block_means(frame.image())
            frame.render(transmittance=True)
            return (*light, *block_means(frame.image()))
    except CapabilityError:
        return None


def block_means(image: Image) -> tuple[float, ...]:
    """Return the means over blocks, row by row from the top left, of each channel."""
    rows, columns = image.shape[0] // BLOCK, image.shape[1] // BLOCK
    blocks = image.astype(np.float64).reshape(rows, BLOCK, columns, BLOCK, 3)
    return tuple(map(float, blocks.mean(axis=(1, 3)).ravel()))


def shaders(root: Path) -> list[Path]:
    """Return all shaders of the engine, of its kits and of the methods."""
    return sorted(p for kind in ("oitbench", "methods") for p in (root / kind).rglob("*.glsl"))

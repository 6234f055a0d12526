"""The benchmark matrix that a user asks for, checked and expanded to cells."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from oitbench import parameters as selectors
from oitbench.effects import Effect
from oitbench.errors import OitbenchError, UsageError
from oitbench.matrix.cell import Cell, choose_effects
from oitbench.method.ablation import EACH, REQUESTED, effects_axis
from oitbench.method.declaration import Method
from oitbench.plugins import Collection
from oitbench.results.schema import EXACT, PATH_TRACED


@dataclass(frozen=True)
class Preset:
    """Settings of a matrix.

    Parameters
    ----------
    size : (int, int)
        Width and height in pixels.
    grid : bool
        Run every parameter's grid, or only its default.
    rounds : int
        Largest number of timed rounds per scene; 0 for no timing.
    budget : float
        Seconds of timing per scene after which no further round begins.
    permutations : int
        Random orders of the draws in which every image is rendered again.
    every : bool
        Run all methods and scenes, or only those that are `quick`.
    path_traced : bool
        Score against path tracing too, or only against the exact truth.
    """

    size: tuple[int, int]
    grid: bool
    rounds: int
    budget: float
    permutations: int = 4
    every: bool = True
    path_traced: bool = True


PRESETS = {
    "quick": Preset((256, 256), grid=False, rounds=9, budget=4.0, every=False),
    "standard": Preset((512, 512), grid=True, rounds=15, budget=60.0, permutations=16),
    "paper": Preset((1280, 720), grid=True, rounds=31, budget=600.0, permutations=16),
    # For checks against a baseline: metrics and counts, which every run repeats.
    "guard": Preset((128, 128), grid=False, rounds=0, budget=0.0, path_traced=False),
}


@dataclass(frozen=True)
class Matrix:
    """Cells to run, and how.

    Parameters
    ----------
    cells : tuple of Cell
        Grouped by scene.
    preset : Preset
    out : Path
        The results folder.
    seed : int
    collections, method_folders : tuple of Path
        Sources of plugins that are not the suite's own.
    force : bool
        Run finished cells again.
    timeout : float, optional
        Seconds that one cell may take.
    workers : int
        Processes that render accuracy images at once; timing is never parallel.
    """

    cells: tuple[Cell, ...]
    preset: Preset
    out: Path
    seed: int = 1
    collections: tuple[Path, ...] = ()
    method_folders: tuple[Path, ...] = ()
    force: bool = False
    timeout: float | None = None
    workers: int = 1


def plan_matrix(
    scenes: Sequence[str] = (),
    methods: Sequence[str] = (),
    preset: str = "quick",
    size: tuple[int, int] | None = None,
    effects: Sequence[str] = (REQUESTED,),
    ssaa: int = 2,
    out: Path | str = "results",
    collections: Iterable[Path | str] = (),
    seed: int = 1,
    force: bool = False,
    timeout: float | None = None,
    workers: int = 1,
) -> Matrix:
    """Check a request and expand it to cells.

    Parameters
    ----------
    scenes, methods : sequence of str
        Selectors `NAME[param=v,w]`; a method may also be a folder's path. Default: all of the
        preset.
    preset : str
        A key of `PRESETS`.
    size : (int, int), optional
        Width and height in pixels. Default: that of the preset.
    effects : sequence of str
        An axis of the matrix: see `Cell.effects`. "each" selects "requested" and, for every
        effect that the scene requests and that changes the method's picture, "-name".
    ssaa : int
        Side of the sub-pixel grid of accuracy images.
    out : path
        The results folder.
    collections : iterable of path
        Further collection folders.
    seed, force, timeout, workers
        See `Matrix`.

    Raises
    ------
    UsageError
        Something is unknown or out of range.
    """
    if preset not in PRESETS:
        raise UsageError(f"unknown preset '{preset}'; choose from {', '.join(PRESETS)}")
    chosen = PRESETS[preset]
    size = size or chosen.size
    if min(*size, ssaa, workers) < 1:
        raise UsageError(
            f"size {size[0]}x{size[1]}, ssaa {ssaa} and workers {workers} must be at least 1"
        )
    if timeout is not None and not timeout > 0:
        raise UsageError(f"timeout is {timeout:g} s; it must be above 0")
    for text in effects:
        if text != EACH:
            choose_effects(text, Effect.NONE)
    folders = tuple(Path(folder) for folder in collections)
    collection = Collection.load(folders)
    scene_labels = collection.expand_scenes(scenes or _preset_scenes(collection, chosen))
    chosen_methods = collection.expand_methods(methods or _preset_methods(collection, chosen))
    truths = (EXACT, PATH_TRACED) if chosen.path_traced else (EXACT,)
    cells = tuple(
        Cell(scene, method.label, size, ssaa, effect, seed, chosen.permutations, truths)
        for scene in scene_labels
        for method, axis in _expand_effects(collection, scene, chosen_methods, effects)
        for effect in axis
    )
    return Matrix(
        cells, chosen, Path(out), seed, folders, _foreign_folders(chosen_methods, collection),
        force, timeout, workers,
    )  # fmt: skip


def _preset_scenes(collection: Collection, preset: Preset) -> list[str]:
    return [name for name, scene in collection.scenes.items() if preset.every or scene.quick]


def _preset_methods(collection: Collection, preset: Preset) -> list[str]:
    return [
        selectors.selector(name, selectors.grids(method.parameters) if preset.grid else {})
        for name, method in collection.methods.items()
        if preset.every or method.quick
    ]


def _expand_effects(
    collection: Collection, scene: str, methods: Sequence[Method], effects: Sequence[str]
) -> Iterator[tuple[Method, list[str]]]:
    """Yield every method with the values on its axis of effects in this scene."""
    requested = Effect.NONE
    if EACH in effects:
        # If the scene cannot be built, its cells report why.
        with suppress(OitbenchError):
            requested = collection.build_scene(scene).effects
    for method in methods:
        found: dict[str, None] = {}
        for text in effects:
            each = effects_axis(requested, method) if text == EACH else [text]
            found |= dict.fromkeys(each)
        yield method, list(found)


def _foreign_folders(methods: list[Method], collection: Collection) -> tuple[Path, ...]:
    """Return the folders of methods that were given by path."""
    paths = {m.name: collection.methods.path(m.name).parent for m in methods}
    inside = {folder / "methods" for folder in collection.folders}
    return tuple(sorted({p for p in paths.values() if p.parent not in inside}))

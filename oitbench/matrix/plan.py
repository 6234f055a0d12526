"""The benchmark matrix that a user asks for, checked and expanded to cells."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

from oitbench import parameters as selectors
from oitbench.catalog.catalog import LOAD_SECONDS, Catalog, Choice
from oitbench.effects import Effect
from oitbench.errors import UsageError, unknown
from oitbench.executors.places import Place
from oitbench.matrix.cell import Cell, choose_effects
from oitbench.measure.rounds import Schedule
from oitbench.method.ablation import EACH, REQUESTED
from oitbench.parameters import AnyParameter, Value
from oitbench.places import PluginFiles
from oitbench.shading import parse_shading
from oitbench.truths import EXACT, TRUTHS
from oitbench.views import MAIN
from oitbench.views import parse as parse_views

CELL_SECONDS = 1800.0
"""Time in which each step of a cell must end by default."""


@dataclass(frozen=True)
class Preset:
    """Settings of a matrix.

    Parameters
    ----------
    size : (int, int)
        Width and height in pixels.
    grid : {"default", "sweeps", "all"}
        Values of parameters that are run: defaults, also the grids that are sweeps, or all grids.
    rounds : int
        Largest number of timed rounds per scene; 0 for no timing.
    budget : float
        Seconds of timing per scene after which no further round begins.
    permutations : int
        Random orders of the draws in which every image is rendered again, at most.
    every : bool
        Run all methods and scenes, or only those that are `quick`.
    truths : tuple of str
        Keys of the truths to score against by default.
    grids : tuple of int
        Sides of the sub-pixel grids of accuracy images.
    traced_size : (int, int), optional
        Of stored references. Where its sub-pixels are the pixels of a cell, traced truths have this
        size, and not the cell's.
    most_layers : int, optional
        A method that draws the geometry once for each layer is skipped where more of them lie at
        one pixel: its time grows with their square. Default: no limit.
    values : mapping of str to tuple
        Values of parameters that are run; methods that lack one of these parameters are not.
    """

    size: tuple[int, int]
    grid: Literal["default", "sweeps", "all"]
    rounds: int
    budget: float
    permutations: int = 4
    every: bool = True
    truths: tuple[str, ...] = tuple(TRUTHS)
    grids: tuple[int, ...] = (2,)
    traced_size: tuple[int, int] | None = None
    most_layers: int | None = None
    values: Mapping[str, tuple[Value, ...]] = field(default_factory=dict)

    def reduces(self, size: tuple[int, int], grid: int) -> bool:
        """Return whether the pixels of cells are sub-pixels of the size of stored references."""
        wanted = self.traced_size
        return wanted is not None and size == (wanted[0] * grid, wanted[1] * grid) != wanted


PRESETS = {
    "quick": Preset((256, 256), grid="default", rounds=9, budget=4.0, every=False),
    "standard": Preset(
        (512, 512),
        grid="sweeps",
        rounds=15,
        budget=60.0,
        permutations=8,
        traced_size=(256, 256),
        most_layers=64,
    ),
    "paper": Preset((1280, 720), grid="all", rounds=31, budget=600.0, permutations=16),
    # For checks against a baseline: metrics and counts, which every run repeats.
    "guard": Preset((128, 128), grid="default", rounds=0, budget=0.0, truths=(EXACT,)),
    # Methods with random numbers over time. Sub-pixels multiply their samples, so they also run
    # without any.
    "noise": Preset(
        (256, 256),
        grid="default",
        rounds=0,
        budget=0.0,
        permutations=0,
        truths=(EXACT,),
        grids=(1, 2),
        values={"noise": ("white", "blue"), "frames": (1, 2, 4, 8, 16, 32, 64)},
    ),
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
    plugins : PluginFiles
        The files of all scenes, and of the methods of the cells.
    methods : tuple of str
        Names of all known methods.
    unusable : mapping of Cell to str
        Cells whose scene or method cannot be loaded, and why.
    force : bool
        Run finished cells again.
    timeout : float, optional
        Seconds that each step of a cell may take: building the scene, drawing, tracing.
    place : Place
        Where accuracy images are rendered; one of its workers times all cells.
    metrics : tuple of Path
        Files of metrics by which cells are scored, too.
    config : str
        Content of the file that repeats the run; empty for none.
    """

    cells: tuple[Cell, ...]
    preset: Preset
    out: Path
    seed: int = 1
    plugins: PluginFiles = field(default_factory=lambda: PluginFiles([]))
    methods: tuple[str, ...] = ()
    unusable: Mapping[Cell, str] = field(default_factory=dict)
    force: bool = False
    timeout: float | None = CELL_SECONDS
    place: Place = field(default_factory=Place)
    metrics: tuple[Path, ...] = ()
    config: str = ""

    @property
    def schedule(self) -> Schedule:
        """The rounds of timing."""
        return Schedule(self.preset.rounds, self.preset.budget, self.seed)

    @property
    def memory_limit(self) -> int:
        """Bytes that each process of this machine may use."""
        return self.place.memory_limit

    @property
    def workers(self) -> int:
        """Processes of this machine that render at once; its own process counts as one."""
        return max(1, self.place.workers)


def plan_matrix(
    scenes: Sequence[str] = (),
    methods: Sequence[str] = (),
    preset: str | Preset = "quick",
    size: tuple[int, int] | None = None,
    effects: Sequence[str] = (REQUESTED,),
    ssaa: int | None = None,
    out: Path | str = "results",
    collections: Iterable[Path | str] = (),
    seed: int = 1,
    force: bool = False,
    timeout: float | None = CELL_SECONDS,
    workers: int = 1,
    memory_gib: float | None = None,
    truths: Sequence[str] = (),
    shading: Sequence[str] = (),
    views: Sequence[str] = (MAIN,),
    metrics: Iterable[Path | str] = (),
    dask: str | None = None,
) -> Matrix:
    """Check a request and expand it to cells.

    Parameters
    ----------
    scenes, methods : sequence of str
        Selectors `NAME[param=v,w]`; a method may also be a folder's path. Default: all of the
        preset.
    preset : str or Preset
        A key of `PRESETS`, or settings of one's own.
    size : (int, int), optional
        Width and height in pixels. Default: that of the preset.
    effects : sequence of str
        An axis of the matrix: see `Cell.effects`. "each" selects "requested" and, for every
        effect that the scene requests and that changes the method's picture, "-name".
    ssaa : int, optional
        Side of the sub-pixel grid of accuracy images. Default: those of the preset.
    out : path
        The results folder.
    collections : iterable of path
        Further collection folders.
    seed, force, timeout
        See `Matrix`. Without a timeout, nothing ends a step that takes too long.
    workers, memory_gib, dask
        See `oitbench.executors.places.Place`.
    truths : sequence of str
        Keys of the truths to score against; the exact one is always among them. Default: those of
        the preset.
    shading : sequence of str
        Settings of shared shading, NAME=value,value each; all combinations are run.
    views : sequence of str
        NAME or NAME,NAME each: the cameras from which all scenes are seen; see `Scene.from_view`.
    metrics : iterable of path
        Files of metrics, as `oitbench.scoring.metric` describes them.

    Raises
    ------
    UsageError
        Something is unknown or out of range.
    """
    if isinstance(preset, str) and preset not in PRESETS:
        raise UsageError(f"unknown preset '{preset}'; choose from {', '.join(PRESETS)}")
    chosen = PRESETS[preset] if isinstance(preset, str) else preset
    size = size or chosen.size
    grids = chosen.grids if ssaa is None else (ssaa,)
    if min(*size, *grids) < 1:
        raise UsageError(f"size {size[0]}x{size[1]} and ssaa {min(grids)} must be at least 1")
    place = Place(workers, dask or "", memory_gib)
    for truth in truths:
        if truth not in TRUTHS:
            raise unknown("truth", truth, list(TRUTHS))
    if timeout is not None and not 0 < timeout < math.inf:
        raise UsageError(f"timeout is {timeout:g} s; give seconds above 0, or none for no limit")
    for text in effects:
        if text != EACH:
            choose_effects(text, Effect.NONE)
    shadings = [one.label for one in parse_shading(shading)]
    cameras = parse_views(views)
    seconds = LOAD_SECONDS if timeout is None else min(timeout, LOAD_SECONDS)
    wanted = (EXACT, *(truths or chosen.truths))
    kept = tuple(truth for truth in TRUTHS if truth in wanted)
    settings, traced = (seed, chosen.permutations, kept), kept != (EXACT,)
    with Catalog(collections, place.memory_limit, seconds) as catalog:
        chosen_scenes = catalog.expand_scenes(scenes or _preset_scenes(catalog, chosen))
        chosen_methods = catalog.expand_methods(methods or _preset_methods(catalog, chosen))
        pairs = [
            (
                Cell(
                    scene.label,
                    method.label,
                    size,
                    grid,
                    effect,
                    *settings,
                    one,
                    view,
                    traced and chosen.reduces(size, grid),
                    chosen.most_layers,
                ),
                scene.error or method.error,
            )
            for scene in chosen_scenes
            for view in cameras
            for one in shadings
            for grid in grids
            for method, axis in _expand_effects(catalog, scene, chosen_methods, effects, timeout)
            for effect in axis
        ]
    return Matrix(
        tuple(cell for cell, _ in pairs), chosen, Path(out), seed,
        catalog.places.files(method.name for method in chosen_methods),
        tuple(catalog.names("method")),
        {cell: error for cell, error in pairs if error}, force, timeout, place,
        tuple(map(Path, metrics)),
    )  # fmt: skip


def _preset_scenes(catalog: Catalog, preset: Preset) -> list[str]:
    names = catalog.names("scene")
    return [name for name in names if preset.every or catalog.entry("scene", name).quick]


def _preset_methods(catalog: Catalog, preset: Preset) -> list[str]:
    entries = [catalog.entry("method", name) for name in catalog.names("method")]
    chosen = [
        entry
        for entry in entries
        if (preset.every or entry.quick) and preset.values.keys() <= entry.parameters.keys()
    ]
    return [selectors.selector(entry.name, _values(entry.parameters, preset)) for entry in chosen]


def _values(
    parameters: Mapping[str, AnyParameter], preset: Preset
) -> Mapping[str, tuple[Value, ...]]:
    """Return the values of parameters that a preset runs beside their defaults."""
    if preset.grid == "all":
        return selectors.grids(parameters)
    return selectors.sweeps(parameters) if preset.grid == "sweeps" else preset.values


def _expand_effects(
    catalog: Catalog,
    scene: Choice,
    methods: Sequence[Choice],
    effects: Sequence[str],
    timeout: float | None,
) -> Iterator[tuple[Choice, list[str]]]:
    """Yield every method with the values on its axis of effects in this scene."""
    each = catalog.effects_axes(scene, methods, timeout) if EACH in effects else {}
    for method in methods:
        found: dict[str, None] = {}
        for text in effects:
            axis = each.get(method.label, [REQUESTED]) if text == EACH else [text]
            found |= dict.fromkeys(axis)
        yield method, list(found)

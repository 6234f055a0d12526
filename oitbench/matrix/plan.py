"""The benchmark matrix that a user asks for, checked and expanded to cells."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from oitbench import parameters as selectors
from oitbench.catalog.catalog import LOAD_SECONDS, Catalog, Choice
from oitbench.effects import Effect
from oitbench.errors import UsageError, unknown
from oitbench.matrix.cell import Cell, choose_effects
from oitbench.measure.rounds import Schedule
from oitbench.method.ablation import EACH, REQUESTED
from oitbench.parameters import Value
from oitbench.places import PluginFiles
from oitbench.shading import parse_shading
from oitbench.truths import EXACT, TRUTHS
from oitbench.views import MAIN
from oitbench.views import parse as parse_views
from oitbench.workers import memory

CELL_SECONDS = 1800.0
"""Time in which each step of a cell must end by default."""


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
    truths : tuple of str
        Keys of the truths to score against by default.
    grids : tuple of int
        Sides of the sub-pixel grids of accuracy images.
    values : mapping of str to tuple
        Values of parameters that are run; methods that lack one of these parameters are not.
    """

    size: tuple[int, int]
    grid: bool
    rounds: int
    budget: float
    permutations: int = 4
    every: bool = True
    truths: tuple[str, ...] = tuple(TRUTHS)
    grids: tuple[int, ...] = (2,)
    values: Mapping[str, tuple[Value, ...]] = field(default_factory=dict)


PRESETS = {
    "quick": Preset((256, 256), grid=False, rounds=9, budget=4.0, every=False),
    "standard": Preset((512, 512), grid=True, rounds=15, budget=60.0, permutations=16),
    "paper": Preset((1280, 720), grid=True, rounds=31, budget=600.0, permutations=16),
    # For checks against a baseline: metrics and counts, which every run repeats.
    "guard": Preset((128, 128), grid=False, rounds=0, budget=0.0, truths=(EXACT,)),
    # Methods with random numbers over time. Sub-pixels multiply their samples, so they also run
    # without any.
    "noise": Preset(
        (256, 256),
        grid=False,
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
    workers : int
        Processes that render accuracy images at once; timing is never parallel.
    memory_limit : int
        Bytes that each of these processes may use.
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
    workers: int = 1
    memory_limit: int = field(default_factory=lambda: memory.share(1))
    metrics: tuple[Path, ...] = ()
    config: str = ""

    @property
    def schedule(self) -> Schedule:
        """The rounds of timing."""
        return Schedule(self.preset.rounds, self.preset.budget, self.seed)


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
    seed, force, timeout, workers
        See `Matrix`. Without a timeout, nothing ends a step that takes too long.
    memory_gib : float, optional
        Memory that one worker may use, in GiB. Default: 75 % of the machine's, divided by the
        number of workers.
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
    if min(*size, *grids, workers) < 1:
        raise UsageError(
            f"size {size[0]}x{size[1]}, ssaa {min(grids)} and workers {workers} must be at least 1"
        )
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
    limit = memory.limit(memory_gib, workers)
    seconds = LOAD_SECONDS if timeout is None else min(timeout, LOAD_SECONDS)
    wanted = (EXACT, *(truths or chosen.truths))
    kept = tuple(truth for truth in TRUTHS if truth in wanted)
    settings = (seed, chosen.permutations, kept)
    with Catalog(collections, limit, seconds) as catalog:
        chosen_scenes = catalog.expand_scenes(scenes or _preset_scenes(catalog, chosen))
        chosen_methods = catalog.expand_methods(methods or _preset_methods(catalog, chosen))
        pairs = [
            (Cell(scene.label, method.label, size, grid, effect, *settings, one, view), error)
            for scene in chosen_scenes
            for view in cameras
            for one in shadings
            for grid in grids
            for method, axis in _expand_effects(catalog, scene, chosen_methods, effects, timeout)
            for effect in axis
            for error in [scene.error or method.error]
        ]
    return Matrix(
        tuple(cell for cell, _ in pairs), chosen, Path(out), seed,
        catalog.places.files(method.name for method in chosen_methods),
        tuple(catalog.names("method")),
        {cell: error for cell, error in pairs if error}, force, timeout, workers,
        limit, tuple(map(Path, metrics)),
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
    return [
        selectors.selector(
            entry.name,
            selectors.grids(entry.parameters) if preset.grid else preset.values,
        )
        for entry in chosen
    ]


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

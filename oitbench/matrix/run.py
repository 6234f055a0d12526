"""The benchmark matrix: which cells there are, which are still to be done, and doing them."""

from __future__ import annotations

import sys
import threading
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from queue import Queue
from typing import Any

from oitbench import parameters as selector
from oitbench.effects import Effect
from oitbench.errors import OitbenchError, UsageError
from oitbench.matrix import machine as environment
from oitbench.matrix.cell import Cell, choose_effects
from oitbench.matrix.worker import Message, WorkerError, WorkerProcess, to_message
from oitbench.method import ablation
from oitbench.method.declaration import Method
from oitbench.parameters import Parameter
from oitbench.plugins import Collection
from oitbench.results.store import Record, Store

Report = Callable[[Cell, Record], None]


@dataclass(frozen=True)
class Preset:
    """A matrix to choose when nothing is named.

    Parameters
    ----------
    size : (int, int)
        Width and height in pixels.
    grid : bool
        Every parameter's grid, or its default alone.
    rounds : int
        Timed frames a variant at most; with 0 nothing is timed.
    budget : float
        Seconds of timing a scene after which no further round begins.
    permutations : int
        Random orders of the draws in which every image is rendered once more.
    every : bool
        Every method and scene there is, or those alone that are `quick`.
    path_traced : bool
        Whether cells are held against path tracing too, or against the exact truth alone.
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
    # What a check for regressions needs: metrics and counts, which every run repeats.
    "guard": Preset((128, 128), grid=False, rounds=0, budget=0.0, path_traced=False),
}


@dataclass(frozen=True)
class Plan:
    """A run that was asked for, checked and expanded.

    Parameters
    ----------
    cells : tuple of Cell
        Grouped by scene.
    collections, method_folders : tuple of Path
        Where plugins that are not the suite's own come from.
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


@dataclass
class Outcome:
    """How a run ended: records by status, cells found finished, and where the wall time went."""

    statuses: dict[str, int] = field(default_factory=dict)
    kept: int = 0
    wall: float = 0.0
    spent: dict[str, float] = field(default_factory=dict)

    @property
    def rest(self) -> float:
        """Seconds that are neither rendering, metrics nor references."""
        return max(0.0, self.wall - sum(self.spent.values()))

    def __str__(self) -> str:
        done = ", ".join(f"{count} {status}" for status, count in sorted(self.statuses.items()))
        split = ", ".join(
            f"{kind} {self.spent.get(kind, 0.0):.1f} s"
            for kind in ("rendering", "metrics", "references")
        )
        return (
            f"{done or 'nothing to do'}; {self.kept} kept from before;"
            f" {self.wall:.1f} s: {split}, rest {self.rest:.1f} s"
        )


def plan(
    scenes: Sequence[str] = (),
    methods: Sequence[str] = (),
    preset: str = "quick",
    size: tuple[int, int] | None = None,
    effects: Sequence[str] = ("called",),
    ssaa: int = 2,
    out: Path | str = "results",
    collections: Iterable[Path | str] = (),
    seed: int = 1,
    force: bool = False,
    timeout: float | None = None,
    workers: int = 1,
) -> Plan:
    """Check what was asked for, and expand it to cells.

    Parameters
    ----------
    scenes, methods : sequence of str
        `NAME[param=v,w]`; all there are without. A method may also be a folder's path.
    preset : str
        "quick", "standard", "paper" or "guard".
    size : (int, int), optional
        Instead of the preset's.
    effects : sequence of str
        An axis of the matrix: see `Cell.effects`. "each" stands for "called" and, for every effect
        that the scene calls for and the method draws differently without, "-name".
    ssaa : int
        Side of the sub-pixel grid of accuracy images.
    out : path
        The results folder.
    collections : iterable of path
        Extra collection folders.
    timeout : float, optional
        Seconds that one cell may take.
    workers : int
        Processes that render accuracy images at once; timing is never parallel.

    Raises
    ------
    UsageError
        For whatever is unknown or out of range.
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
        if text != ablation.EACH:
            choose_effects(text, Effect.NONE)
    folders = tuple(Path(folder) for folder in collections)
    collection = Collection.load(folders)
    scene_labels = collection.expand_scenes(scenes or _all_scenes(collection, chosen))
    chosen_methods = collection.expand_methods(methods or _all_methods(collection, chosen))
    cells = tuple(
        Cell(scene, method.label, size, ssaa, effect, seed, chosen.permutations)
        for scene in scene_labels
        for method, axis in _effects_axis(collection, scene, chosen_methods, effects)
        for effect in axis
    )
    return Plan(
        cells, chosen, Path(out), seed, folders, _folders(chosen_methods, collection),
        force, timeout, workers,
    )  # fmt: skip


def _all_scenes(collection: Collection, preset: Preset) -> list[str]:
    return [name for name, scene in collection.scenes.items() if preset.every or scene.quick]


def _effects_axis(
    collection: Collection, scene: str, methods: Sequence[Method], effects: Sequence[str]
) -> Iterator[tuple[Method, list[str]]]:
    """Yield every method with its effects in this scene, each of them once."""
    called = Effect.NONE
    if ablation.EACH in effects:
        # Why a scene cannot be built is told by its cells.
        with suppress(OitbenchError):
            called = collection.build_scene(scene).effects
    for method in methods:
        found: dict[str, None] = {}
        for text in effects:
            each = text == ablation.EACH
            found |= dict.fromkeys(ablation.variants(called, method) if each else [text])
        yield method, list(found)


def _all_methods(collection: Collection, preset: Preset) -> list[str]:
    texts = []
    for name, method in collection.methods.items():
        if preset.every or method.quick:
            texts.append(name + _grid_text(method.parameters if preset.grid else {}))
    return texts


def _grid_text(parameters: Mapping[str, Parameter]) -> str:
    axes = [
        f"{key}={','.join(selector.text(value) for value in parameter.grid)}"
        for key, parameter in parameters.items()
        if parameter.grid
    ]
    return f"[{','.join(axes)}]" if axes else ""


def _folders(methods: list[Method], collection: Collection) -> tuple[Path, ...]:
    """Return the folders of methods that were given by path."""
    paths = {m.name: collection.methods.path(m.name).parent for m in methods}
    inside = {folder / "methods" for folder in collection.folders}
    return tuple(sorted({p for name, p in paths.items() if p.parent not in inside}))


def run(asked: Plan, report: Report = lambda cell, record: None) -> Outcome:
    """Do all cells of a plan that are not finished yet; each is on the disk when it is done.

    Parameters
    ----------
    asked : Plan
    report : callable
        Told of every record as it comes.

    Raises
    ------
    UsageError
        The results folder cannot be used.
    CapabilityError
        There is no OpenGL here.
    """
    start = time.perf_counter()
    outcome = Outcome()
    store = Store.open(asked.out)
    pool = [
        WorkerProcess(asked.collections, asked.method_folders, asked.out)
        for _ in range(asked.workers)
    ]
    try:
        facts = _facts(asked, pool[0].ask({"verb": "hello"}, None))
        store.write_run(facts)
        todo = [cell for cell in asked.cells if asked.force or not _rendered(store, cell)]
        outcome.kept = len(asked.cells) - len(todo)
        _render_all(todo, pool, asked, store, outcome, report)
        for extra in pool[1:]:
            extra.stop()
        if asked.preset.rounds:
            _time_all(asked, pool[0], store, outcome, set(todo))
        for cell in todo:
            record = store.find(cell.key)
            status = record["status"] if record else "failed"
            outcome.statuses[status] = outcome.statuses.get(status, 0) + 1
        store.compact()
        outcome.wall = time.perf_counter() - start
        wall = {"seconds": outcome.wall, "rest": outcome.rest, **outcome.spent}
        store.write_run({**facts, "wall": wall})
    finally:
        for worker in pool:
            worker.stop()
    return outcome


def execute(
    scenes: Sequence[str] = (),
    methods: Sequence[str] = (),
    preset: str = "quick",
    size: tuple[int, int] | None = None,
    out: Path | str = "results",
    **options: Any,
) -> Outcome:
    """Plan and run a matrix in one call: `oitbench.run`.

    Parameters
    ----------
    scenes, methods, preset, size, out
        As in `plan`, as are all further options.
    """
    return run(plan(scenes, methods, preset, size, out=out, **options))


def _facts(asked: Plan, hello: Message) -> Record:
    names = list(Collection.load(asked.collections).methods)
    return environment.collect(hello["gl"], argv=sys.argv, seed=asked.seed, methods=names)


def _rendered(store: Store, cell: Cell) -> bool:
    record = store.find(cell.key)
    return record is not None and record["status"] in ("ok", "unstable", "skipped")


def _render_all(
    todo: list[Cell],
    pool: list[WorkerProcess],
    asked: Plan,
    store: Store,
    outcome: Outcome,
    report: Report,
) -> None:
    """Spread scenes over the workers; a scene stays with one, which then uploads it once."""
    scenes: dict[str, list[Cell]] = {}
    for cell in todo:
        scenes.setdefault(cell.scene, []).append(cell)
    finished: Queue[tuple[Cell, Message] | BaseException] = Queue()
    free: Queue[WorkerProcess] = Queue()
    for worker in pool:
        free.put(worker)
    stopped = threading.Event()

    def render_scene(cells: list[Cell]) -> None:
        worker = free.get()
        try:
            for cell in cells:
                if not stopped.is_set():
                    finished.put((cell, _render(worker, cell, asked)))
        except BaseException as error:
            finished.put(error)
        finally:
            free.put(worker)

    with ThreadPoolExecutor(len(pool)) as threads:
        for cells in scenes.values():
            threads.submit(render_scene, cells)
        try:
            for _ in todo:
                item = finished.get()
                if isinstance(item, BaseException):
                    raise item
                cell, reply = item
                store.append(reply["record"])
                _add(outcome.spent, reply["spent"])
                report(cell, reply["record"])
        except BaseException:
            # Who stops a run, or a bug that ends it, must not wait for cells that nobody wants.
            stopped.set()
            for worker in pool:
                worker.stop()
            raise


def _render(worker: WorkerProcess, cell: Cell, asked: Plan) -> Message:
    try:
        message = {"verb": "run", "cell": to_message(cell)}
        return worker.ask({**message, "path_traced": asked.preset.path_traced}, asked.timeout)
    except WorkerError as error:
        status = "timeout" if error.timeout else "failed"
        record = {**cell.head(), "status": status, "reason": str(error)}
    except OitbenchError as error:
        record = {**cell.head(), "status": "failed", "reason": str(error)}
    return {"record": record, "spent": {}}


def _time_all(
    asked: Plan, worker: WorkerProcess, store: Store, outcome: Outcome, fresh: set[Cell]
) -> None:
    """Time the rendered cells of each scene together, if one of them has no time yet."""
    scenes: dict[tuple[str, tuple[int, int]], list[Cell]] = {}
    for cell in asked.cells:
        record = store.find(cell.key)
        if record is not None and record["status"] in ("ok", "unstable"):
            scenes.setdefault((cell.scene, cell.size), []).append(cell)
    for cells in scenes.values():
        known = [store.find(cell.key) for cell in cells]
        if all(record and record["time"] for record in known) and not fresh & set(cells):
            continue
        message = {
            "verb": "time",
            "cells": [to_message(cell) for cell in cells],
            "rounds": asked.preset.rounds,
            "budget": asked.preset.budget,
        }
        limit = None if asked.timeout is None else asked.timeout * len(cells)
        try:
            reply = worker.ask(message, limit)
        except (WorkerError, OitbenchError) as error:
            for record in known:
                store.append({**(record or {}), "time": None, "reason": f"not timed: {error}"})
            continue
        _add(outcome.spent, reply["spent"])
        for record, facts in zip(known, reply["times"], strict=True):
            store.append({**(record or {}), "time": facts})


def _add(total: dict[str, float], more: dict[str, float]) -> None:
    for kind, seconds in more.items():
        total[kind] = total.get(kind, 0.0) + seconds

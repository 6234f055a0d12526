"""One cell of the matrix: a scene, a method and a frame size, from names to a record."""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from oitbench.effects import Effect, names
from oitbench.errors import CapabilityError, OitbenchError, UsageError, unknown
from oitbench.gl.device import Device
from oitbench.gl.draws.steps import PassRecord
from oitbench.gl.frame import Frame, Image, check_size
from oitbench.gl.geometry import Geometry
from oitbench.image import files as images
from oitbench.image import metrics
from oitbench.measure import accounting, timing
from oitbench.method.ablation import leave_out
from oitbench.method.declaration import Method
from oitbench.plugins import Collection
from oitbench.results.store import CellKey, Record, image_path
from oitbench.scene import Scene

_LEFT_OUT = "left out of this run"


@dataclass(frozen=True)
class Cell:
    """What is to be rendered, in names alone, so that it can travel to another process.

    Parameters
    ----------
    scene, method : str
        Canonical labels.
    size : (int, int)
        Width and height of the image in pixels.
    ssaa : int
        Side of the sub-pixel grid of accuracy images; cost is measured without sub-pixels.
    effects : str
        "called", "all", "none", or names to leave out, as in "-diffusion,-refraction"; with each
        goes what means nothing without it (`oitbench.ablation.NEEDS`).
    seed : int
    permutations : int
        Random orders of the draws in which the image is rendered once more, without sub-pixels, to
        see how far it depends on them.
    """

    scene: str
    method: str
    size: tuple[int, int]
    ssaa: int = 2
    effects: str = "called"
    seed: int = 1
    permutations: int = 4

    @property
    def variant(self) -> dict[str, Any]:
        """What else tells this cell from others of the same scene, method and size."""
        return {"ssaa": self.ssaa, "effects": self.effects}

    @property
    def key(self) -> CellKey:
        """The cell's place in a store."""
        return CellKey.of(self.head())

    def head(self) -> Record:
        """Return the part of the record that is known before anything is rendered."""
        return {
            "scene": self.scene,
            "method": self.method,
            "name": self.method.partition("[")[0],
            "size": list(self.size),
            "variant": self.variant,
            "seed": self.seed,
        }


def choose_effects(text: str, called: Effect) -> Effect:
    """Return the effects that `text` asks for; see `Cell.effects`."""
    everything = ~Effect.NONE
    if text in ("called", "all", "none"):
        return {"called": called, "all": everything, "none": Effect.NONE}[text]
    chosen = called
    for part in text.split(","):
        name = part.strip().removeprefix("-").upper()
        if not part.strip().startswith("-"):
            raise UsageError(f"effects '{text}': give called, all, none, or -NAME to leave one out")
        if name not in Effect.__members__:
            raise unknown("effect", name.lower(), [e.lower() for e in Effect.__members__])
        chosen = leave_out(chosen, Effect[name])
    return chosen


@dataclass
class Stopwatch:
    """Seconds spent by kind of work: "rendering", "metrics", "references"."""

    spent: dict[str, float] = field(default_factory=dict)

    @contextmanager
    def running(self, kind: str) -> Iterator[None]:
        """Add the time spent inside to `kind`."""
        start = time.perf_counter()
        try:
            yield
        finally:
            self.spent[kind] = self.spent.get(kind, 0.0) + time.perf_counter() - start

    def take(self) -> dict[str, float]:
        """Return what was spent, and begin anew."""
        spent, self.spent = self.spent, {}
        return spent


@dataclass(frozen=True)
class _Stage:
    """A scene on the device with its exact truth: what the cells of one scene and size share."""

    label: str
    size: tuple[int, int]
    ssaa: int
    scene: Scene
    geometry: Geometry
    exact: Image
    exact_transmittance: Image


class Bench:
    """Renders cells, one after another, keeping what consecutive ones share.

    Parameters
    ----------
    collection : Collection
    folder : Path
        The results folder; images are written below it.
    """

    def __init__(self, collection: Collection, folder: Path) -> None:
        self.collection, self.folder = collection, folder
        self.device = Device()
        self.watch = Stopwatch()
        self._stage: _Stage | None = None

    def run(self, cell: Cell, path_traced: bool = True) -> Record:
        """Render one cell; an error that belongs to it becomes a record that gives the reason.

        Parameters
        ----------
        cell : Cell
        path_traced : bool
            Whether to hold it against path tracing too, or against the exact truth alone.
        """
        start = time.perf_counter()
        try:
            record = self._run(cell, path_traced)
        except CapabilityError as error:
            record = {**cell.head(), "status": "skipped", "reason": str(error)}
        except OitbenchError as error:
            record = {**cell.head(), "status": "failed", "reason": str(error)}
        return {**record, "seconds": time.perf_counter() - start}

    def _run(self, cell: Cell, path_traced: bool) -> Record:
        (method,) = self.collection.expand_methods([cell.method])
        fine = (cell.size[0] * cell.ssaa, cell.size[1] * cell.ssaa)
        check_size(self.device, fine)
        stage = self._prepare(cell)
        scene = stage.scene
        called = choose_effects(cell.effects, scene.effects)
        effects = called & method.shows
        with self.watch.running("rendering"):
            image, transmittance, complexity = self._accurate(stage, method, fine, effects, cell)
            cost = self._cost(stage.geometry, method, cell.size, effects)
            spread = self._order_spread(stage.geometry, method, cell, effects)
        relative = image_path(cell.key, "color")
        images.write_exr(self.folder / relative, image)
        nonfinite = metrics.count_nonfinite(image)
        with self.watch.running("metrics"):
            exact = metrics.compare(stage.exact, image, scene.exposure).values
            exact[metrics.TRANSMITTANCE] = metrics.rmse_transmittance(
                stage.exact_transmittance, transmittance
            )
        exact |= spread
        scores, traced_image = (
            self._path_traced(cell, scene, image) if path_traced else ({"reason": _LEFT_OUT}, {})
        )
        return {
            **cell.head(),
            "params": method.values,
            "status": "unstable" if any(nonfinite.values()) else "ok",
            "reason": _told(nonfinite),
            "effects": {
                "called": names(called & scene.effects),
                "expressed": names(effects),
                "missing": names(called & scene.effects & ~method.shows),
            },
            "max_depth_complexity": complexity,
            **cost,
            "time": None,
            "nonfinite": nonfinite,
            "metrics": {"exact": exact, "path_traced": scores},
            "images": {
                "color": relative,
                "exact": self._shared_image(cell, "exact"),
                **traced_image,
            },
            "exposure": scene.exposure,
        }

    def _prepare(self, cell: Cell) -> _Stage:
        """Return the stage of the cell's scene, kept while scene and size stay the same."""
        wanted = (cell.scene, cell.size, cell.ssaa)
        stage = self._stage
        if stage is not None and (stage.label, stage.size, stage.ssaa) == wanted:
            return stage
        if stage is not None:
            self._stage = None
            stage.geometry.release()
        with self.watch.running("rendering"):
            scene = self.collection.build_scene(cell.scene)
            geometry = Geometry(self.device, scene)
            truth = self.collection.truth()
            fine = (cell.size[0] * cell.ssaa, cell.size[1] * cell.ssaa)
            frame = Frame(self.device, geometry, truth, fine, scene.effects & truth.shows)
            exact, transmittance = _both(frame, cell.ssaa)
            frame.release()
        images.write_exr(self.folder / self._shared_image(cell, "exact"), exact)
        self._stage = _Stage(
            cell.scene, cell.size, cell.ssaa, scene, geometry, exact, transmittance
        )
        return self._stage

    @staticmethod
    def _shared_image(cell: Cell, kind: str) -> str:
        """Return the path of an image that all methods of the cell's scene share."""
        return image_path(CellKey(cell.scene, "", cell.size, f"ssaa {cell.ssaa}"), kind)

    def _accurate(
        self, stage: _Stage, method: Method, fine: tuple[int, int], effects: Effect, cell: Cell
    ) -> tuple[Image, Image, int]:
        frame = Frame(self.device, stage.geometry, method, fine, effects)
        image, transmittance = _both(frame, cell.ssaa)
        complexity = int(frame.complexity.max())
        frame.release()
        return image, transmittance, complexity

    def _cost(
        self, geometry: Geometry, method: Method, size: tuple[int, int], effects: Effect
    ) -> Record:
        """Count one frame without sub-pixels: fragments, memory, traffic."""
        frame = Frame(self.device, geometry, method, size, effects, counted=bool(method.buffers))
        frame.render()
        records: list[PassRecord] = []
        frame.issue(records)
        terms = accounting.traffic(frame, records)
        cost: Record = {
            "fragments": int(frame.complexity.sum()),
            "passes": [{"name": record.name, "runs": record.runs} for record in records],
            "memory": accounting.memory(frame),
            "traffic": {
                "bytes": sum(term.bytes for term in terms),
                "terms": [term.facts() for term in terms],
            },
            "shading": accounting.shading(frame),
        }
        frame.release()
        return cost

    def _order_spread(
        self, geometry: Geometry, method: Method, cell: Cell, effects: Effect
    ) -> dict[str, float | None]:
        frame = Frame(self.device, geometry, method, cell.size, effects)

        def permuted() -> Iterator[Image]:
            for number in range(1, cell.permutations + 1):
                frame.render(permutation=number)
                yield frame.image()

        spread = metrics.order_spread(permuted())
        frame.release()
        return spread

    def _path_traced(self, cell: Cell, scene: Scene, image: Image) -> tuple[Record, dict[str, str]]:
        """Hold the image against the path-traced truth, or say why there is none."""
        from oitbench.path_traced.references.lookup import find_or_render

        try:
            with self.watch.running("references"):
                reference = find_or_render(
                    scene, cell.scene, cell.size, cell.ssaa, self.collection.folders
                )
        except CapabilityError as error:
            return {"reason": str(error)}, {}
        path = self._shared_image(cell, "path_traced")
        images.write_exr(self.folder / path, reference.mean)
        with self.watch.running("metrics"):
            scores: Record = dict(metrics.compare(reference.mean, image, scene.exposure).values)
        scores["noise_floor"] = reference.info.noise_floor
        if reference.message:
            scores["message"] = reference.message
        return scores, {"path_traced": path}

    def time(self, cells: Sequence[Cell], rounds: int, budget: float) -> list[Record]:
        """Time the cells of one scene against each other; return each one's `time`, in order."""
        frames: dict[str, Frame] = {}
        geometry: Geometry | None = None
        with self.watch.running("rendering"):
            scene = self.collection.build_scene(cells[0].scene)
            geometry = Geometry(self.device, scene)
            for cell in cells:
                (method,) = self.collection.expand_methods([cell.method])
                effects = choose_effects(cell.effects, scene.effects) & method.shows
                frame = Frame(self.device, geometry, method, cell.size, effects)
                frame.render()
                frames[str(cell.key)] = frame
            timings = timing.measure(frames, rounds, budget, cells[0].seed)
            facts = []
            for cell in cells:
                frame = frames[str(cell.key)]
                records: list[PassRecord] = []
                frame.issue(records, check=False)
                facts.append(
                    {
                        **timings[str(cell.key)].facts(),
                        "shading": [_passed(record) for record in frame.shading_records],
                        "passes": [_passed(record) for record in records],
                    }
                )
            for frame in frames.values():
                frame.release()
            geometry.release()
        return facts


def _both(frame: Frame, ssaa: int) -> tuple[Image, Image]:
    """Render the image and the transmittance alone, averaged over sub-pixels."""
    frame.render()
    image = images.box_downsample(frame.image(), ssaa)
    frame.render(transmittance=True)
    transmittance = images.box_downsample(frame.image(), ssaa)
    return image, transmittance


def _passed(record: PassRecord) -> Record:
    return {"name": record.name, "ms": record.milliseconds, "fragments": record.fragments}


def _told(nonfinite: dict[str, int]) -> str:
    bad = [f"{count} {kind}" for kind, count in nonfinite.items() if count]
    return f"pixels: {', '.join(bad)}" if bad else ""

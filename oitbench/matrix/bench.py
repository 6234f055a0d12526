"""Renders, scores and times cells, keeping the objects that consecutive cells share."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field
from pathlib import Path

from oitbench.effects import Effect, names
from oitbench.errors import CapabilityError, DeclarationError, OitbenchError, StorageError
from oitbench.gl.device import Device
from oitbench.gl.frame import Frame, Image, check_size
from oitbench.gl.plan import FramePlan
from oitbench.gl.uploaded_scene import UploadedScene
from oitbench.image import files, metrics, stored
from oitbench.image.files import Channels
from oitbench.image.stored import StoredImage
from oitbench.matrix.cell import Cell, choose_effects
from oitbench.matrix.identity import Identities
from oitbench.matrix.stage import Stage, with_transmittance
from oitbench.matrix.timed_cells import ScoredCell, Timing, time_cells
from oitbench.measure import accounting
from oitbench.measure.rounds import Schedule
from oitbench.method.declaration import Method
from oitbench.plugins import Collection
from oitbench.results.schema import (
    EXACT,
    PATH_TRACED,
    EffectNames,
    Fingerprints,
    Memory,
    Nonfinite,
    Outcome,
    PassRuns,
    Record,
    Renderer,
    Scores,
    SharedShading,
    Status,
    Traffic,
    flip_image,
)
from oitbench.results.store import IMAGES
from oitbench.scene import Scene
from oitbench.workers.messages import Step

_LEFT_OUT = "left out of this run"
_BUILDING = Step("building the scene", shared=True)
_DRAWING_TRUTH = Step("drawing the exact truth", shared=True)
_DRAWING = Step("drawing and scoring the picture")
_PATH_TRACING = Step("path tracing the scene", shared=True)
_TIMING = Step("timing the scene")
_CHANGED = Timing(reason="its files changed during the run; run again")


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
        """Return the seconds since the last call."""
        spent, self.spent = self.spent, {}
        return spent


@dataclass(frozen=True)
class _Cost:
    """Counts of one frame without sub-pixels."""

    fragments: int
    passes: list[PassRuns]
    memory: Memory
    traffic: Traffic
    shading: SharedShading


class Bench:
    """Renders cells one after another; a context manager.

    Parameters
    ----------
    collection : Collection
    folder : Path
        The results folder, below which images are written.
    on_step : callable
        Called when a part of the work begins that may take long.
    """

    def __init__(
        self,
        collection: Collection,
        folder: Path,
        on_step: Callable[[Step], None] = lambda step: None,
    ) -> None:
        self.collection, self.folder, self._on_step = collection, folder, on_step
        self.device = Device()
        self.watch = Stopwatch()
        self.identities = Identities(collection, lambda: on_step(_BUILDING))
        self._stage: Stage | None = None

    def __enter__(self) -> Bench:
        return self

    def __exit__(self, *error: object) -> None:
        self.leave_scene()
        self.device.release()

    @property
    def gl(self) -> Renderer:
        """The renderer."""
        device = self.device
        vendor = str(device.context.info["GL_VENDOR"])
        return Renderer(device.renderer, vendor, device.version, device.software)

    def leave_scene(self) -> None:
        """Free the scene that is kept for further cells."""
        if self._stage is not None:
            stage, self._stage = self._stage, None
            stage.uploaded.release()

    def run(self, cell: Cell) -> Record:
        """Render and score one cell; an error that belongs to the cell becomes its reason.

        Raises
        ------
        StorageError
            An image cannot be written, which is not the cell's fault.
        """
        start = time.perf_counter()
        fingerprints: Fingerprints | None = None
        outcome: Outcome | None = None
        status: Status = "ok"
        reason = ""
        try:
            (method,) = self.collection.expand_methods([cell.method])
            fingerprints = self.identities.of(cell, method)
            outcome = self._run(cell, method)
            self.identities.check_unchanged(method)
        except StorageError:
            raise
        except CapabilityError as error:
            status, reason = "skipped", str(error)
        except OitbenchError as error:
            status, reason, outcome = "failed", str(error), None
        else:
            reason = _unstable_pixels(outcome.nonfinite)
            status = "unstable" if reason else "ok"
        record = cell.record(
            status,
            reason,
            seconds=time.perf_counter() - start,
            gl=self.gl,
            fingerprints=fingerprints,
            outcome=outcome,
        )
        drawn = outcome is None or outcome.max_depth_complexity > 0
        return record if drawn else _without_fragments(record, self.identities.scene(cell.scene))

    def _run(self, cell: Cell, method: Method) -> Outcome:
        fine = (cell.size[0] * cell.ssaa, cell.size[1] * cell.ssaa)
        check_size(self.device, fine)
        stage = self._prepare(cell)
        self._on_step(_DRAWING)
        scene, uploaded = stage.scene, stage.uploaded
        requested = choose_effects(cell.effects, scene.effects)
        effects = requested & method.shows
        with self.watch.running("rendering"):
            with Frame(uploaded, method, fine, effects) as frame:
                image, transmittance = with_transmittance(frame, cell.ssaa)
                complexity, plan = int(frame.complexity.max()), frame.plan
            cost = _count(uploaded, method, cell.size, effects, plan)
            spread = _order_spread(uploaded, method, cell, effects, plan)
        images = {"color": self._store("color", files.image_channels(image))}
        exact = self._score(EXACT, stage, stage.exact, image, images)
        exact[metrics.TRANSMITTANCE] = metrics.rmse_transmittance(
            stage.exact_transmittance, transmittance
        )
        scores = {EXACT: Scores(exact | spread), PATH_TRACED: Scores(reason=_LEFT_OUT)}
        if PATH_TRACED in cell.truths:
            self._on_step(_PATH_TRACING)
            scores[PATH_TRACED] = self._score_path_traced(stage, image, images)
        return Outcome(
            parameters=method.values,
            effects=EffectNames(
                requested=names(requested & scene.effects),
                expressed=names(effects),
                missing=names(requested & scene.effects & ~method.shows),
            ),
            fragments=cost.fragments,
            max_depth_complexity=complexity,
            passes=cost.passes,
            memory=cost.memory,
            traffic=cost.traffic,
            shading=cost.shading,
            nonfinite=Nonfinite(**metrics.count_nonfinite(image)),
            scores=scores,
            images=images,
            exposure=scene.exposure,
            plan=plan.digest,
        )

    def _prepare(self, cell: Cell) -> Stage:
        """Return the stage of the cell's scene, kept while scene, size and settings stay."""
        wanted = (cell.scene, cell.size, cell.ssaa, cell.shading)
        stage = self._stage
        if stage is not None and stage.identity == wanted:
            return stage
        self.leave_scene()
        with self.watch.running("rendering"), ExitStack() as stack:
            scene = self.identities.scene(cell.scene)
            self._on_step(_DRAWING_TRUTH)
            uploaded = stack.enter_context(UploadedScene(self.device, scene, cell.settings))
            truth = self.collection.truth()
            fine = (cell.size[0] * cell.ssaa, cell.size[1] * cell.ssaa)
            with Frame(uploaded, truth, fine, scene.effects & truth.shows) as frame:
                exact, transmittance = with_transmittance(frame, cell.ssaa)
            images = {EXACT: self._store(EXACT, files.image_channels(exact))}
            stack.pop_all()
        self._stage = Stage(*wanted, uploaded, exact, transmittance, images)
        return self._stage

    def _store(self, kind: str, channels: Channels) -> StoredImage:
        return stored.store(self.folder, f"{IMAGES}/{kind}", channels)

    def _score(
        self,
        truth: str,
        stage: Stage,
        reference: Image,
        image: Image,
        images: dict[str, StoredImage],
    ) -> dict[str, float | None]:
        """Return all metrics against a truth, and add it and its maps of FLIP to `images`."""
        images[truth] = stage.images[truth]
        with self.watch.running("metrics"):
            evaluation = metrics.compare(reference, image, stage.scene.exposure)
            if evaluation.maps:
                maps = (evaluation.maps[metrics.FLIP_LDR], evaluation.maps[metrics.FLIP_HDR])
                kind = flip_image(truth)
                images[kind] = self._store(kind, files.flip_channels(*maps))
        return evaluation.values

    def _score_path_traced(
        self, stage: Stage, image: Image, images: dict[str, StoredImage]
    ) -> Scores:
        """Score the image against path tracing, and add that truth to `images`."""
        try:
            with self.watch.running("references"):
                reference, message = stage.reference(self.collection.folders)
        except CapabilityError as error:
            return Scores(reason=str(error))
        if PATH_TRACED not in stage.images:
            channels = files.image_channels(reference.mean)
            stage.images[PATH_TRACED] = self._store(PATH_TRACED, channels)
        values = self._score(PATH_TRACED, stage, reference.mean, image, images)
        return Scores(values, reference.noise_floor, message=message)

    def time(self, cells: Sequence[ScoredCell], schedule: Schedule) -> list[Timing]:
        """Time the cells of one scene against each other; see `time_cells`.

        The times of a cell whose files have changed since it was scored would be those of another.
        """
        with self.watch.running("rendering"):
            same = [
                scored
                for scored in cells
                if scored.fingerprints in (None, self.identities.find(scored.cell))
            ]
            timings: list[Timing] = []
            if same:
                scene = self.identities.scene(same[0].cell.scene)
                self._on_step(_TIMING)
                timings = time_cells(self.device, self.collection, scene, same, schedule)
            found = dict(zip((scored.cell for scored in same), timings, strict=True))
        return [found.get(scored.cell, _CHANGED) for scored in cells]


def _without_fragments(record: Record, scene: Scene) -> Record:
    """Return the record of a picture in which nothing was drawn, which scores perfectly."""
    if not scene.transparent and scene.lists is None:
        return record
    return record.suspect("no fragment of a transparent object was drawn; check the camera")


def _require_same(plan: FramePlan, scored: FramePlan, when: str) -> None:
    """Raise `DeclarationError` if a frame does not draw what the scored frame draws."""
    if plan.digest != scored.digest:
        raise DeclarationError(
            f"{plan.label}: plan returns other passes when {when}; it must depend on parameters and"
            " its request alone"
        )


def _count(
    uploaded: UploadedScene,
    method: Method,
    size: tuple[int, int],
    effects: Effect,
    scored: FramePlan,
) -> _Cost:
    """Count fragments, memory and traffic of one frame without sub-pixels."""
    with Frame(uploaded, method, size, effects, counted=True) as frame:
        _require_same(frame.plan, scored, "it is counted")
        frame.render()
        measured = frame.measure()
        return _Cost(
            int(frame.complexity.sum()),
            [PassRuns(record.name, record.runs) for record in measured.passes],
            accounting.memory(frame),
            accounting.traffic(frame, measured),
            accounting.shading(frame, measured),
        )


def _order_spread(
    uploaded: UploadedScene, method: Method, cell: Cell, effects: Effect, scored: FramePlan
) -> dict[str, float | None]:
    with Frame(uploaded, method, cell.size, effects) as frame:
        _require_same(frame.plan, scored, "its draws are permuted")

        def permuted() -> Iterator[Image]:
            for number in range(1, cell.permutations + 1):
                frame.render(permutation=number)
                yield frame.image()

        return metrics.order_spread(permuted())


def _unstable_pixels(counts: Nonfinite) -> str:
    """Return the kinds of unstable pixels in words; empty if there are none."""
    kinds = {"nan": counts.nan, "inf": counts.inf, "negative": counts.negative}
    bad = [f"{count} {kind}" for kind, count in kinds.items() if count]
    return f"pixels: {', '.join(bad)}" if bad else ""

"""Renders, scores and times cells, keeping the objects that consecutive cells share."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path

import msgspec

from oitbench.effects import Effect, names
from oitbench.errors import CapabilityError, OitbenchError, StorageError
from oitbench.gl.device import Device
from oitbench.gl.frame import Frame
from oitbench.gl.limits import check_size
from oitbench.gl.uploaded_scene import UploadedScene
from oitbench.image import files, metrics, stored
from oitbench.image.files import Channels
from oitbench.image.stored import StoredImage
from oitbench.matrix.cell import Cell, choose_effects
from oitbench.matrix.identity import Identities
from oitbench.matrix.plain_frames import PlainFrames
from oitbench.matrix.scoring import Scorer, disagreement
from oitbench.matrix.stage import Stage, Truth, averaged
from oitbench.matrix.timed_cells import ScoredCell, Timing, time_cells
from oitbench.measure.rounds import Schedule
from oitbench.method.declaration import Method
from oitbench.parameters import parse
from oitbench.plugins import Collection
from oitbench.results.pictures import REDUCED, REDUCED_EXACT
from oitbench.results.schema import (
    COMPLEXITY,
    TRANSMITTANCE,
    WHOLE,
    EffectNames,
    Fingerprints,
    Nonfinite,
    Outcome,
    Record,
    Renderer,
    Scores,
    Status,
)
from oitbench.results.store import IMAGES
from oitbench.scene import Scene
from oitbench.truths import EXACT, MATCHED, TRACED, ranking_truth
from oitbench.workers.messages import Step

_LEFT_OUT = "left out of this run"
_BUILDING = Step("building the scene", shared=True)
_DRAWING_TRUTH = Step("drawing the exact truth", shared=True)
_DRAWING = Step("drawing and scoring the picture")
_TRACING = Step("tracing the scene", shared=True)
_TIMING = Step("timing the scene")
_CHANGED = Timing(reason="its files changed during the run; run again")


@dataclass
class Stopwatch:
    """Seconds spent by kind of work: see `oitbench.matrix.run.KINDS`."""

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
        return Renderer.of(self.device)

    def leave_scene(self) -> None:
        """Free the scene that is kept for further cells."""
        if self._stage is not None:
            stage, self._stage = self._stage, None
            stage.release()

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
        reason = contradiction = ""
        try:
            (method,) = self.collection.expand_methods([cell.method])
            with self.watch.running("building"):
                fingerprints = self.identities.of(cell, method)
            outcome, contradiction = self._run(cell, method)
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
        if contradiction and outcome is not None:
            record = record.suspect(contradiction)
        drawn = outcome is None or outcome.transparent_pixels > 0
        return record if drawn else _without_fragments(record, self.identities.scene(cell))

    def _run(self, cell: Cell, method: Method) -> tuple[Outcome, str]:
        """Return what was measured, and why its numbers contradict each other, or ""."""
        fine = (cell.size[0] * cell.ssaa, cell.size[1] * cell.ssaa)
        check_size(self.device, fine)
        stage = self._prepare(cell)
        scene, uploaded = stage.scene, stage.uploaded
        chosen = choose_effects(cell.effects, scene.effects)
        effects = chosen & method.shows
        self._on_step(_DRAWING_TRUTH)
        with self.watch.running("rendering"):
            exact = stage.exact(chosen, cell.size)
            reduced = stage.exact(chosen, cell.traced_size)
        self._on_step(_DRAWING)
        with self.watch.running("rendering"):
            with Frame(uploaded, method, fine, effects) as frame:
                _check_layers(frame, cell.most_layers)
                image = averaged(frame, cell.ssaa)
                passed = None if cell.reduced else averaged(frame, cell.ssaa, transmittance=True)
                plan = frame.plan
            frames = PlainFrames(stage, cell, method, effects, plan)
            cost = frames.count()
        with self.watch.running("permutations"):
            spread = frames.order_spread()
        scorer = traced = Scorer(stage, exact, image, self._store)
        if cell.reduced:
            small = files.box_downsample(cost.image, cell.ssaa)
            traced = Scorer(stage, reduced, small, self._store, REDUCED)
            traced.images[REDUCED_EXACT] = reduced.truth.stored
        if cost.transmittance is not None:
            passed = files.box_downsample(cost.transmittance, cell.ssaa)
        assert passed is not None
        scores, reason = self._score_all(stage, cell, chosen, scorer, traced)
        rmse = metrics.rmse_transmittance(reduced.transmittance, passed)
        own = scores[EXACT].metrics | spread | {metrics.TRANSMITTANCE: rmse}
        scores[EXACT] = msgspec.structs.replace(scores[EXACT], metrics=own)
        outcome = Outcome(
            parameters=method.values,
            effects=EffectNames(
                requested=names(chosen & scene.effects),
                expressed=names(effects),
                missing=names(chosen & scene.effects & ~method.shows),
            ),
            statistics=stage.statistics(effects),
            transparent_pixels=int(exact.transparent.sum()),
            passes=cost.passes,
            memory=cost.memory,
            traffic=cost.traffic,
            shading=cost.shading,
            nonfinite=Nonfinite(**metrics.count_nonfinite(image)),
            scores=scores,
            images=scorer.images
            | traced.images
            | {COMPLEXITY: stage.complexity(effects), TRANSMITTANCE: exact.stored},
            exposure=scene.exposure,
            demands=plan.demands,
            plan=plan.digest,
            family=method.family,
            subject=self.collection.scenes[parse(cell.scene).name].subject,
        )
        return outcome, reason

    def _prepare(self, cell: Cell) -> Stage:
        """Return the stage of the cell's scene, which is kept while its identity stays the same."""
        wanted = (cell.scene, cell.size, cell.ssaa, cell.shading, cell.view)
        stage = self._stage
        if stage is not None and stage.identity == wanted:
            return stage
        self.leave_scene()
        with self.watch.running("rendering"):
            scene = self.identities.scene(cell)
            rows = cell.size[1] * cell.ssaa
            uploaded = UploadedScene(self.device, scene, cell.settings, rows)
        self._stage = Stage(*wanted, uploaded, self.collection.truth(), self._store)
        return self._stage

    def _store(self, kind: str, channels: Channels) -> StoredImage:
        return stored.store(self.folder, f"{IMAGES}/{kind}", channels)

    def _score_all(
        self, stage: Stage, cell: Cell, chosen: Effect, scorer: Scorer, traced: Scorer
    ) -> tuple[dict[str, Scores], str]:
        """Return the scores against all truths, and why truths contradict each other, or "".

        `traced` scores against traced truths, whose pictures may be smaller.
        """
        with self.watch.running("metrics"):
            scores = {EXACT: scorer.score(EXACT, scorer.exact.truth)}
        reason = ""
        for kind in TRACED:
            if kind not in cell.truths:
                scores[kind] = Scores(reason=_LEFT_OUT)
                continue
            truth = self._traced(stage, cell, kind, chosen)
            scores[kind] = self._score(traced, kind, truth)
            if kind == MATCHED and isinstance(truth, Truth):
                reason = self._disagreement(stage, chosen, traced.exact.truth, truth)
        if stage.scene.effects & ~chosen:
            kind = ranking_truth(stage.scene.effects)
            if kind == EXACT:
                complete = stage.exact(~Effect.NONE, cell.size).truth
                scores[WHOLE] = self._score(scorer, WHOLE, complete)
            elif kind in cell.truths:
                whole = self._traced(stage, cell, kind, ~Effect.NONE)
                scores[WHOLE] = self._score(traced, WHOLE, whole)
        return scores, reason

    def _disagreement(self, stage: Stage, chosen: Effect, exact: Truth, matched: Truth) -> str:
        """Return why two truths contradict each other, which all cells of a panel share, or ""."""
        running = stage.scene.effects & chosen
        if running not in stage.disagreements:
            found = disagreement(running, exact, matched, stage.scene.exposure)
            stage.disagreements[running] = found
        return stage.disagreements[running]

    def _traced(
        self, stage: Stage, cell: Cell, kind: str, chosen: Effect
    ) -> Truth | CapabilityError:
        """Return a traced truth, or why this machine cannot render it."""

        def progress(done: int, count: int) -> None:
            # Each part is a step, so that long renderings are not taken for endless ones.
            self._on_step(_TRACING)

        self._on_step(_TRACING)
        try:
            with self.watch.running("references"):
                size, folders = cell.traced_size, self.collection.folders
                return stage.traced(kind, chosen, size, folders, progress)
        except CapabilityError as error:
            return error

    def _score(self, scorer: Scorer, kind: str, truth: Truth | CapabilityError) -> Scores:
        if isinstance(truth, CapabilityError):
            return Scores(reason=str(truth))
        with self.watch.running("metrics"):
            return scorer.score(kind, truth)

    def time(self, cells: Sequence[ScoredCell], schedule: Schedule) -> list[Timing]:
        """Time the cells of one scene against each other; see `time_cells`.

        The times of a cell whose files have changed since it was scored would be those of another.
        """
        with self.watch.running("building"):
            same = [
                scored
                for scored in cells
                if scored.fingerprints in (None, self.identities.find(scored.cell))
            ]
            scene = self.identities.scene(same[0].cell) if same else None
        timings: list[Timing] = []
        if scene is not None:
            self._on_step(_TIMING)
            with self.watch.running("timing"):
                timings = time_cells(self.device, self.collection, scene, same, schedule)
        found = dict(zip((scored.cell for scored in same), timings, strict=True))
        return [found.get(scored.cell, _CHANGED) for scored in cells]


def _check_layers(frame: Frame, most: int | None) -> None:
    """Raise `CapabilityError` if a frame draws the geometry for too many layers, one by one."""
    layers = int(frame.complexity.max())
    if most is not None and layers > most and frame.plan.peels:
        raise CapabilityError(
            f"{layers} layers lie at one pixel, and the geometry is drawn once for each of them or"
            f" for two; this preset allows {most} layers, and 'paper' any number"
        )


def _without_fragments(record: Record, scene: Scene) -> Record:
    """Return the record of a picture in which nothing was drawn, which scores perfectly."""
    if not scene.transparent and scene.lists is None:
        return record
    return record.suspect("no fragment of a transparent object was drawn; check the camera")


def _unstable_pixels(counts: Nonfinite) -> str:
    """Return the kinds of unstable pixels in words; empty if there are none."""
    kinds = {"nan": counts.nan, "inf": counts.inf, "negative": counts.negative}
    bad = [f"{count} {kind}" for kind, count in kinds.items() if count]
    return f"pixels: {', '.join(bad)}" if bad else ""

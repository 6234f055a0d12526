"""The near end of a process that scores stored images, and the records that it changes."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import msgspec

from oitbench.errors import OitbenchError, UsageError
from oitbench.image import stored
from oitbench.results.custom import CustomMetric
from oitbench.results.pictures import compared
from oitbench.results.schema import Outcome, Record, Scores, flip_image
from oitbench.results.store import IMAGES
from oitbench.scoring.worker import (
    BuiltInMeasured,
    LoadMetric,
    Measure,
    MeasureBuiltIn,
    Measured,
    MetricLoaded,
    Reply,
    Settings,
)
from oitbench.workers.messages import Step
from oitbench.workers.process import Process, WorkerError

SECONDS = 600.0
"""Time in which one metric of two images must end by default."""
_SHOWN = 3
_LOADING, _MEASURING = Step("loading the file"), Step("measuring the suite's metrics")


@dataclass
class Findings:
    """What went wrong while cells were scored.

    Parameters
    ----------
    scored : int
        Cells that have new scores.
    damaged : list of str
        Images that cannot be read, one line each; their cells keep their old numbers.
    """

    scored: int = 0
    damaged: list[str] = field(default_factory=list)
    _faults: dict[str, dict[str, None]] = field(default_factory=dict)

    def add_fault(self, metric: str, reason: str, cell: str) -> None:
        """Note that a metric has no value in a cell."""
        self._faults.setdefault(f"{metric}: {reason}", {})[cell] = None

    @property
    def lines(self) -> list[str]:
        """All that went wrong; faults of a metric that have the same reason are one line."""
        found = list(self.damaged)
        for reason, cells in self._faults.items():
            more = f" and {len(cells) - _SHOWN} more" if len(cells) > _SHOWN else ""
            found.append(f"{reason}; no value in {', '.join([*cells][:_SHOWN])}{more}")
        return found


class Scorer:
    """Scores cells from their stored images; a context manager.

    Parameters
    ----------
    paths : sequence of Path
        Files of metrics.
    memory_limit : int
        Bytes that the process may use.
    timeout : float, optional
        Seconds for each metric of two images. None: no limit.

    Raises
    ------
    DeclarationError
        A file cannot be loaded or is no metric.
    UsageError
        Two files have a metric of one name.
    """

    def __init__(
        self, paths: Sequence[Path], memory_limit: int, timeout: float | None = SECONDS
    ) -> None:
        self._timeout = timeout
        self._process = Process("oitbench.scoring.worker", Settings(), Reply, memory_limit)
        self._paths: dict[str, Path] = {}
        self.metrics: dict[str, CustomMetric] = {}
        self._lost: dict[str, str] = {}
        try:
            self._load(paths)
        except BaseException:
            self._process.stop()
            raise

    def __enter__(self) -> Scorer:
        return self

    def __exit__(self, *error: object) -> None:
        self._process.stop()

    def _load(self, paths: Iterable[Path]) -> None:
        for path in dict.fromkeys(path.resolve() for path in paths):
            try:
                found = self._process.ask(LoadMetric(path), MetricLoaded, self._timeout, _LOADING)
            except WorkerError as error:
                raise UsageError(f"{path}: {error}") from error
            if found.name in self._paths:
                raise UsageError(
                    f"two metrics are named '{found.name}': {self._paths[found.name]} and {path};"
                    " rename one"
                )
            self._paths[found.name], self.metrics[found.name] = path, found.facts

    def is_current(self, record: Record) -> bool:
        """Return whether a cell has no image, or the values of all metrics as they are now."""
        outcome = record.outcome
        if outcome is None or not record.finished:
            return True
        same = all(outcome.custom.get(name) == facts for name, facts in self.metrics.items())
        failed = {name for scores in outcome.scores.values() for name in scores.faults}
        return same and not failed & self.metrics.keys()

    def score(
        self, record: Record, folder: Path, findings: Findings, *, built_in: bool = False
    ) -> Record:
        """Return the record of a finished cell with new scores.

        Noise floors, the jackknife, the parts of FLIP and the metrics that need further pictures
        are kept, since what they are computed from is not stored.

        Parameters
        ----------
        record : Record
        folder : Path
            The results folder.
        findings : Findings
            Receives what goes wrong.
        built_in : bool
            Compute the suite's metrics, too.

        Raises
        ------
        StorageError
            A map of FLIP cannot be written.
        """
        outcome = record.outcome
        if outcome is None or not record.finished:
            return record
        kinds = [kind for kind in outcome.scores if kind in outcome.images]
        try:
            pairs = {
                kind: [
                    stored.verify(folder, outcome.images[name])
                    for name in (kind, compared(outcome, kind))
                ]
                for kind in kinds
            }
        except UsageError as error:
            findings.damaged.append(f"{error}; {record.seen} {record.method} keeps its numbers")
            return record
        for kind, (truth, test) in pairs.items():
            if built_in:
                outcome = self._score_built_in(outcome, kind, truth, test, folder)
            for name in self.metrics:
                measured = self._measure(name, truth, test, outcome.exposure)
                if measured.fault:
                    findings.add_fault(name, measured.fault, f"{record.seen} {record.method}")
                outcome = _with_value(outcome, kind, name, measured)
        findings.scored += 1
        outcome = msgspec.structs.replace(outcome, custom=outcome.custom | self.metrics)
        return msgspec.structs.replace(record, outcome=outcome)

    def _measure(self, name: str, truth: Path, test: Path, exposure: float) -> Measured:
        if name in self._lost:
            return Measured(fault=self._lost[name])
        path, digest = self._paths[name], self.metrics[name].digest
        request = Measure(path, digest, truth, test, exposure)
        try:
            # The time of loading the file again, after the process has ended, does not count.
            return self._process.ask(request, Measured, self._timeout)
        except WorkerError as error:
            # It would take as long, or end the process, in all other cells.
            self._lost[name] = f"{path}: {error}"
            return Measured(fault=self._lost[name])

    def _score_built_in(
        self, outcome: Outcome, kind: str, truth: Path, test: Path, folder: Path
    ) -> Outcome:
        key = flip_image(kind)
        request = MeasureBuiltIn(truth, test, outcome.exposure, folder, f"{IMAGES}/{key}")
        try:
            found = self._process.ask(request, BuiltInMeasured, self._timeout, _MEASURING)
        except WorkerError as error:
            raise OitbenchError(f"{truth} and {test} cannot be compared: {error}") from error
        images = outcome.images if found.maps is None else outcome.images | {key: found.maps}
        scores = outcome.scores[kind]
        changed = msgspec.structs.replace(scores, metrics=scores.metrics | found.values)
        return msgspec.structs.replace(
            outcome, images=images, scores=outcome.scores | {kind: changed}
        )


def _with_value(outcome: Outcome, kind: str, name: str, measured: Measured) -> Outcome:
    """Return an outcome with the value of one metric against a truth, or the reason of its lack."""
    scores: Scores = outcome.scores[kind]
    faults = {metric: text for metric, text in scores.faults.items() if metric != name}
    if measured.fault:
        faults[name] = measured.fault
    changed = msgspec.structs.replace(
        scores, metrics=scores.metrics | {name: measured.value}, faults=faults
    )
    return msgspec.structs.replace(outcome, scores=outcome.scores | {kind: changed})

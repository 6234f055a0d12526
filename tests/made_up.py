"""Made-up records, for tests of code that reads results."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import msgspec

from oitbench.fingerprints.code import timing_fingerprint
from oitbench.image import metrics
from oitbench.image.stored import StoredImage
from oitbench.method.demands import NOTHING
from oitbench.results.schema import (
    EffectNames,
    Fingerprints,
    Memory,
    Nonfinite,
    Outcome,
    PassRuns,
    Record,
    Renderer,
    RunFacts,
    Scores,
    SharedShading,
    Traffic,
)
from oitbench.results.statistics import DepthComplexity, SceneStatistics
from oitbench.results.store import Store
from oitbench.results.times import Block, Interval, PassTime, Processor, Time
from oitbench.truths import EXACT, FULL, MATCHED, TRUTHS

VALUES: dict[str, float | None] = {
    metrics.FLIP_LDR: 0.1,
    metrics.FLIP_HDR: 0.12,
    metrics.SSIM: 0.9,
    metrics.PSNR: 30.0,
    metrics.RMSE: 0.05,
    metrics.RELMSE: 0.02,
    metrics.TRANSMITTANCE: 0.01,
}


NO_IMAGE = StoredImage("images/a.exr", "0" * 64, 1)
"""An image that does not exist."""
STATISTICS = SceneStatistics(
    objects=3, transparent_objects=2, triangles=500, transparent_triangles=400, draws=3,
    fragments=10_000, covered_pixels=30,
    complexity=DepthComplexity(2.5, 2.0, 4, [(0, 18), (2, 20), (4, 10)]),
)  # fmt: skip
FINGERPRINTS = Fingerprints("s", "m", "e", "f", {EXACT: "x", MATCHED: "p", FULL: "q"})


def outcome_of(scores: dict[str, Scores], images: dict[str, StoredImage]) -> Outcome:
    """Return the outcome of a frame with two passes."""
    return Outcome(
        parameters={},
        effects=EffectNames(["COVERAGE"], [], ["COVERAGE"]),
        statistics=STATISTICS,
        transparent_pixels=32,
        passes=[PassRuns("peel", 8), PassRuns("resolve", 1)],
        memory=Memory(960, 160.0, []),
        traffic=Traffic(50_000, []),
        shading=SharedShading(Memory(0, 0.0, []), Traffic(0, [])),
        nonfinite=Nonfinite(),
        scores=scores,
        images=images,
        exposure=0.0,
        demands=NOTHING,
    )


def record(method: str = "mean", scene: str = "glass[count=4]", **fields: Any) -> Record:
    """Return the record of a cell that succeeded, with other values for `fields`."""
    scores = {truth: Scores(dict(VALUES)) for truth in TRUTHS}
    name = method.partition("[")[0]
    outcome = outcome_of(scores, {"color": NO_IMAGE})
    made = Record(
        scene, method, name, (8, 6), 2, "requested", 1, 4, list(TRUTHS), "ok",
        gl=Renderer("softly"), fingerprints=FINGERPRINTS, outcome=outcome, time=timed(2.0),
    )  # fmt: skip
    return msgspec.structs.replace(made, **fields)


def timed(
    method_ms: float, swing: float = 0.1, sort_ms: float | None = None, foreign: float = 0.0
) -> Time:
    """Return times of nine rounds, beside 1 ms of shading.

    Parameters
    ----------
    method_ms : float
        Median time of the method in milliseconds.
    swing : float
        Difference between the median and the last sample.
    sort_ms : float, optional
        Part of sorting.
    foreign : float
        Share of the CPU time that other processes took.
    """
    steps = [swing * (number - 4) / 4 for number in range(9)]
    method = interval_of([method_ms + step for step in steps])
    processor, code = Processor("abacus", 2, "performance"), timing_fingerprint()
    block = Block("wall", processor, 1.5, foreign, rounds=9, budget=4.0, code=code)
    return Time(
        method_ms=method,
        sort_ms=None if sort_ms is None else interval_of([sort_ms] * 9),
        gpu_ms=None,
        shading_ms=interval_of([1.0] * 9),
        frame_ms=interval_of([sample + 1.0 for sample in method.samples]),
        passes=[PassTime("peel", method)],
        shading=[PassTime("opaque picture", interval_of([1.0] * 9))],
        block=block,
    )


def interval_of(samples: list[float]) -> Interval:
    """Return the interval of nine samples."""
    ordered = sorted(samples)
    return Interval(ordered[4], ordered[1], ordered[7], 0.9609375, samples)


def failed(method: str = "mean", reason: str = "no such shader", **fields: Any) -> Record:
    """Return the record of a cell without an image."""
    values: dict[str, Any] = {"status": "failed", "outcome": None, "time": None}
    return record(method, reason=reason, **(values | fields))


def changed(item: Any, path: str, value: Any) -> Any:
    """Return a copy of a record with another value at a path such as `outcome.memory.bytes`.

    Only the last key of a path may contain dots.
    """
    name, _, rest = path.partition(".")
    if isinstance(item, dict):
        key = path if path in item or not rest else name
        return {**item, key: value if key == path else changed(item[key], rest, value)}
    inner = changed(getattr(item, name), rest, value) if rest else value
    return msgspec.structs.replace(item, **{name: inner})


FACTS = RunFacts(gl=Renderer("softly"), seed=1, argv=["/home/me/oitbench"])


def write(folder: Path, records: Sequence[Record], facts: RunFacts = FACTS) -> Path:
    """Write a results folder, without images, and return it."""
    with Store.open(folder) as store:
        store.write_run(facts)
        for item in records:
            store.append(item)
        store.compact()
    return folder

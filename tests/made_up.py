"""Records that were never rendered, for tests of everything that reads results."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import msgspec

from oitbench.image import metrics
from oitbench.results.schema import (
    EffectNames,
    Interval,
    Memory,
    Nonfinite,
    Outcome,
    PassRuns,
    Record,
    Renderer,
    RunFacts,
    Scores,
    SharedShading,
    Time,
    Traffic,
)
from oitbench.results.store import Store

VALUES: dict[str, float | None] = {
    metrics.FLIP_LDR: 0.1,
    metrics.FLIP_HDR: 0.12,
    metrics.SSIM: 0.9,
    metrics.PSNR: 30.0,
    metrics.RMSE: 0.05,
    metrics.RELMSE: 0.02,
    metrics.TRANSMITTANCE: 0.01,
}


def record(method: str = "mean", scene: str = "glass[count=4]", **fields: Any) -> Record:
    """Return the record of a cell that succeeded; `fields` replace fields of it."""
    outcome = Outcome(
        parameters={},
        effects=EffectNames(["COVERAGE", "REFRACTION"], ["COVERAGE"], []),
        fragments=10_000,
        max_depth_complexity=4,
        passes=[PassRuns("peel", 8), PassRuns("resolve", 1)],
        memory=Memory(960, 160.0, []),
        traffic=Traffic(50_000, []),
        shading=SharedShading(Memory(0, 0.0, []), Traffic(0, [])),
        nonfinite=Nonfinite(),
        scores={"exact": Scores(dict(VALUES)), "path_traced": Scores(dict(VALUES))},
        images={"color": "images/a.exr"},
        exposure=0.0,
    )
    made = Record(
        scene,
        method,
        method.partition("[")[0],
        (8, 6),
        2,
        "requested",
        1,
        "ok",
        outcome=outcome,
        time=Time(Interval(2.0, 1.9, 2.1, [2.0]), 0.0),
    )
    return msgspec.structs.replace(made, **fields)


def failed(method: str = "mean", reason: str = "no such shader", **fields: Any) -> Record:
    """Return the record of a cell without an image."""
    return record(method, status="failed", reason=reason, outcome=None, time=None, **fields)


def changed(item: Any, path: str, value: Any) -> Any:
    """Return a copy of a record in which the field at a path, as `outcome.memory.bytes`, differs.

    Keys of mappings may contain dots if they come last.
    """
    name, _, rest = path.partition(".")
    if isinstance(item, dict):
        key = path if path in item or not rest else name
        return {**item, key: value if key == path else changed(item[key], rest, value)}
    inner = changed(getattr(item, name), rest, value) if rest else value
    return msgspec.structs.replace(item, **{name: inner})


def write(folder: Path, records: list[Record], renderer: str = "softly") -> Path:
    """Write a results folder and return it."""
    store = Store.open(folder)
    store.write_run(RunFacts(gl=Renderer(renderer), seed=1, argv=["/home/me/oitbench"]))
    for item in records:
        store.append(item)
    return folder

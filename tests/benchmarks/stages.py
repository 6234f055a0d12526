"""Print the time of each stage of a lit frame, as in table 1 of McGuire & Mara 2017.

    python tests/benchmarks/stages.py [--size 1920x1080] [--rounds 9] [SCENE ...]

The stages are shadow maps, their filtering, transparency and resolve. A scene with particles has a
second row, in which particles are accumulated at a quarter of the width and height. Upsampling is
part of the resolve, as in the paper; downsampling of the depth is part of the particles. Each draw
is finished before the next one starts. The variants of a scene alternate in shuffled order, so that
a drift of the machine's speed affects all equally. Default: all lit scenes. The output is
results/benchmarks/stages.{md,csv}.
"""

from __future__ import annotations

import argparse
import csv
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from oitbench.gl.device import Device
from oitbench.gl.frame import Frame
from oitbench.gl.uploaded_scene import UploadedScene
from oitbench.measure import timing
from oitbench.method.passes import Gather, Objects, Pass
from oitbench.plugins import Collection
from oitbench.scene import Scene

METHODS = {"1x1": "phenomenological", "4x4 sub.": "phenomenological[subsample=4]"}
PARTICLES, OTHERS, TOTAL = "OIT, particles", "OIT, others", "OIT"
FOG, RESOLVE, GAIN = "OIT, medium", "resolve", "particles, times faster"
OCCLUSION = "ambient occlusion"
SHADING = ("shadow maps", "variance maps", OCCLUSION)
COLUMNS = (*SHADING, PARTICLES, OTHERS, FOG, TOTAL, RESOLVE, GAIN)
WARM_UP = 2
"""Measured frames that are discarded: drivers compile again for the queries of a measurement."""
BUDGET = 120.0
"""Seconds per scene after which no further round starts, once three are complete."""
OUT = Path("results/benchmarks")
ENDS = ("median", "low", "high")
Samples = dict[str, list[float]]


@dataclass(frozen=True)
class Row:
    """One variant of a scene: [median, low, high] of each of its stages, in milliseconds."""

    scene: str
    variant: str
    stages: Mapping[str, Sequence[float]]

    @property
    def text(self) -> str:
        """The row in Markdown."""
        cells = {
            stage: f"{median:.2f} [{low:.2f}, {high:.2f}]"
            for stage, (median, low, high) in self.stages.items()
        }
        return _line([self.scene, self.variant, *(cells.get(column, "") for column in COLUMNS)])


def stage_of(step: Pass, mixed: bool) -> str:
    """Return the stage of a pass; with `mixed`, particles are drawn separately."""
    if isinstance(step, Gather):
        separate = {Objects.PARTICLES: PARTICLES, Objects.OTHERS: OTHERS}
        return separate.get(step.objects, TOTAL) if mixed else OTHERS
    return {"fog": FOG, "shrink_depth": PARTICLES}.get(step.name, RESOLVE)


def measured(frame: Frame, mixed: bool) -> dict[str, float]:
    """Return the time of each stage of one frame, in milliseconds."""
    measurement = frame.measure()
    stages: dict[str, float] = {}
    for step, record in zip(frame.plan.passes, measurement.passes, strict=True):
        stage = stage_of(step, mixed)
        stages[stage] = stages.get(stage, 0.0) + record.milliseconds
    parts = [stages[name] for name in (PARTICLES, OTHERS, FOG) if name in stages]
    stages[TOTAL] = stages.get(TOTAL, 0.0) + sum(parts)
    for record in measurement.shading:
        stage = record.name if record.name in SHADING else OCCLUSION
        stages[stage] = stages.get(stage, 0.0) + record.milliseconds
    return stages


def measure(device: Device, scene: Scene, size: tuple[int, int], rounds: int) -> dict[str, Samples]:
    """Return the samples of every stage by variant, one per round."""
    collection, uploaded = Collection.load(), UploadedScene(device, scene)
    mixed = uploaded.geometry.has(Objects.PARTICLES)
    frames = {}
    for name, text in METHODS.items():
        if name == "1x1" or mixed:
            (method,) = collection.expand_methods([text])
            frames[name] = Frame(uploaded, method, size, scene.effects & method.shows)
            frames[name].render()
    samples: dict[str, Samples] = {name: {} for name in frames}
    generator, names, start = np.random.default_rng(1), list(frames), time.perf_counter()
    for number in range(rounds + WARM_UP):
        for name in generator.permutation(names):
            for stage, value in measured(frames[str(name)], mixed).items():
                if number >= WARM_UP:
                    samples[str(name)].setdefault(stage, []).append(value)
        if number >= WARM_UP + 2 and time.perf_counter() - start > BUDGET:
            break
    if mixed:
        _compare(samples)
    for frame in frames.values():
        frame.release()
    uploaded.release()
    return samples


def _compare(samples: dict[str, Samples]) -> None:
    """Add the time of the particles at full resolution, and its ratio to their time in blocks."""
    full, small = samples["1x1"], samples["4x4 sub."]
    # All other objects are drawn the same way in both variants, so their time is subtracted.
    others = np.median(small.get(OTHERS, [0.0])) + np.median(full.get(FOG, [0.0]))
    full[PARTICLES] = [value - float(others) for value in full[TOTAL]]
    small[GAIN] = [
        one / other for one, other in zip(full[PARTICLES], small[PARTICLES], strict=True)
    ]


def rows_of(name: str, samples: Mapping[str, Samples]) -> list[Row]:
    """Return one row per variant with [median, low, high] of each of its stages."""
    rows = []
    for variant, stages in samples.items():
        facts = {stage: timing.interval(values) for stage, values in stages.items()}
        numbers = {stage: [getattr(fact, end) for end in ENDS] for stage, fact in facts.items()}
        rows.append(Row(name, variant, numbers))
    return rows


def write(rows: list[Row], head: str) -> None:
    """Write all rows as Markdown and as CSV."""
    OUT.mkdir(parents=True, exist_ok=True)
    titles = ["scene", "particles", *COLUMNS]
    lines = [f"{head}; milliseconds: median [95 % interval]", ""]
    lines += [_line(titles), _line(["---"] * len(titles)), *(row.text for row in rows)]
    (OUT / "stages.md").write_text("\n".join([*lines, ""]), encoding="utf-8")
    with (OUT / "stages.csv").open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow([*titles[:2], *(f"{title} {end}" for title in COLUMNS for end in ENDS)])
        for row in rows:
            numbers = [row.stages.get(column, [""] * len(ENDS)) for column in COLUMNS]
            writer.writerow([row.scene, row.variant, *(n for cell in numbers for n in cell)])


def _line(cells: Sequence[str]) -> str:
    return f"| {' | '.join(cells)} |"


def main() -> None:
    """Measure, print and write."""
    parser = argparse.ArgumentParser()
    parser.add_argument("scenes", nargs="*")
    parser.add_argument("--size", default="512x384")
    parser.add_argument("--rounds", type=int, default=9)
    options = parser.parse_args()
    width, height = (int(side) for side in options.size.split("x"))
    device, collection = Device(), Collection.load()
    rows: list[Row] = []
    for name in options.scenes or list(collection.scenes):
        scene = collection.build_scene(name)
        if not scene.lights:
            print(f"left out: {name} is not lit")
            continue
        found = rows_of(name, measure(device, scene, (width, height), options.rounds))
        rows += found
        print(*(row.text for row in found), sep="\n", flush=True)
    write(rows, f"{device.renderer}, {width}x{height}")
    print(f"written to {OUT}/stages.md")


if __name__ == "__main__":
    main()

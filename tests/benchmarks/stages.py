"""Print the time of each stage of a lit frame, as in table 1 of McGuire & Mara 2017.

    python -m tests.benchmarks.stages [--size 1920x1080] [--rounds 9] [SCENE ...]

The stages are shadow maps, their filtering, transparency and resolve. A scene with particles or a
medium has a second row, in which they are accumulated at a quarter of the width and height.
Upsampling is part of the resolve, as in the paper; downsampling of the depth is part of the
particles, or of the medium if there are none, and clears before the first pass are part of the sum
only. On a software renderer, each stage is finished
before the next one starts. The variants of a scene alternate in shuffled order, so that a drift of
the machine's speed affects all equally. Default: all lit scenes. The output is
results/benchmarks/stages.{md,csv}.
"""

from __future__ import annotations

import argparse
import csv
from collections.abc import Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from oitbench.gl.device import Device
from oitbench.gl.frame import START, Frame
from oitbench.gl.uploaded_scene import UploadedScene
from oitbench.measure.intervals import interval
from oitbench.measure.rounds import Schedule
from oitbench.measure.timing import OPAQUE_PICTURE
from oitbench.method.passes import Gather, Objects, Pass
from oitbench.plugins import Collection
from oitbench.results.times import Interval, Time
from oitbench.scene import Scene
from tests.benchmarks.timed import time_frames, write_ends

METHODS = {"1x1": "phenomenological", "4x4 sub.": "phenomenological[subsample=4]"}
PARTICLES, OTHERS, TOTAL = "OIT, particles", "OIT, others", "OIT"
FOG, RESOLVE, GAIN = "OIT, medium", "resolve", "particles, times faster"
OCCLUSION = "ambient occlusion"
SHADING = ("shadow maps", "variance maps", OCCLUSION, OPAQUE_PICTURE)
COLUMNS = (*SHADING, PARTICLES, OTHERS, FOG, TOTAL, RESOLVE, GAIN)
BUDGET = 120.0
"""Seconds per scene after which no further round starts, once enough are complete."""
OUT = Path("results/benchmarks")
ENDS = ("median", "low", "high")
Samples = dict[str, list[float]]


@dataclass(frozen=True)
class Row:
    """One variant of a scene: the time of each of its stages, in milliseconds."""

    scene: str
    variant: str
    stages: Mapping[str, Interval]

    @property
    def text(self) -> str:
        """The row in Markdown."""
        cells = {
            stage: f"{time.median:.2f} {write_ends(time)}".strip()
            for stage, time in self.stages.items()
        }
        return _line([self.scene, self.variant, *(cells.get(column, "") for column in COLUMNS)])


def stage_of(step: Pass, mixed: bool) -> str:
    """Return the stage of a pass; with `mixed`, particles are drawn separately."""
    if isinstance(step, Gather):
        separate = {Objects.PARTICLES: PARTICLES, Objects.OTHERS: OTHERS}
        return separate.get(step.objects, TOTAL) if mixed else OTHERS
    shrink = PARTICLES if mixed else FOG
    return {"fog": FOG, "fog small=1": FOG, "shrink_depth": shrink}.get(step.name, RESOLVE)


def sum_stages(frame: Frame, time: Time, mixed: bool) -> Samples:
    """Return the samples of each stage of a frame, in milliseconds, one per round."""
    stage_by_pass = {step.name: stage_of(step, mixed) for step in frame.plan.passes}
    stages: Samples = {}

    def add(stage: str, samples: Sequence[float]) -> None:
        known = stages.get(stage, [0.0] * len(samples))
        stages[stage] = [one + other for one, other in zip(known, samples, strict=True)]

    for part in time.passes:
        stage = TOTAL if part.name == START else stage_by_pass[part.name]
        add(stage, part.ms.samples)
        if stage in (PARTICLES, OTHERS, FOG):
            add(TOTAL, part.ms.samples)
    for part in time.shading:
        add(part.name if part.name in SHADING else OCCLUSION, part.ms.samples)
    return stages


def measure(device: Device, scene: Scene, size: tuple[int, int], rounds: int) -> dict[str, Samples]:
    """Return the samples of every stage by variant, one per round."""
    collection = Collection.load()
    with ExitStack() as stack:
        uploaded = stack.enter_context(UploadedScene(device, scene))
        mixed = uploaded.geometry.has(Objects.PARTICLES)
        frames = {}
        for name, text in METHODS.items():
            if name == "1x1" or mixed or scene.medium is not None:
                (method,) = collection.expand_methods([text])
                frame = Frame(uploaded, method, size, scene.effects & method.shows)
                frames[name] = stack.enter_context(frame)
                frame.render()
        times = time_frames(device, frames, Schedule(rounds, BUDGET))
        samples = {name: sum_stages(frames[name], time, mixed) for name, time in times.items()}
    if mixed:
        _compare(samples)
    return samples


def _compare(samples: dict[str, Samples]) -> None:
    """Add the time of the particles at full resolution, and its ratio to their time in blocks."""
    full, small = samples["1x1"], samples["4x4 sub."]
    # All other objects are drawn the same way in both variants, so their time is subtracted.
    others = np.median(small.get(OTHERS, [0.0])) + np.median(full.get(FOG, [0.0]))
    full[PARTICLES] = [value - float(others) for value in full[TOTAL]]
    # A slow variant takes part in fewer rounds.
    small[GAIN] = [
        one / other for one, other in zip(full[PARTICLES], small[PARTICLES], strict=False)
    ]


def rows_of(name: str, samples: Mapping[str, Samples]) -> list[Row]:
    """Return one row per variant."""
    return [
        Row(name, variant, {stage: interval(values) for stage, values in stages.items()})
        for variant, stages in samples.items()
    ]


def write(rows: list[Row], head: str) -> None:
    """Write all rows as Markdown and as CSV."""
    OUT.mkdir(parents=True, exist_ok=True)
    titles = ["scene", "particles", *COLUMNS]
    lines = [f"{head}; milliseconds: median [interval of at least 95 %]", ""]
    lines += [_line(titles), _line(["---"] * len(titles)), *(row.text for row in rows)]
    (OUT / "stages.md").write_text("\n".join([*lines, ""]), encoding="utf-8")
    with (OUT / "stages.csv").open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow([*titles[:2], *(f"{title} {end}" for title in COLUMNS for end in ENDS)])
        for row in rows:
            times = [row.stages.get(column) for column in COLUMNS]
            numbers = (getattr(time, end, "") for time in times for end in ENDS)
            writer.writerow([row.scene, row.variant, *numbers])


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

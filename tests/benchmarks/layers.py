"""Print and plot the method time of each method against the number of layers.

    python -m tests.benchmarks.layers [METHOD ...]

Layers of random depth cover a frame of 128×128 pixels. Their number doubles from 8 to 512. The
slope of a log-log fit is the order of growth: 1 is linear in the number of layers, 2 is quadratic.
The output is results/benchmarks/layers.{png,pdf,csv}.
"""

from __future__ import annotations

import csv
import sys
from pathlib import Path

import numpy as np

from oitbench.errors import CapabilityError
from oitbench.gl.device import Device
from oitbench.gl.frame import Frame
from oitbench.gl.uploaded_scene import UploadedScene
from oitbench.measure.rounds import Schedule
from oitbench.method.declaration import Method
from oitbench.plugins import Collection
from oitbench.report import figures, labels, palette
from tests.benchmarks.timed import time_frames

SIDE = 128
COUNTS = (8, 16, 32, 64, 128, 256, 512)
SCHEDULE = Schedule(rounds=9, budget=20.0)
TOO_LONG = 800.0
"""Method time, ms, above which a method is not measured with more layers."""
OUT = Path("results/benchmarks")
Times = dict[str, dict[int, float]]


def measure(methods: list[Method], collection: Collection) -> Times:
    """Return the median method times, ms, by method and number of layers."""
    device = Device()
    times: Times = {method.label: {} for method in methods}
    for count in COUNTS:
        scene = collection.build_scene(f"layer_stack[count={count},alpha=0.05,spacing=0.02]")
        uploaded = UploadedScene(device, scene)
        frames: dict[str, Frame] = {}
        for method in methods:
            if any(value > TOO_LONG for value in times[method.label].values()):
                continue
            try:
                frame = Frame(uploaded, method, (SIDE, SIDE), scene.effects & method.shows)
            except CapabilityError as error:
                print(f"left out: {error}")
                continue
            frame.render()
            frames[method.label] = frame
        for label, time in time_frames(device, frames, SCHEDULE).items():
            times[label][count] = time.method_ms.median
        for frame in frames.values():
            frame.release()
        uploaded.release()
    return times


def slope(times: dict[int, float]) -> float:
    """Return the exponent p of time ~ layers^p, from 32 layers up: below, fixed costs dominate."""
    counts = [count for count in times if count >= 32]
    x, y = np.log(np.array(counts, float)), np.log(np.array([times[count] for count in counts]))
    return float(np.polyfit(x, y, 1)[0])


def plot(times: Times, methods: list[Method]) -> None:
    """Draw all curves into one figure."""
    look = palette.styles(
        {method.label: method.name for method in methods},
        {method.name: method.family for method in methods},
    )
    with figures.canvas(9.4, 6.0) as figure:
        axes = figure.add_subplot()
        marks = []
        for label, points in times.items():
            style = look[label]
            xs, ys = list(points), list(points.values())
            axes.loglog(xs, ys, style.line, marker=style.marker, color=style.color, markersize=4)
            text = f"{label}  {slope(points):.2f}"
            marks.append(
                labels.Label(xs[-1], ys[-1], text, palette.ink(style.color), xs[-1], xs[-1])
            )
        axes.set_xticks(COUNTS, [str(count) for count in COUNTS])
        axes.set_xlim(COUNTS[0] * 0.9, COUNTS[-1] * 6)
        axes.set_xlabel("layers per pixel")
        axes.set_ylabel(f"method time at {SIDE}×{SIDE}, ms")
        curves = [(list(points), list(points.values())) for points in times.values()]
        labels.place(axes, marks, lines=curves)
        caption = "Method time against layers per pixel. The number is the fitted exponent."
        figures.save(figure, OUT / "layers", title="Cost of layers", caption=caption)


def main(texts: list[str]) -> None:
    """Measure, print and plot."""
    collection = Collection.load()
    methods = collection.expand_methods(texts or list(collection.methods))
    times = measure(methods, collection)
    OUT.mkdir(parents=True, exist_ok=True)
    with (OUT / "layers.csv").open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(["method", *(f"{count} layers, ms" for count in COUNTS), "slope"])
        for label, points in times.items():
            row = [label, *(f"{points[c]:.2f}" if c in points else "" for c in COUNTS)]
            row.append(f"{slope(points):.2f}")
            writer.writerow(row)
            print(f"{label:40} {' '.join(f'{value:>9}' for value in row[1:])}")
    plot(times, methods)
    print(f"written to {OUT}/layers.png")


if __name__ == "__main__":
    main(sys.argv[1:])

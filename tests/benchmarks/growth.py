"""Check that the memory of a process that renders does not grow.

    python -m tests.benchmarks.growth [--frames 1000] [--cells 4] [METHOD ...]

One process draws many frames of each method, and then renders and scores some cells of it. Before,
it does the same with few frames, which fills caches. The exit code is 1 if the resident memory
grows by 2 % or more, with one method or with all of them together. Default: all methods.
"""

from __future__ import annotations

import argparse
import gc
import sys
import tempfile
from contextlib import ExitStack
from itertools import pairwise
from pathlib import Path

import psutil

from oitbench.gl.frame import Frame
from oitbench.gl.uploaded_scene import UploadedScene
from oitbench.matrix.bench import Bench
from oitbench.matrix.cell import Cell
from oitbench.measure.clock import Clock, clock_of
from oitbench.measure.timing import time_method
from oitbench.method.declaration import Method
from oitbench.plugins import Collection
from oitbench.truths import EXACT

SCENE = "smoke_and_glass[detail=0.02]"
"""Particles, refraction, diffusion and shadows."""
SIZE = (48, 32)
LIMIT = 0.02
WARM_UP_FRAMES, WARM_UP_CELLS = 50, 2
TIMED, COUNTED = 5, 7
"""Every frame with a number that these divide is also timed by its parts, or counted."""
MEBIBYTE = 2**20


def resident() -> int:
    """Return the resident memory of this process in bytes."""
    gc.collect()
    return int(psutil.Process().memory_info().rss)


def draw(frame: Frame, clock: Clock, number: int) -> None:
    """Draw one frame in each of the ways that a run does."""
    frame.render(permutation=number if number % 2 else None)
    if number % TIMED == 0:
        time_method(frame, clock)
        clock.parts(frame.composite)
    if number % COUNTED == 0:
        frame.measure()


def work(bench: Bench, uploaded: UploadedScene, method: Method, frames: int, cells: int) -> None:
    """Draw frames of a method, and render and score cells."""
    effects = uploaded.scene.effects & method.shows
    with Frame(uploaded, method, SIZE, effects) as frame, clock_of(bench.device) as clock:
        for number in range(frames):
            draw(frame, clock, number)
    for _ in range(cells):
        record = bench.run(Cell(uploaded.scene.name, method.label, SIZE, truths=(EXACT,)))
        assert record.status == "ok", record.reason


def main() -> int:
    """Measure and print; return the exit code."""
    parser = argparse.ArgumentParser()
    parser.add_argument("methods", nargs="*")
    parser.add_argument("--frames", type=int, default=1000)
    parser.add_argument("--cells", type=int, default=4)
    options = parser.parse_args()
    collection = Collection.load()
    methods = collection.expand_methods(options.methods or list(collection.methods))
    with ExitStack() as stack:
        folder = Path(stack.enter_context(tempfile.TemporaryDirectory()))
        bench = stack.enter_context(Bench(collection, folder))
        scene = collection.build_scene(SCENE)
        uploaded = stack.enter_context(UploadedScene(bench.device, scene))
        for method in methods:
            work(bench, uploaded, method, WARM_UP_FRAMES, WARM_UP_CELLS)
        sizes = [resident()]
        print(f"{'method':32} {'memory, MiB':>12} {'growth':>8}")
        for method in methods:
            work(bench, uploaded, method, options.frames, options.cells)
            sizes.append(resident())
            growth = sizes[-1] / sizes[-2] - 1
            print(f"{method.label:32} {sizes[-1] / MEBIBYTE:12.1f} {growth:8.2%}", flush=True)
    total = sizes[-1] / sizes[0] - 1
    print(f"{'all':32} {sizes[-1] / MEBIBYTE:12.1f} {total:8.2%}")
    return int(max(total, *(after / before - 1 for before, after in pairwise(sizes))) >= LIMIT)


if __name__ == "__main__":
    sys.exit(main())

"""Print the time and the work of the exact methods as ratios to alpha blending.

    python -m tests.benchmarks.exact [--rounds 9] [--size 512] [METHOD ...]

The scene is that of `tests.benchmarks.speed`: 32 overlapping quads, 3.4 million fragments at
512×512. In each round every method draws one frame, after one of alpha blending. A ratio is the
median over the rounds, beside the ratio of the shortest times. On a software renderer, the time is
that of the CPU over all threads, which other processes disturb less than the wall clock; on a GPU,
it is the GPU's own. Geometry passes, memory and traffic are counted in a frame of their own.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Hashable

import numpy as np

from oitbench.gl.device import Device
from oitbench.gl.frame import Frame
from oitbench.gl.uploaded_scene import UploadedScene
from oitbench.measure import accounting
from oitbench.measure.clock import Clock, WallClock, clock_of
from oitbench.measure.timing import time_method
from oitbench.method.declaration import Method
from oitbench.method.passes import Gather
from oitbench.plugins import Collection
from tests.benchmarks.speed import BASE, frames_of, overlapping_quads

METHODS = (
    "a_buffer[node=compact,precise,storage=counted,linked]",
    "depth_peeling",
    "dual_depth_peeling",
)
Samples = dict[str, list[float]]


def sample(frames: dict[str, Frame], clock: Clock, rounds: int) -> tuple[Samples, Samples]:
    """Return the times of all frames, and of their parts by "METHOD: PASS", in milliseconds."""
    whole: Samples = {name: [] for name in frames}
    parts: Samples = {}
    for number in range(rounds + 1):
        for name, frame in frames.items():
            taken = time_method(frame, clock).ms
            frame.restore()
            laps = clock.parts(frame.composite).ms
            if number == 0:  # warm-up
                continue
            whole[name].append(taken)
            for key, ms in laps.items():
                parts.setdefault(f"{name}: {_part(frame, key)}", []).append(ms)
    return whole, parts


def _part(frame: Frame, key: Hashable) -> str:
    return frame.plan.parts[key] if isinstance(key, int) else str(key)


def ratio(samples: list[float], base: list[float]) -> str:
    """Return the median of the ratios, and the ratio of the shortest times."""
    median = np.median(np.array(samples) / np.array(base))
    return f"{median:8.2f}x {min(samples) / min(base):8.2f}x"


def work(uploaded: UploadedScene, method: Method, size: tuple[int, int]) -> str:
    """Return the geometry passes, the memory and the traffic of a method."""
    effects = uploaded.scene.effects & method.shows
    with Frame(uploaded, method, size, effects, counted=True) as frame:
        frame.render()
        measured = frame.measure()
        pairs = zip(frame.plan.passes, measured.passes, strict=True)
        passes = sum(record.runs for step, record in pairs if isinstance(step, Gather))
        moved = accounting.traffic(frame, measured).bytes / int(frame.complexity.sum())
        held = accounting.memory(frame).bits_per_pixel / 8
    return f"{passes:7d} {held:12.0f} {moved:16.0f}"


def main() -> None:
    """Measure, and print the table."""
    parser = argparse.ArgumentParser()
    parser.add_argument("methods", nargs="*", default=METHODS)
    parser.add_argument("--rounds", type=int, default=9)
    parser.add_argument("--size", type=int, default=512)
    options = parser.parse_args()
    device, size = Device(), (options.size, options.size)
    with UploadedScene(device, overlapping_quads()) as uploaded, clock_of(device) as gpu:
        clock: Clock = WallClock(device.finish, time.process_time) if device.software else gpu
        names = [BASE, *options.methods]
        methods = {found.label: found for found in Collection.load().expand_methods(names)}
        frames = frames_of(uploaded, names, size)
        fragments = int(frames[BASE].complexity.sum())
        print(f"{device.renderer}: {options.size}², {fragments / 1e6:.2f} M fragments")
        whole, parts = sample(frames, clock, options.rounds)
        print(f"{'':48}{'median':>9} {'shortest':>9}  passes  bytes/pixel  bytes/fragment")
        for name, samples in whole.items():
            print(f"{name:48}{ratio(samples, whole[BASE])} {work(uploaded, methods[name], size)}")
            for key, laps in parts.items():
                owner, _, part = key.partition(": ")
                if owner == name:
                    print(f"    {part:44}{ratio(laps, whole[BASE])}")


if __name__ == "__main__":
    main()

"""Print method times as ratios to alpha blending. This is a script to run by hand, not a test.

    python -m tests.benchmarks.speed [METHOD ...]

The scene has 32 overlapping quads at 512×512 pixels, about 3.4 million fragments. All methods are
timed in shuffled rounds of one run, so that a drift of the machine's speed affects all equally.
"""

from __future__ import annotations

import subprocess
import sys
import time
from unittest.mock import patch

import moderngl
import numpy as np

from oitbench.gl.device import Device
from oitbench.gl.frame import Frame
from oitbench.gl.uploaded_scene import UploadedScene
from oitbench.measure.rounds import Schedule
from oitbench.plugins import Collection
from oitbench.results.times import Time
from oitbench.scene import Camera, Material, Mesh, Object, Scene
from tests.benchmarks.timed import time_frames, write_ends

SIZE = (512, 512)
BASE = "alpha_blend"
METHODS = (BASE, "weighted_blended", "sorted_over", "sorted_two_pass", "a_buffer[node=compact]")
SCHEDULE = Schedule(rounds=21, budget=120.0)


def overlapping_quads(count: int = 32, seed: int = 1) -> Scene:
    """Return quads at random places and distances, each of 40 % of the frame's area."""
    generator = np.random.default_rng(seed)
    objects = []
    for index in range(count):
        distance = generator.uniform(2, 20)
        half = 0.635 * distance
        center = generator.uniform(-0.36, 0.36, 2) * distance
        corners = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)]) * half + center
        positions = np.concatenate([corners, np.full((4, 1), -distance)], axis=1)
        mesh = Mesh(positions.astype(np.float32), np.array([(0, 1, 2), (0, 2, 3)], dtype=np.uint32))
        red, green, blue = (float(value) for value in generator.uniform(0, 1, 3))
        alpha = float(generator.uniform(0.1, 0.9))
        objects.append(Object(f"quad {index}", mesh, Material(alpha, emission=(red, green, blue))))
    camera = Camera((0, 0, 0), (0, 0, -1), fov_y=np.pi / 2)
    return Scene("quads", camera, tuple(objects), background=(0.5, 0.5, 0.5))


def frames_of(uploaded: UploadedScene, names: list[str], size: tuple[int, int]) -> dict[str, Frame]:
    """Return a frame of each method that has been rendered once."""
    frames = {}
    for method in Collection.load().expand_methods(names):
        effects = uploaded.scene.effects & method.shows
        frames[method.label] = Frame(uploaded, method, size, effects)
        frames[method.label].render()
    return frames


def main(names: list[str]) -> None:
    """Measure, and print the table."""
    device = Device()
    uploaded = UploadedScene(device, overlapping_quads())
    names = [BASE, *(name for name in names or METHODS if name != BASE)]
    frames = frames_of(uploaded, names, SIZE)
    fragments = int(frames[BASE].complexity.sum())
    print(f"{device.renderer}: {SIZE[0]}x{SIZE[1]}, {fragments / 1e6:.2f} M fragments")
    timings = time_frames(device, frames, SCHEDULE)
    tiny = frames_of(uploaded, names, (1, 1))
    # Without draws, a frame consists of Python code and changes of OpenGL state.
    with patch.object(moderngl.VertexArray, "render", lambda *_, **__: None):
        shares = time_frames(device, tiny, SCHEDULE)
    base = np.array(timings[BASE].method_ms.samples)
    print(f"{'method':34} {'ms':>8} {'interval':>20} {'sort ms':>8} {'ratio':>8} {'python ms':>10}")
    for name, item in timings.items():
        samples = np.array(item.method_ms.samples)
        ratio = float(np.median(samples / base[: len(samples)]))
        sort = f"{item.sort_ms.median:.2f}" if item.sort_ms else ""
        print(
            f"{name:34} {item.method_ms.median:8.2f} {write_ends(item.method_ms):>20} {sort:>8}"
            f" {ratio:7.2f}x {shares[name].method_ms.median:10.2f}"
        )
        print(*parts_of(item), sep="\n")
    seconds = []
    for _ in range(5):
        start = time.perf_counter()
        subprocess.run([sys.executable, "-m", "oitbench", "list"], check=True, capture_output=True)
        seconds.append(time.perf_counter() - start)
    print(f"oitbench list: {np.median(seconds):.2f} s")


def parts_of(time: Time) -> list[str]:
    """Return one line per part of the drawing, timed alone, and the remark on their sum."""
    lines = [f"    {part.name:30} {part.ms.median:8.2f} ms" for part in time.passes]
    return [*lines, f"    {time.remark}"] if time.remark else lines


if __name__ == "__main__":
    main(sys.argv[1:])

"""Print frame times as ratios to alpha blending. This is a script to run by hand, not a test.

    python tests/benchmarks/speed.py [METHOD ...]

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
from oitbench.measure import timing
from oitbench.plugins import Collection
from oitbench.scene import Camera, Material, Mesh, Object, Scene

SIZE = (512, 512)
BASE = "alpha_blend"
METHODS = (BASE, "weighted_blended", "sorted_over", "sorted_two_pass", "a_buffer[node=compact]")
ROUNDS = 21


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
    timings = timing.measure(frames, ROUNDS, budget=120)
    tiny = frames_of(uploaded, names, (1, 1))
    # Without draws, a frame consists of Python code and changes of OpenGL state.
    with patch.object(moderngl.VertexArray, "render", lambda *_, **__: None):
        shares = timing.measure(tiny, ROUNDS, budget=10)
    base = np.array(timings[BASE].frame_ms)
    print(f"{'method':34} {'ms':>8} {'low':>8} {'high':>8} {'ratio':>7} {'python ms':>10}")
    for name, item in timings.items():
        facts = timing.interval(item.frame_ms)
        ratio = float(np.median(np.array(item.frame_ms) / base))
        share = float(np.median(shares[name].frame_ms))
        print(
            f"{name:34} {facts.median:8.2f} {facts.low:8.2f} {facts.high:8.2f}"
            f" {ratio:6.2f}x {share:10.2f}"
        )
        for record in passes_of(frames[name]):
            print(f"    {record}")
    seconds = []
    for _ in range(5):
        start = time.perf_counter()
        subprocess.run([sys.executable, "-m", "oitbench", "list"], check=True, capture_output=True)
        seconds.append(time.perf_counter() - start)
    print(f"oitbench list: {np.median(seconds):.2f} s")


def passes_of(frame: Frame) -> list[str]:
    """Return one line per pass with its time; each pass is finished before the next one starts."""
    passes = frame.measure().passes
    return [f"{record.name:20} {record.milliseconds:8.2f} ms" for record in passes]


if __name__ == "__main__":
    main(sys.argv[1:])

"""Print how far exact compositing by OpenGL is from the matched reference, scene by scene.

    python -m tests.benchmarks.matched [--side N] [--ssaa N] [--shading SETTINGS ...] [SCENE ...]

For each scene: FLIP without shadows, FLIP with them under each combination of settings, and the
seconds of both references. Refraction and diffusion are left out, as exact compositing does not
express them. Ambient occlusion has a line of its own. Below each row: the memory of shared shading
in MiB, and its time relative to the first settings.
"""

from __future__ import annotations

import argparse
import time
from dataclasses import dataclass

from oitbench.effects import Effect
from oitbench.gl.device import Device
from oitbench.image import metrics
from oitbench.image.files import Image, box_downsample
from oitbench.path_traced.matched.render import matched
from oitbench.plugins import Collection
from oitbench.scene import Scene
from oitbench.shading import DEFAULT, ShadingSettings, parse_shading
from tests.helpers import opened

SCENES = (
    "glass_bars", "layer_stack", "bottles", "frosted_panes", "shadow_trio", "foliage",
    "foliage[light=sky]", "smoke_ball", "clouds",
)  # fmt: skip
_SHADOWS = Effect.SHADOWS | Effect.TRANSLUCENT_SHADOWS | Effect.COLORED_SHADOWS | Effect.CAUSTICS
_OCCLUSION = Effect.AMBIENT_OCCLUSION | Effect.INFERRED_AO
_LEFT_OUT = Effect.REFRACTION | Effect.DIFFUSION | Effect.CAUSTICS
_MEBIBYTE = 2**20
_TIMED = 3


@dataclass(frozen=True)
class Drawn:
    """A picture by OpenGL; bytes of shared shading, and the least seconds that it takes."""

    picture: Image
    bytes: int
    seconds: float


def draw(
    device: Device,
    scene: Scene,
    effects: Effect,
    size: tuple[int, int],
    ssaa: int,
    settings: ShadingSettings = DEFAULT,
) -> Drawn:
    """Draw a scene by exact compositing."""
    fine = size[0] * ssaa, size[1] * ssaa
    with opened(device, scene, "a_buffer", fine, effects, settings=settings) as frame:
        frame.render()
        times = []
        for _ in range(_TIMED):
            device.finish()
            started = time.perf_counter()
            frame.shade()
            device.finish()
            times.append(time.perf_counter() - started)
        size_ = sum(count for stage in frame.shading for _, count in stage.memory())
        return Drawn(box_downsample(frame.image(), ssaa), size_, min(times))


def reference(
    scene: Scene, effects: Effect, size: tuple[int, int], ssaa: int
) -> tuple[Image, float]:
    """Return the matched reference, and its seconds."""
    started = time.perf_counter()
    truth = matched(scene, size, ssaa, effects)
    return truth, time.perf_counter() - started


def flip(picture: Image, truth: Image, exposure: float) -> float:
    """Return FLIP of the displayed pictures."""
    error = metrics.flip_ldr(picture, truth, exposure)
    assert error is not None
    return error


def main() -> None:
    parser = argparse.ArgumentParser(description="exact compositing against matched references")
    parser.add_argument("scenes", nargs="*", default=SCENES)
    parser.add_argument("--side", type=int, default=96)
    parser.add_argument("--ssaa", type=int, default=2)
    parser.add_argument("--shading", action="append", default=[])
    chosen = parser.parse_args()
    settings = [one for text in chosen.shading or [""] for one in parse_shading([text])]
    device, collection = Device(), Collection.load()
    names = [one.label or "default" for one in settings]
    width = max(10, *(len(name) + 2 for name in names))
    print(f"{'scene':32}{'off':>8}" + "".join(f"{name:>{width}}" for name in names) + "  seconds")
    for label in chosen.scenes:
        scene = collection.build_scene(label)
        size = chosen.side, chosen.side
        effects = scene.effects & ~_LEFT_OUT
        rows = {label: effects & ~_OCCLUSION}
        if effects & _OCCLUSION:
            rows[f"{label}, occlusion"] = effects
        for row, running in rows.items():
            plain, fast = reference(scene, running & ~_SHADOWS, size, chosen.ssaa)
            truth, slow = reference(scene, running, size, chosen.ssaa)
            unshadowed = draw(device, scene, running & ~_SHADOWS, size, chosen.ssaa)
            off = flip(unshadowed.picture, plain, scene.exposure)
            found = [draw(device, scene, running, size, chosen.ssaa, one) for one in settings]
            on = [flip(one.picture, truth, scene.exposure) for one in found]
            values = "".join(f"{error:{width}.4f}" for error in on)
            print(f"{row:32}{off:8.4f}{values}{fast:7.1f}{slow:6.1f}", flush=True)
            for name, parts in {
                "memory, MiB": [f"{one.bytes / _MEBIBYTE:.1f}" for one in found],
                "time": [f"{one.seconds / max(found[0].seconds, 1e-9):.2f}" for one in found],
            }.items():
                print(f"  {name:38}" + "".join(f"{part:>{width}}" for part in parts))


if __name__ == "__main__":
    main()

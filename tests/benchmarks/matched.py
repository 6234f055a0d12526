"""Print how far exact compositing by OpenGL is from the matched reference, scene by scene.

    python -m tests.benchmarks.matched [--side N] [--ssaa N] [SCENE ...]

For each scene: FLIP without shadows, FLIP with them, and the seconds of both references. Refraction
and diffusion are left out, as exact compositing does not express them. Ambient occlusion has a line
of its own.
"""

from __future__ import annotations

import argparse
import time

from oitbench.effects import Effect
from oitbench.gl.device import Device
from oitbench.image import metrics
from oitbench.image.files import box_downsample
from oitbench.path_traced.matched.render import matched
from oitbench.plugins import Collection
from oitbench.scene import Scene
from tests.helpers import opened

SCENES = (
    "glass_bars", "layer_stack", "bottles", "frosted_panes", "shadow_trio", "foliage",
    "foliage[light=sky]", "smoke_ball", "clouds",
)  # fmt: skip
_SHADOWS = Effect.SHADOWS | Effect.TRANSLUCENT_SHADOWS | Effect.COLORED_SHADOWS | Effect.CAUSTICS
_OCCLUSION = Effect.AMBIENT_OCCLUSION | Effect.INFERRED_AO
_LEFT_OUT = Effect.REFRACTION | Effect.DIFFUSION | Effect.CAUSTICS


def compare(
    device: Device, scene: Scene, effects: Effect, size: tuple[int, int], ssaa: int
) -> tuple[float, float]:
    """Return FLIP between exact compositing and the matched reference, and its seconds."""
    fine = size[0] * ssaa, size[1] * ssaa
    with opened(device, scene, "a_buffer", fine, effects) as frame:
        frame.render()
        picture = box_downsample(frame.image(), ssaa)
    started = time.perf_counter()
    truth = matched(scene, size, ssaa, effects)
    seconds = time.perf_counter() - started
    error = metrics.flip_ldr(picture, truth, scene.exposure)
    assert error is not None
    return error, seconds


def main() -> None:
    parser = argparse.ArgumentParser(description="exact compositing against matched references")
    parser.add_argument("scenes", nargs="*", default=SCENES)
    parser.add_argument("--side", type=int, default=96)
    parser.add_argument("--ssaa", type=int, default=2)
    chosen = parser.parse_args()
    device, collection = Device(), Collection.load()
    print(f"{'scene':32}{'off':>8}{'on':>8}{'s off':>8}{'s on':>8}")
    for label in chosen.scenes:
        scene = collection.build_scene(label)
        size = chosen.side, chosen.side
        effects = scene.effects & ~_LEFT_OUT
        rows = {label: effects & ~_OCCLUSION}
        if effects & _OCCLUSION:
            rows[f"{label}, occlusion"] = effects
        for row, running in rows.items():
            off, fast = compare(device, scene, running & ~_SHADOWS, size, chosen.ssaa)
            on, slow = compare(device, scene, running, size, chosen.ssaa)
            print(f"{row:32}{off:8.4f}{on:8.4f}{fast:8.1f}{slow:8.1f}", flush=True)


if __name__ == "__main__":
    main()

"""Print what four samples per pixel change, for all methods that have them, in one scene.

    python -m tests.benchmarks.samples [--size WxH] [--scene SCENE] [METHOD ...]

For each method: FLIP of its pictures of one sample and of four against exact compositing of 16
sub-pixels, FLIP of four samples against exact compositing of the same samples, and the memory of
both pictures in MiB. The first number of a row falls to the second by antialiasing. The third is
the error of compositing and, for methods that shade each sample, the difference that this makes.
"""

from __future__ import annotations

import argparse

from oitbench.gl.device import Device
from oitbench.gl.frame import Image
from oitbench.image import metrics
from oitbench.image.files import box_downsample
from oitbench.measure import accounting
from oitbench.method.declaration import Method
from oitbench.plugins import Collection
from oitbench.scene import Scene
from tests.helpers import opened

SUB_PIXELS = 4
SAMPLES = (1, 4)
_MEBIBYTE = 2**20


def with_samples(method: Method, count: int) -> Method:
    """Return the method with that many samples per pixel."""
    return type(method)(**{**method.values, "msaa": count})


def draw(
    device: Device, scene: Scene, method: Method, size: tuple[int, int]
) -> tuple[Image, float]:
    """Return a picture, and its memory in MiB."""
    with opened(device, scene, method, size) as frame:
        frame.render()
        return frame.image(), accounting.memory(frame).bytes / _MEBIBYTE


def main() -> None:
    parser = argparse.ArgumentParser(description="one and four samples per pixel")
    parser.add_argument("methods", nargs="*")
    parser.add_argument("--scene", default="power_plant")
    parser.add_argument("--size", default="320x180")
    chosen = parser.parse_args()
    width, height = map(int, chosen.size.split("x"))
    device, collection = Device(), Collection.load()
    scene, truth = collection.build_scene(chosen.scene), collection.truth()
    named = chosen.methods or [
        name
        for name, kind in collection.methods.items()
        if "msaa" in kind.parameters and set(SAMPLES) <= set(kind.parameters["msaa"].choices)
    ]
    fine, _ = draw(device, scene, truth, (width * SUB_PIXELS, height * SUB_PIXELS))
    smooth = box_downsample(fine, SUB_PIXELS)
    exact, _ = draw(device, scene, with_samples(truth, SAMPLES[1]), (width, height))

    def error(right: Image, found: Image) -> str:
        value = metrics.flip_ldr(right, found, scene.exposure)
        return "–" if value is None else f"{value:.4f}"

    print("| method | 1 sample | 4 samples | same samples | MiB of 1 | MiB of 4 |")
    print("| --- | --- | --- | --- | --- | --- |")
    for method in collection.expand_methods(named):
        drawn = [
            draw(device, scene, with_samples(method, count), (width, height)) for count in SAMPLES
        ]
        (one, least), (four, most) = drawn
        errors = (error(smooth, one), error(smooth, four), error(exact, four))
        cells = [f"`{method.label}`", *errors, f"{least:.2f}", f"{most:.2f}"]
        print(f"| {' | '.join(cells)} |", flush=True)


if __name__ == "__main__":
    main()

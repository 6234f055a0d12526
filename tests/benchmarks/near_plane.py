"""Print the error of phenomenological transparency over the distance of the near plane.

    python -m tests.benchmarks.near_plane [--size 128x128] [SCENE ...]

Equation 5 of McGuire & Mara 2017 weighs layers by their window depth, which depends on the near
plane. At view distances far beyond it, all layers weigh the same. Each scene is drawn with its own
near plane and with farther ones, by equation 5 and by the weight of the authors' engine. The number
is FLIP to exact compositing of the same fragments, without the effects that exact compositing does
not draw. A scene's row ends where the near plane clips its picture. Default: all scenes.
The output is results/benchmarks/near_plane.csv.
"""

from __future__ import annotations

import argparse
import csv
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

from oitbench.gl.device import Device
from oitbench.gl.frame import Frame
from oitbench.gl.uploaded_scene import UploadedScene
from oitbench.image.files import Image
from oitbench.image.metrics import flip_ldr
from oitbench.method.declaration import Method
from oitbench.plugins import Collection
from oitbench.scene import Scene

EXACT = "a_buffer"
WEIGHTS = {"equation 5": "eq5", "engine": "g3d"}
FACTORS = (0.1, 0.3, 1, 3, 10, 30)
"""Near planes, in multiples of the scene's own."""
CLIPPED = 1e-3
"""FLIP between exact pictures above which the near plane has cut something off."""
OUT = Path("results/benchmarks/near_plane.csv")


@dataclass(frozen=True)
class Row:
    """FLIP of one weight in one scene at one near plane, in meters."""

    scene: str
    near: float
    weight: str
    flip: float


def draw(uploaded: UploadedScene, method: Method, size: tuple[int, int], exact: Method) -> Image:
    """Return the picture with the effects that both methods draw."""
    effects = uploaded.scene.effects & method.shows & exact.shows
    with Frame(uploaded, method, size, effects) as frame:
        frame.render()
        return frame.image()


def sweep(device: Device, scene: Scene, size: tuple[int, int]) -> Iterator[Row]:
    """Yield the errors of a scene, near planes from near to far."""
    collection = Collection.load()
    (exact,) = collection.expand_methods([EXACT])
    names = [f"phenomenological[depth_weight={value}]" for value in WEIGHTS.values()]
    methods = dict(zip(WEIGHTS, collection.expand_methods(names), strict=True))
    unclipped: Image | None = None
    for factor in FACTORS:
        near = scene.camera.near * factor
        moved = replace(scene, camera=replace(scene.camera, near=near))
        with UploadedScene(device, moved) as uploaded:
            truth = draw(uploaded, exact, size, exact)
            unclipped = truth if unclipped is None else unclipped
            change = flip_ldr(unclipped, truth, scene.exposure)
            if change is None or change > CLIPPED:
                return
            for weight, method in methods.items():
                error = flip_ldr(truth, draw(uploaded, method, size, exact), scene.exposure)
                if error is not None:
                    yield Row(scene.name, near, weight, error)


def main() -> None:
    """Measure, print and write."""
    parser = argparse.ArgumentParser()
    parser.add_argument("scenes", nargs="*")
    parser.add_argument("--size", default="128x128")
    options = parser.parse_args()
    width, height = (int(side) for side in options.size.split("x"))
    device, collection = Device(), Collection.load()
    OUT.parent.mkdir(parents=True, exist_ok=True)
    with OUT.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(["scene", "near, m", "weight", "FLIP to exact compositing"])
        for name in options.scenes or list(collection.scenes):
            for row in sweep(device, collection.build_scene(name), (width, height)):
                cells = [row.scene, f"{row.near:g}", row.weight, f"{row.flip:.4f}"]
                print(f"| {' | '.join(cells)} |", flush=True)
                writer.writerow(cells)
    print(f"written to {OUT}")


if __name__ == "__main__":
    main()

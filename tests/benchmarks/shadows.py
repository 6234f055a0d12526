"""Plot the light inside smoke by each form of translucent shadows, and print its noise.

    python -m tests.benchmarks.shadows [--out FILE]

The smoke is a stack of equal layers. A wall that stands along the light shows how much of it
arrives at each depth: rows of the picture are depths, and columns are texels of the maps. The noise
is the root of the mean squared deviation of V below a pane that lets half of the light pass.
"""

from __future__ import annotations

import argparse
import math
from pathlib import Path

import numpy as np

from oitbench.gl.device import Device
from oitbench.modeling.mesh import quad
from oitbench.report import figures
from oitbench.scene import Camera, DirectionalLight, Floats, Material, Object, Scene
from oitbench.shading import OCCLUDERS, PUBLISHED, SLICES, ShadingSettings
from tests.helpers import Empty, opened
from tests.models.shadows import occluder_light, traced_light

LAYERS, COVERAGE = 120, 0.025
TOP, BOTTOM = 2.0, 0.0
_SIDE = 128
_FORMS = {
    PUBLISHED: "published: moments include the floor",
    OCCLUDERS: "occluders: moments of smoke alone",
    SLICES: "slices",
}


def heights() -> Floats:
    """Return the heights of the layers, from the light down; most are in the middle."""
    random = np.random.default_rng(1)
    places = np.clip(random.normal(1.0, 0.3, LAYERS), BOTTOM + 0.1, TOP - 0.1)
    return np.sort(places)[::-1]


def smoke(layers: Floats, coverage: float) -> Scene:
    """Return layers of smoke above a far floor, and a wall through them along the light."""
    vapor = Material(coverage=coverage, albedo=(1, 1, 1), isotropic=True)
    casters = [
        Object(f"layer {k}", quad((0, y, 0), (1.5, 0, 0), (0, 0, -1.5)), vapor)
        for k, y in enumerate(layers.tolist())
    ]
    wall = Object(
        "wall",
        quad((0, 1, 0), (1, 0, 0), (0, 1, 0)),
        Material(albedo=(1, 1, 1), isotropic=True),
        casts=False,
    )
    floor = Object("floor", quad((0, -20, 0), (9, 0, 0), (0, 0, -9)), Material(), casts=False)
    camera = Camera((0, 1, 200), (0, 1, 0), fov_y=2 * math.atan(1 / 200))
    sun = DirectionalLight((0, -1, 0), (4 * math.pi,) * 3)
    return Scene("smoke", camera, (wall, floor, *casters), lights=(sun,))


def light(device: Device, scene: Scene, form: str) -> Floats:
    """Return V on the wall, shape (rows, columns)."""
    settings = ShadingSettings(form)
    with opened(
        device, scene, Empty(), (_SIDE, _SIDE), effects=scene.effects, settings=settings
    ) as frame:
        frame.render()
        return np.asarray(frame.image()[..., 0], dtype=np.float64)


def noise_of(device: Device, form: str) -> float:
    """Return the root of the mean squared deviation of V on a floor below a pane, where V = 0.5."""
    floor = Object(
        "floor", quad((0, 0, 0), (3, 0, 0), (0, 0, -3)), Material(albedo=(1, 1, 1)), casts=False
    )
    pane = Object("pane", quad((0, 1, 0), (1.5, 0, 0), (0, 0, -1.5)), Material(coverage=0.5))
    camera = Camera((0, 6, 0), (0, 0, 0), up=(0, 0, -1), fov_y=math.radians(10))
    sun = DirectionalLight((0, -1, 0), (math.pi,) * 3)
    shown = light(device, Scene("pane", camera, (floor, pane), lights=(sun,)), form)
    return float(np.sqrt(((shown - 0.5) ** 2).mean()))


def main() -> None:
    parser = argparse.ArgumentParser(description="light inside smoke by forms of shadows")
    parser.add_argument("--out", type=Path, default=Path("shadows"))
    chosen = parser.parse_args()
    device, layers = Device(), heights()
    scene = smoke(layers, COVERAGE)
    taus = [1 - COVERAGE] * LAYERS
    rows = TOP - (np.arange(_SIDE) + 0.5) / _SIDE * (TOP - BOTTOM)
    depth = TOP - rows
    ends = [-y for y in layers.tolist()]
    traced = [traced_light(ends, taus, -y) for y in rows.tolist()]
    middle = [occluder_light(ends, taus, -y, own=0.5) for y in rows.tolist()]
    print(f"{'form':12}{'rms of V = 0.5':>16}{'mean |V - traced|':>20}")
    with figures.canvas(7.0, 4.0) as canvas:
        axes = canvas.add_subplot()
        axes.plot(depth, traced, color="black", linewidth=2.2, label="traced")
        for form, name in _FORMS.items():
            shown = light(device, scene, form)
            mean, noise = shown.mean(axis=1), shown.std(axis=1)
            (line,) = axes.plot(depth, mean, label=name, linewidth=1.4)
            axes.fill_between(
                depth, mean - noise, mean + noise, color=line.get_color(), alpha=0.25, linewidth=0
            )
            print(f"{form:12}{noise_of(device, form):16.4f}{abs(mean - traced).mean():20.4f}")
        axes.plot(depth, middle, "--", linewidth=1.2, label="occluders, for particles (model)")
        axes.set(xlabel="depth in the smoke, m", ylabel="V", xlim=(0, TOP - BOTTOM), ylim=(0, 1.03))
        axes.legend(frameon=False)
        saved = figures.save(
            canvas,
            chosen.out,
            title="Light inside smoke",
            caption="V over depth below a sun; bands show the deviation over the map's texels.",
        )
    print(saved)


if __name__ == "__main__":
    main()

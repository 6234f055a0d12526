"""Scenes, frames and error bounds that several tests share."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from oitbench.effects import Effect
from oitbench.gl.device import Device
from oitbench.gl.frame import Frame, Image
from oitbench.gl.uploaded_scene import UploadedScene
from oitbench.method import steps
from oitbench.method.declaration import Method, Plan, Request
from oitbench.method.passes import Gather, Pass
from oitbench.method.storage import Target
from oitbench.plugins import Collection
from oitbench.scene import RGB, Camera, FragmentLists, Scene
from oitbench.stability import suite
from oitbench.stability.identities import identities

SIDE = 16
"""Width and height of the small frames, in pixels."""
BACKGROUND: RGB = (0.35, 0.6, 0.85)
RED: RGB = (1.0, 0.0, 0.0)
GREEN: RGB = (0.0, 1.0, 0.0)
BLUE: RGB = (0.0, 0.0, 1.0)
NOTHING: RGB = (0.0, 0.0, 0.0)
WHITE: RGB = (1.0, 1.0, 1.0)


@dataclass(frozen=True)
class Layer:
    """One fragment: view distance z in meters, coverage, radiance, transmission."""

    z: float
    coverage: float
    radiance: RGB = WHITE
    transmission: RGB = NOTHING


class Empty(Method):
    """Shows the opaque picture, in full precision."""

    name = "empty"

    def plan(self, request: Request) -> Plan:
        return Plan({"color": Target("rgba32f")})


@cache
def collection() -> Collection:
    return Collection.load()


def method(text: str) -> Method:
    (found,) = collection().expand_methods([text])
    return found


def stranger(text: str) -> Method:
    """Return a method of a folder, which the other tests' collection does not learn of."""
    (found,) = Collection.load().expand_methods([text])
    return found


def scene_of(lists: FragmentLists, background: RGB = BACKGROUND) -> Scene:
    camera = Camera(position=(0, 0, 0), target=(0, 0, -1), near=0.1)
    return Scene("lists", camera, lists=lists, background=background)


def stack(layers: Sequence[Layer], side: int = SIDE) -> FragmentLists:
    """Return the same list in every pixel, in the order given."""
    shape = (len(layers), side, side)

    def spread(values: Sequence[Any]) -> npt.NDArray[np.float32]:
        rows = np.asarray(values, dtype=np.float32)
        return np.broadcast_to(rows[:, None, None], (*shape, *rows.shape[1:])).copy()

    return FragmentLists(
        spread([layer.z for layer in layers]),
        spread([layer.coverage for layer in layers]),
        spread([layer.radiance for layer in layers]),
        spread([layer.transmission for layer in layers]),
    )


def random_lists(
    count: int, tinted: bool = False, seed: int = 1, side: int = SIDE
) -> FragmentLists:
    """Return planes at distinct distances, in random order, of random content in every pixel."""
    random = np.random.default_rng(seed)
    shape = (count, side, side)
    planes = random.permutation(np.linspace(2, 6, count, dtype=np.float32))
    z = np.broadcast_to(planes[:, None, None], shape).copy()
    transmission = random.random((*shape, 3), dtype=np.float32) if tinted else np.zeros((*shape, 3))
    return FragmentLists(
        z,
        random.uniform(0.2, 0.8, shape).astype(np.float32),
        random.random((*shape, 3), dtype=np.float32),
        transmission.astype(np.float32),
    )


@contextmanager
def opened(
    device: Device,
    scene: Scene,
    chosen: Method | str,
    size: tuple[int, int] | None = None,
    effects: Effect | None = None,
    **options: Any,
) -> Iterator[Frame]:
    """Yield a frame that has not been rendered yet; what it holds is freed afterwards."""
    chosen = method(chosen) if isinstance(chosen, str) else chosen
    if size is None:
        assert scene.lists is not None
        size = (scene.lists.z.shape[2], scene.lists.z.shape[1])
    running = scene.effects & chosen.shows if effects is None else effects
    with (
        UploadedScene(device, scene) as uploaded,
        Frame(uploaded, chosen, size, running, **options) as frame,
    ):
        yield frame


def render(
    device: Device,
    scene: Scene | FragmentLists,
    chosen: Method | str,
    permutation: int | None = None,
    **options: Any,
) -> Image:
    """Return the picture of a scene, or of lists before the usual background."""
    scene = scene_of(scene) if isinstance(scene, FragmentLists) else scene
    with opened(device, scene, chosen, **options) as frame:
        frame.render(permutation=permutation)
        return frame.image()


def step(target: Target, magnitude: float) -> float:
    """Return the distance of neighboring values of the target's format at `magnitude`.

    Floating-point formats have `Format.step` just below one, and twice as much from each power of
    two on; normalized formats have the same step everywhere.
    """
    entry = target.texel
    if entry.dtype == "f1":
        return entry.step
    return float(entry.step * 2.0 ** (np.floor(np.log2(max(magnitude, 0.5))) + 1))


def tolerance(chosen: Method, layers: int, magnitude: float) -> float:
    """Return the error that the method's formats allow for colors up to `magnitude`.

    That is `rounding`; and a packed record holds color and opacity, each off by half a step.
    """
    packed = 1 / 255 if chosen.values.get("node") == "compact" else chosen.record_step
    quantization = layers * (1 + magnitude) * packed / 2
    return quantization + rounding(chosen, layers, magnitude)


def rounding(chosen: Method, layers: int, magnitude: float) -> float:
    """Return the error of arithmetic and of writes to targets alone.

    Each write of a target may be off by one step (drivers may truncate), the opaque color's too,
    and no later blend makes an error larger. A sum that is divided by another carries the relative
    error of both; a normalized transmittance acts on differences of colors.
    """
    targets = {"color": Target("rgba16f"), **full_plan(chosen).targets}
    error = step(targets["color"], 1.0) * magnitude
    for item in all_passes(chosen):
        writes = layers if isinstance(item, Gather) else 1
        for name in item.writes:
            if targets[name].texel.integer:
                continue  # its rounding is the record's
            quotient = name != "color" and targets[name].texel.dtype != "f1"
            error += writes * step(targets[name], 1.0) * magnitude * (2 if quotient else 1)
    if any(item.buffers for item in all_passes(chosen)):
        error += 4 * layers * 2.0**-23 * magnitude
    return error


def full_plan(chosen: Method) -> Plan:
    """Return the plan of a method for all that it can show."""
    return chosen.plan(Request(chosen.shows, particles=True))


def all_passes(chosen: Method) -> Iterator[Pass]:
    yield from steps.all_passes(full_plan(chosen).passes)


def keeps_promises(device: Device, *names: str) -> None:
    """Assert that each of these methods keeps all of its promises."""
    found = suite.run(device, collection(), list(map(method, names)), identities())
    assert found
    assert not [(item.method, item.check, item.error) for item in found if item.failed]


def write_method(
    folder: Path,
    passes: str,
    targets: str = "{}",
    buffers: str = "{}",
    members: str = "",
    **shaders: str,
) -> Path:
    """Write a method with this plan into `folder`; shaders by name, without their ending."""
    folder.mkdir(parents=True)
    lines = [
        '"""A method for tests."""',
        "from oitbench import *",
        "class Written(Method):",
        *(f"    {line}" for line in members.strip().splitlines()),
        "    def plan(self, request):",
        f"        return Plan({targets}, {passes}, {buffers})",
        "",
    ]
    (folder / "method.py").write_text("\n".join(lines))
    for name, text in shaders.items():
        (folder / f"{name}.glsl").write_text(text)
    return folder

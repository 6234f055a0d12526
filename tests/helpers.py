"""Scenes, frames and error bounds that several tests share."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from functools import cache
from itertools import chain
from pathlib import Path
from typing import Any

import numpy as np

from oitbench.effects import Effect
from oitbench.errors import CapabilityError
from oitbench.gl.device import Device
from oitbench.gl.frame import Frame, Image
from oitbench.gl.plan import FramePlan
from oitbench.gl.uploaded_scene import UploadedScene
from oitbench.measure import accounting
from oitbench.method import steps
from oitbench.method.declaration import Method, Plan, Request, plan_of
from oitbench.method.passes import Pass
from oitbench.method.storage import Target
from oitbench.plugins import Collection
from oitbench.scene import BLACK as NOTHING
from oitbench.scene import WHITE, Floats, FragmentLists, Scene
from oitbench.shading import DEFAULT, ShadingSettings
from oitbench.stability import suite
from oitbench.stability.check import Check
from oitbench.stability.identities import identities
from oitbench.stability.layers import (
    BACKGROUND,
    BLUE,
    GREEN,
    RED,
    SIDE,
    Layer,
    random_lists,
    scene_of,
    stack,
)
from oitbench.stability.result import CheckResult
from oitbench.stability.tolerance import rounding, step, tolerance

__all__ = [
    "BACKGROUND",
    "BLUE",
    "GREEN",
    "NOTHING",
    "RED",
    "SIDE",
    "WHITE",
    "Layer",
    "random_lists",
    "rounding",
    "scene_of",
    "stack",
    "step",
    "tolerance",
]


class Empty(Method):
    """Shows the opaque image in single precision."""

    name = "empty"

    def plan(self, request: Request) -> Plan:
        return Plan({"color": Target("rgba32f")})


@cache
def collection() -> Collection:
    return Collection.load()


def method(text: str) -> Method:
    (found,) = collection().expand_methods([text])
    return found


def foreign_method(source: Path | str) -> Method:
    """Return the method in a folder; the collection that tests share stays unchanged."""
    (found,) = Collection.load().expand_methods([str(source)])
    return found


@contextmanager
def opened(
    device: Device,
    scene: Scene,
    chosen: Method | str,
    size: tuple[int, int] | None = None,
    effects: Effect | None = None,
    settings: ShadingSettings = DEFAULT,
    **options: Any,
) -> Iterator[Frame]:
    """Yield a frame that has not been rendered yet; it is released afterwards."""
    chosen = method(chosen) if isinstance(chosen, str) else chosen
    if size is None:
        assert scene.lists is not None
        size = (scene.lists.z.shape[2], scene.lists.z.shape[1])
    running = scene.effects & chosen.shows if effects is None else effects
    with (
        UploadedScene(device, scene, settings, size[1]) as uploaded,
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
    """Return the image of a scene, or of lists in front of `BACKGROUND`."""
    scene = scene_of(scene) if isinstance(scene, FragmentLists) else scene
    with opened(device, scene, chosen, **options) as frame:
        frame.render(permutation=permutation)
        return frame.image()


def assert_same(device: Device, found: Image, expected: Image, chosen: str, layers: int) -> None:
    """Assert that two images of the same fragments are equal.

    Software renderers keep the order of fragments, so every bit must be equal. GPUs add fragments
    to lists in any order, and compile other programs to other roundings.
    """
    largest = max(1.0, float(np.abs(expected).max()))
    allowed = 0.0 if device.software else rounding(method(chosen), layers, largest)
    np.testing.assert_allclose(found, expected, rtol=0, atol=allowed)


def assert_order_independent(frame: Frame, orders: int) -> None:
    """Assert that random orders of the draws give the same image, bit for bit."""
    frame.render()
    first = frame.image()
    for seed in range(orders):
        frame.render(permutation=seed)
        np.testing.assert_array_equal(frame.image(), first)


def bits_per_pixel(device: Device, scene: Scene, chosen: Method | str, **options: Any) -> float:
    """Return the memory of a frame in bits per pixel."""
    with opened(device, scene, chosen, **options) as frame:
        return accounting.memory(frame).bits_per_pixel


def planned_bits(chosen: Method | str, mechanism: str) -> float:
    """Return the bits per pixel of a method's targets by a mechanism that drivers may lack."""
    chosen = method(chosen) if isinstance(chosen, str) else chosen
    plan = FramePlan.of(chosen, (1, 1), chosen.shows, mechanism=mechanism)
    return 8 * sum(count for _, count in plan.target_bytes())


def offered(device: Device, chosen: Method | str) -> bool:
    """Return whether the driver has a way of blending in shaders that a method needs, if any."""
    chosen = method(chosen) if isinstance(chosen, str) else chosen
    try:
        FramePlan.of(chosen, (1, 1), chosen.shows, mechanism=device.mechanism)
    except CapabilityError:
        return False
    return True


def moved(device: Device, picture: Floats) -> float:
    """Return the largest change of a picture, shape (h, w, ...), when its vertices are snapped.

    GPUs move them to a grid inside of pixels before they interpolate. Software renderers snap edges
    alone.
    """
    if device.software:
        return 0.0
    step = 2.0 ** -int(device.context.info["GL_SUBPIXEL_BITS"]) / 2
    return step * sum(float(abs(np.diff(picture, axis=axis)).max()) for axis in (0, 1))


def takes_any_order(device: Device, chosen: Method | str) -> bool:
    """Return whether the driver takes the fragments of a pixel in an order that it does not fix.

    Pictures of methods that depend on the order then have no model, and change from run to run.
    """
    chosen = method(chosen) if isinstance(chosen, str) else chosen
    plan = FramePlan.of(chosen, (1, 1), chosen.shows, mechanism=device.mechanism)
    return plan.in_order_of_arrival and not device.software


def full_plan(chosen: Method) -> Plan:
    """Return the plan of a method for all effects and for particles."""
    return plan_of(chosen, Request(chosen.shows, particles=True))


def all_passes(chosen: Method) -> Iterator[Pass]:
    yield from steps.all_passes(full_plan(chosen).passes)


def variants(names: Iterable[str]) -> list[Method]:
    """Return all variants of some methods that the suite runs."""
    known = collection().methods
    texts = (suite.variants(name, known[name].parameters) for name in names)
    return collection().expand_methods(chain.from_iterable(texts))


def run_checks(
    device: Device,
    methods: Sequence[Method],
    chosen: Sequence[Check],
    report: Callable[[CheckResult], None] = lambda result: None,
) -> list[CheckResult]:
    """Run checks on methods, all of them in this process."""
    known = {item.label: item for item in methods}
    with suite.Examiner(device, collection()) as examiner:
        return suite.run(
            list(known), lambda check, label: examiner.examine(check, known[label]), chosen, report
        )


def keeps_promises(device: Device, *names: str) -> None:
    """Assert that each of these methods keeps all of its promises."""
    found = run_checks(device, list(map(method, names)), identities())
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
    """Write a method with this plan into `folder`; keys of `shaders` are names without suffix."""
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

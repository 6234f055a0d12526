"""Properties that depend on the driver; `tests/benchmarks/on_gpu.sh` runs them on a GPU.

They hold on software renderers as well, where they check less: no interlock, no real timestamps and
no races.
"""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

from oitbench.gl.capabilities import CAPABILITIES, FETCH, MECHANISMS
from oitbench.gl.device import Device
from oitbench.gl.readback import read_texels
from oitbench.gl.timestamps import Timestamps
from oitbench.measure.oracle import composite
from oitbench.method.formats import FORMATS
from tests.helpers import (
    BACKGROUND,
    method,
    offered,
    opened,
    random_lists,
    render,
    scene_of,
    takes_any_order,
    tolerance,
)
from tests.models import bounded

MODELS = {"k_buffer": bounded.k_buffer, "multilayer_alpha": bounded.multilayer_alpha}
EXACT = ("a_buffer", "depth_peeling", "dual_depth_peeling", "k_buffer[k=16]")
ORDERED = ("multilayer_alpha", "multilayer_alpha[msaa=4]", "adaptive[memory=fixed]", "hybrid")
COUNT = 12


def mechanisms(device: Device) -> list[str]:
    """Return the ways of programmable blending that the driver offers."""
    return [name for name, capability in MECHANISMS.items() if device.has(capability)]


def test_capabilities_can_be_asked_for(device: Device) -> None:
    assert all(isinstance(device.has(name), bool) for name in CAPABILITIES)
    assert mechanisms(device)


def offers_samples(device: Device, mechanism: str) -> bool:
    """Return whether shaders can blend four samples in this way."""
    return mechanism == FETCH or device.limits["GL_MAX_IMAGE_SAMPLES"] >= 4


@pytest.mark.parametrize("name", ["k_buffer", "multilayer_alpha", "adaptive[memory=fixed]"])
def test_four_samples_are_blended_by_each_mechanism(device: Device, name: str) -> None:
    four, layers = f"{name.removesuffix(']')}{',' if '[' in name else '['}msaa=4]", 4
    lists = random_lists(layers, side=64)
    one = render(device, lists, name)
    allowed = 0.0 if device.software else tolerance(method(four), layers, 1.0)
    for mechanism in mechanisms(device):
        if offers_samples(device, mechanism):
            found = render(device, lists, four, mechanism=mechanism)
            np.testing.assert_allclose(found, one, rtol=0, atol=allowed, err_msg=mechanism)


@pytest.mark.parametrize("name", ["k_buffer", "multilayer_alpha"])
def test_each_mechanism_follows_the_model_within_k_layers(device: Device, name: str) -> None:
    chosen = method(name)
    k, node = int(chosen.values["k"]), str(chosen.values["node"])
    lists = random_lists(k)
    expected = MODELS[name](lists, BACKGROUND, k, node)
    for mechanism in mechanisms(device):
        image = render(device, lists, chosen, mechanism=mechanism)
        assert abs(image - expected).max() <= tolerance(chosen, k, 1.0), mechanism


@pytest.mark.parametrize("name", ORDERED)
def test_an_ordered_interlock_gives_the_same_image_each_time(device: Device, name: str) -> None:
    lists = random_lists(40, side=64)
    if not offered(device, name) or takes_any_order(device, name):
        pytest.skip(f"{device.renderer} has no interlock for it")
    with opened(device, scene_of(lists), name) as frame:
        frame.render()
        first = frame.image()
        for _ in range(5):
            frame.render()
            np.testing.assert_array_equal(frame.image(), first)


@pytest.mark.parametrize("name", EXACT)
def test_exact_methods_agree_with_float64_at_many_pixels(device: Device, name: str) -> None:
    chosen, lists = method(name), random_lists(COUNT, side=256)
    image = render(device, lists, chosen)
    assert abs(image - composite(lists, BACKGROUND)).max() <= tolerance(chosen, COUNT, 1.0)


def test_lists_that_overflow_are_drawn_again_with_enough_memory(device: Device) -> None:
    lists = random_lists(COUNT, side=256)
    with opened(device, scene_of(lists), "a_buffer") as frame:
        few = np.full(frame.resources.tiles, 1000, dtype=np.int64)
        frame.resources.reserve(few)
        frame.render()
        error = abs(frame.image() - composite(lists, BACKGROUND)).max()
        assert error <= tolerance(method("a_buffer"), COUNT, 1.0)
        assert (frame.resources.demand > few).all()


def test_timestamps_enclose_the_work_of_a_frame(device: Device) -> None:
    lists = random_lists(COUNT, side=64)
    with opened(device, scene_of(lists), "a_buffer") as frame, Timestamps(device) as stamps:
        frame.render()
        frame.restore()
        stamps.stamp()
        frame.composite(lambda key: stamps.stamp())
        found = stamps.read()
    parts = len(frame.plan.parts) + 1  # the start of the frame
    assert len(found) == parts + 1
    assert found == sorted(found)
    assert found[-1] > found[0]


@pytest.mark.parametrize("name", [name for name in FORMATS if not name.startswith("depth")])
def test_formats_hold_the_value_they_are_cleared_to(device: Device, name: str) -> None:
    entry = FORMATS[name]
    value = (3.0, 2.0, 1.0, 7.0) if entry.integer else (0.5, 0.25, 1.0, 0.75)
    texture = device.texture((4, 4), entry)
    framebuffer = device.context.framebuffer([texture])
    framebuffer.use()
    device.clear(0, entry, value)
    found = read_texels(device, texture, (4, 4), entry)
    step = entry.step if entry.dtype == "f1" else 0
    assert abs(found.astype(np.float64) - value[: entry.components]).max() <= step
    framebuffer.release()
    texture.release()


@pytest.mark.skipif(shutil.which("glslangValidator") is None, reason="needs glslang")
@pytest.mark.parametrize("mechanism", ["interlock", "spin lock"])
@pytest.mark.parametrize(
    "name", ["k_buffer", "multilayer_alpha", "multilayer_alpha[msaa=4]", "hybrid"]
)
def test_the_reference_compiler_accepts_mechanisms_that_this_driver_may_lack(
    device: Device, monkeypatch: pytest.MonkeyPatch, tmp_path: Path, name: str, mechanism: str
) -> None:
    from oitbench.gl.program import passes
    from oitbench.gl.program.source import Source

    class Captured(Exception):  # noqa: N818
        """The program is not compiled by the driver."""

    def capture(device: Device, vertex: Source, fragment: Source, *rest: object) -> None:
        for stage, source in (("vert", vertex), ("frag", fragment)):
            path = tmp_path / f"shader.{stage}"
            path.write_text(source.text)
            done = subprocess.run(["glslangValidator", path], capture_output=True, text=True)
            assert done.returncode == 0, done.stdout
        raise Captured

    monkeypatch.setattr(passes, "_program", capture)
    with pytest.raises(Captured):
        render(device, random_lists(2), name, mechanism=mechanism)

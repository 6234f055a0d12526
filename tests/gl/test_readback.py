"""Texels that are read back are those that shaders would fetch."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from oitbench.errors import UsageError
from oitbench.gl.device import Device
from oitbench.gl.program.passes import attach
from oitbench.gl.readback import format_of, read_averaged, read_texels
from oitbench.method.formats import FORMATS
from tests.helpers import foreign_method, opened, random_lists, scene_of, write_method

SIZE = (5, 3)


def cleared_to(name: str) -> tuple[float, ...]:
    entry = FORMATS[name]
    if entry.integer:
        return (4_000_000_001.0, 2.0, 1.0, 7.0)
    return (-0.5, 0.25, 1.0, 0.75) if "snorm" in name else (0.5, 0.25, 1.0, 0.75)


@pytest.mark.parametrize("name", FORMATS)
def test_every_format_is_read_as_it_was_cleared(device: Device, name: str) -> None:
    entry = FORMATS[name]
    texture = device.texture(SIZE, entry)
    framebuffer = attach(device, texture, entry)
    framebuffer.use()
    device.clear(0, entry, cleared_to(name))
    found = read_texels(device, texture, SIZE, entry)
    assert found.shape == (3, 5, entry.components)
    assert found.dtype == (np.uint32 if entry.integer else np.float32)
    wanted = np.asarray(cleared_to(name)[: entry.components])
    step = entry.step if entry.dtype == "f1" else 0
    assert abs(found.astype(np.float64) - wanted).max() <= step
    framebuffer.release()
    texture.release()


@pytest.mark.parametrize("name", [name for name, e in FORMATS.items() if e.internal is None])
def test_the_format_of_a_texture_is_known(device: Device, name: str) -> None:
    texture = device.texture(SIZE, FORMATS[name])
    assert format_of(texture).name == name
    texture.release()


def test_rows_come_from_the_top(device: Device) -> None:
    entry = FORMATS["r32f"]
    texture = device.texture(SIZE, entry)
    texture.write(np.arange(15, dtype=np.float32).tobytes())
    assert read_texels(device, texture, SIZE, entry)[:, 0, 0].tolist() == [10, 5, 0]
    texture.release()


@pytest.mark.parametrize("name", ["depth32f", "r32ui"])
def test_samples_that_have_no_mean_are_refused_by_name(device: Device, name: str) -> None:
    with pytest.raises(UsageError, match=f"target lock: {name} of several samples"):
        read_averaged(device, "lock", device.context.screen, SIZE, FORMATS[name])


def test_shaders_read_an_overflowed_half_float_as_the_greatest(
    device: Device, tmp_path: Path
) -> None:
    """Sums are infinite on GPUs alone, so here a shader writes what the sum would be."""
    write_method(
        tmp_path / "overflowing",
        '(Gather("gather.glsl", writes={"sum": REPLACE}),'
        ' Resolve("resolve.glsl", reads=("sum",), writes={"color": REPLACE}))',
        '{"sum": Target("rg16f"), "color": Target("rgba32f")}',
        members="expresses = Effect.COVERAGE",
        gather="void gather(Fragment fragment) {"
        " sum = vec2(1.0, -1.0) / (fragment.z - fragment.z); }",
        resolve="void resolve() { color = vec4(read_sum(), 0.0, 1.0); }",
    )
    with opened(
        device, scene_of(random_lists(1)), foreign_method(tmp_path / "overflowing")
    ) as frame:
        frame.render()
        assert np.isinf(frame.read("sum")).all()
        assert frame.image()[0, 0].tolist() == [65504.0, -65504.0, 0.0]

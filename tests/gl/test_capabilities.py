"""Tables of facts about drivers, and a frame's checks against them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from oitbench.errors import CapabilityError
from oitbench.gl.capabilities import FETCH, INTERLOCK, SPIN_LOCK, is_software, loop_limit
from oitbench.gl.device import Device
from tests.helpers import foreign_method, opened, random_lists, scene_of, write_method

MEMBERS = """
def loop_steps(self, fragments):
    return 10 * fragments
"""


@pytest.mark.parametrize(
    ("renderer", "software", "limit"),
    [
        ("llvmpipe (LLVM 15.0.6, 256 bits)", True, 65_535),
        ("softpipe", True, None),
        ("Google SwiftShader", True, None),
        ("NVIDIA H100 80GB HBM3/PCIe/SSE2", False, None),
        ("AMD Radeon RX 6700 XT (radeonsi, navi22, LLVM 15.0.7)", False, None),
        ("Mesa Intel(R) Iris(R) Xe Graphics (TGL GT2)", False, None),
    ],
)
def test_drivers_are_known_by_their_renderer(
    renderer: str, software: bool, limit: int | None
) -> None:
    assert is_software(renderer) == software
    assert loop_limit(renderer) == limit


@pytest.mark.parametrize(("limit", "refused"), [(None, False), (49, True), (50, False)])
def test_a_frame_deeper_than_the_loops_of_the_driver_is_refused(
    device: Device,
    monkeypatch: pytest.MonkeyPatch,
    tmp_path: Path,
    limit: int | None,
    refused: bool,
) -> None:
    monkeypatch.setattr(device, "loop_limit", limit)
    folder = write_method(tmp_path / "deep", "()", members=MEMBERS)
    scene = scene_of(random_lists(5))
    if refused:
        message = rf"deep: 5 fragments at one pixel; .* ends all loops after {limit} steps"
        with pytest.raises(CapabilityError, match=message):
            opened(device, scene, foreign_method(str(folder))).__enter__()
    else:
        with opened(device, scene, foreign_method(str(folder))) as frame:
            frame.render()


def test_the_driver_ends_loops_where_the_table_says(device: Device, tmp_path: Path) -> None:
    limit = loop_limit(device.renderer)
    if limit is None:
        pytest.skip("no limit is known for this driver")
    shader = """
void resolve() {
    uint steps = 0u;
    for (uint i = 0u; i < STEPS; ++i) {
        steps += 1u + (read_opaque_depth() > 2.0 ? i : 0u);
    }
    color = vec4(float(steps));
}
"""
    passes = (
        '(Resolve("count.glsl", reads=("opaque_depth",), writes={"color": REPLACE},'
        ' defines={"STEPS": STEPS}),)'
    )
    targets = '{"color": Target("rgba32f")}'
    counted = []
    for steps in (limit - 1, limit + 100):
        folder = write_method(
            tmp_path / f"loop{steps}", passes.replace("STEPS}", f"{steps}}}"), targets, count=shader
        )
        with opened(
            device, scene_of(random_lists(1)), foreign_method(str(folder)), (4, 4)
        ) as frame:
            frame.render()
            counted.append(int(np.unique(frame.image())[0]))
    assert counted[0] == limit - 1
    assert counted[1] < limit + 100


@pytest.mark.parametrize(
    ("capabilities", "images", "expected"),
    [
        ({"framebuffer_fetch", "interlock", "image_load_store"}, 0, FETCH),
        ({"interlock", "image_load_store"}, 4, INTERLOCK),
        ({"image_load_store"}, 8, SPIN_LOCK),
        ({"interlock", "image_load_store"}, 2, None),
    ],
)
def test_four_samples_blend_in_images_of_as_many(
    device: Device,
    monkeypatch: pytest.MonkeyPatch,
    capabilities: set[str],
    images: int,
    expected: str | None,
) -> None:
    monkeypatch.setattr(device, "has", capabilities.__contains__)
    monkeypatch.setitem(device.limits, "GL_MAX_IMAGE_SAMPLES", images)
    assert device.mechanism(1) in (FETCH, INTERLOCK, SPIN_LOCK)
    if expected is None:
        with pytest.raises(CapabilityError, match=r"no programmable blending of 4 samples"):
            device.mechanism(4)
    else:
        assert device.mechanism(4) == expected

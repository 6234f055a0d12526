"""The identities of the suite: their scenes, and methods that break them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from oitbench.gl.device import Device
from oitbench.measure.oracle import composite
from oitbench.method.promises import PROMISES
from oitbench.stability.identities import identities, probed_layers, wall
from oitbench.stability.layers import SIDE
from oitbench.stability.render import UploadedScenes
from oitbench.stability.resolution import reach
from oitbench.stability.result import BREAKS, DOES_NOT_APPLY, HOLDS, Status
from tests.helpers import foreign_method, method, opened, write_method
from tests.stability.helpers import CHECKS, COVERAGE, examine, writing

SHIFT = """void resolve() {{
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    pixel.x = min(pixel.x + {}, int(frame_size.x) - 1);
    color = read_opaque_color(pixel);
}}"""


def shifting(folder: Path, pixels: str) -> None:
    """Write a method that shifts the image horizontally by that many pixels, an expression."""
    write_method(
        folder,
        '(Resolve("shift.glsl", reads=("opaque_color",), writes={"color": REPLACE}),)',
        members="expresses = Effect.COVERAGE | Effect.REFRACTION\n"
        'promises = promise("resolution_independent")',
        shift=SHIFT.format(pixels),
    )


def test_the_identities_are_those_that_methods_may_promise() -> None:
    assert [(check.name, check.sentence) for check in identities()] == list(PROMISES.items())
    assert all(check.identity for check in identities())


def test_the_wall_is_not_uniform(device: Device) -> None:
    with opened(device, wall(), "a_buffer", (SIDE, SIDE)) as frame:
        frame.render()
        assert frame.image().std() > 0


def test_a_change_of_alpha_breaks_the_opaque_picture(device: Device, tmp_path: Path) -> None:
    write_method(
        tmp_path / "alpha",
        '(Resolve("alpha.glsl", reads=("opaque_color",), writes={"color": REPLACE}),)',
        members=COVERAGE,
        alpha="void resolve() { color = vec4("
        "read_opaque_color(ivec2(gl_FragCoord.xy)).rgb, 0.25); }",
    )
    (found,) = examine(device, foreign_method(tmp_path / "alpha"), "opaque_unchanged")
    assert (found.status, found.promised, found.failed) == (BREAKS, True, True)
    assert found.error == 0.75


def test_the_probe_has_five_visibilities() -> None:
    exact = composite(probed_layers(), 0.0)
    assert (exact == exact[:, :1, :1]).all()
    assert (np.diff(exact[:, 0, 0]) <= 0).all()
    assert np.unique(exact.round(12)) == pytest.approx([0.65**k for k in (5, 4, 3, 1, 0)])


def test_two_layers_differ_after_the_swap() -> None:
    before, after = (shot.scene.lists for shot in CHECKS["two_layers_ordered"].shots)
    assert before is not None
    assert after is not None
    assert abs(composite(before, 0.0) - composite(after, 0.0)).max() > 0.2


def test_a_broken_identity_has_its_error(device: Device) -> None:
    (found,) = examine(device, "alpha_blend", "two_layers_ordered")
    assert (found.status, found.promised, found.failed) == (BREAKS, False, False)
    assert found.error == pytest.approx(0.25, abs=1e-3)


@pytest.mark.parametrize("name", list(PROMISES))
def test_a_constant_breaks_most_identities(device: Device, tmp_path: Path, name: str) -> None:
    """A method that writes 0.5 for each fragment keeps only those that hold for constants."""
    (found,) = examine(device, writing(tmp_path, "vec4(0.5)"), name)
    kept = {"opaque_unchanged", "order_independent", "visibility_monotonic"}
    skipped = {"colored_layer_exact", "resolution_independent"}
    expected = DOES_NOT_APPLY if name in skipped else HOLDS if name in kept else BREAKS
    assert found.status == expected


@pytest.mark.parametrize(
    ("pixels", "status"), [("6", BREAKS), ("int(frame_size.x) / 10", HOLDS), ("0", HOLDS)]
)
def test_offsets_of_a_fixed_number_of_pixels_depend_on_the_resolution(
    device: Device, tmp_path: Path, pixels: str, status: Status
) -> None:
    shifting(tmp_path / "shifting", pixels)
    (found,) = examine(device, foreign_method(tmp_path / "shifting"), "resolution_independent")
    assert (found.status, found.failed) == (status, status == BREAKS)


def test_the_resolution_matters_to_methods_that_refract_or_diffuse(device: Device) -> None:
    (found,) = examine(device, "weighted_blended", "resolution_independent")
    assert found.status == DOES_NOT_APPLY
    assert "neither refraction nor diffusion" in found.reason
    (found,) = examine(device, "phenomenological", "resolution_independent")
    assert (found.status, found.promised) == (HOLDS, True)
    assert found.error is not None
    assert found.error > 0


def test_the_sheets_move_light_by_some_pixels(device: Device) -> None:
    check = CHECKS["resolution_independent"]
    small = min(shot.pixels for shot in check.shots)
    shots = [s for s in check.shots if (s.scene.name, s.pixels) == ("edge", small)]
    with UploadedScenes(device, shots) as scenes:
        found = scenes.render(method("phenomenological"), shots)
    assert len(found) == 2
    assert min(reach(one) for (one,) in found) > 2

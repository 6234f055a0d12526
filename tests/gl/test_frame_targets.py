"""The targets of a frame by name, their views, and why one does not exist."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import pytest

import oitbench as oit
from oitbench.effects import Effect
from oitbench.errors import DeclarationError, UsageError
from oitbench.gl.device import Device
from oitbench.gl.frame_targets import choose, targets_of
from oitbench.method.declaration import Method
from oitbench.modeling.mesh import quad
from oitbench.scene import Camera, DirectionalLight, Material, Object, Scene
from oitbench.shading import OCCLUDERS, ShadingSettings
from tests.helpers import collection, method, opened

SIZE = (32, 24)
PHENOMENOLOGICAL = "phenomenological"


@dataclass(frozen=True)
class Refusal:
    """A target that does not exist, and a part of the message."""

    scene: str
    method: str
    target: str
    message: str
    without: Effect = Effect.NONE


REFUSALS = (
    Refusal("chess", PHENOMENOLOGICAL, "betta", "unknown target 'betta'; did you mean beta"),
    Refusal("bottles", PHENOMENOLOGICAL, "delta", "REFRACTION, which bottles[detail=0.1] does not"),
    Refusal("bottles", PHENOMENOLOGICAL, "diffusion", "needs DIFFUSION, which bottles"),
    Refusal("chess", PHENOMENOLOGICAL, "delta", "which --effects leaves out", Effect.REFRACTION),
    Refusal(
        "chess", "a_buffer", "shadow_map", "which --effects leaves out", Effect.TRANSLUCENT_SHADOWS
    ),
    Refusal("bottles", "a_buffer", "openness", "needs AMBIENT_OCCLUSION, which bottles"),
    Refusal("glass_bars", "a_buffer", "shadow_map", "needs TRANSLUCENT_SHADOWS, which glass_bars"),
)


@pytest.mark.parametrize("case", REFUSALS)
def test_a_target_that_does_not_exist_is_refused_with_the_reason(
    device: Device, case: Refusal
) -> None:
    scene, chosen = collection().build_scene(f"{case.scene}[detail=0.1]"), method(case.method)
    effects = scene.effects & chosen.shows & ~case.without
    with opened(device, scene, chosen, SIZE, effects=effects) as frame:
        with pytest.raises(UsageError) as raised:
            choose(frame, chosen, case.target)
        assert case.message in str(raised.value)
        assert case.target not in targets_of(frame, chosen)


@pytest.mark.parametrize("precision", ["paper", "half"])
def test_views_are_the_stored_values_in_pixels(device: Device, precision: str) -> None:
    scene = collection().build_scene("chess[detail=0.1]")
    chosen = method(f"{PHENOMENOLOGICAL}[precision={precision}]")
    unit = 63 if precision == "paper" else 1
    with opened(device, scene, chosen, SIZE) as frame:
        frame.render()
        found = targets_of(frame, chosen)
        delta, view = found["delta"].read(), found["refraction"].read()
        beta, transmittance = found["beta"].read(), found["transmittance"].read()
    assert delta.min() < 0 < delta.max()
    np.testing.assert_array_equal(view, delta * np.float32(unit))
    np.testing.assert_array_equal(transmittance, beta[..., :3])
    assert found["refraction"].view
    assert not found["delta"].view


def test_the_view_of_a_variance_is_its_deviation(device: Device) -> None:
    scene, chosen = collection().build_scene("frosted_panes[detail=0.1]"), method(PHENOMENOLOGICAL)
    with opened(device, scene, chosen, SIZE) as frame:
        frame.render()
        found = targets_of(frame, chosen)
        blur, beta = found["diffusion"].read(), found["beta"].read()
    assert blur.shape == (24, 32, 1)
    assert blur.max() > 1
    np.testing.assert_allclose(blur[..., 0], 63 * np.sqrt(beta[..., 3]), rtol=1e-6)


def test_maps_of_shading_are_named_by_beam_and_join_their_channels(device: Device) -> None:
    """Of red glass, red light passes wholly, and other light with a probability of one half."""
    red = Material(transmission=(1, 0.5, 0.5), specular=0)
    down = DirectionalLight((0, -1, 0), (1, 1, 1))
    scene = Scene(
        "pane",
        Camera((0, 2, 5), (0, 0, 0)),
        (
            Object("floor", quad((0, -1, 0), (3, 0, 0), (0, 0, -3)), Material(), casts=False),
            Object("pane", quad((0, 0, 0), (1, 0, 0), (0, 0, -1)), red),
        ),
        lights=(down, DirectionalLight((0.1, -1, 0), (1, 1, 1))),
    )
    settings = ShadingSettings(OCCLUDERS)
    with opened(device, scene, "alpha_blend", SIZE, settings=settings) as frame:
        frame.render()
        found = targets_of(frame, method("alpha_blend"))
        values = found["shadow_map"].read()
    assert {"shadow_map", "shadow_map@1", "shadow_opaque", "opaque_depth"} <= set(found)
    assert found["shadow_map"].size == values.shape[1::-1]
    covered = (values > 0).mean(axis=(0, 1))
    assert covered[0] == 0
    assert covered[1] == covered[2] == pytest.approx(0.5, abs=0.05)


def test_samples_are_averaged_or_refused_by_name(device: Device) -> None:
    scene, chosen = collection().build_scene("glass_bars"), method("adaptive[msaa=4]")
    with opened(device, scene, chosen, SIZE) as frame:
        frame.render()
        found = targets_of(frame, chosen)
        assert found["color"].read().shape == (24, 32, 4)
        assert not found["opaque_depth"].readable
        with pytest.raises(UsageError, match="target opaque_depth: depth32f of several samples"):
            found["opaque_depth"].read()


def test_a_view_must_not_hide_a_target(device: Device) -> None:
    class Hiding(Method):
        name = "hiding"

        @property
        def views(self) -> Mapping[str, oit.View]:
            return {"color": oit.View("color", "rgb")}

    scene = collection().build_scene("glass_bars")
    with (
        opened(device, scene, "alpha_blend", SIZE) as frame,
        pytest.raises(DeclarationError, match="the view color has the name of a target"),
    ):
        targets_of(frame, Hiding())


def test_a_view_of_no_channel_is_refused() -> None:
    with pytest.raises(DeclarationError, match="channels is 'x'"):
        oit.View("beta", "x")

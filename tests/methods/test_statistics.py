"""The mean and the variance of methods with random numbers.

All 10,000 pixels of a picture have the same list, so each pixel is an independent trial.
"""

from __future__ import annotations

from dataclasses import replace
from math import comb
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest

from oitbench.gl.device import Device
from oitbench.measure import accounting
from oitbench.measure.oracle import composite, transmittances
from oitbench.modeling.mesh import quad
from oitbench.scene import RGB, Camera, Floats, FragmentLists, Material, Object, Scene
from tests.helpers import (
    BACKGROUND,
    BLUE,
    GREEN,
    NOTHING,
    RED,
    WHITE,
    Layer,
    collection,
    foreign_method,
    method,
    opened,
    random_lists,
    render,
    scene_of,
    stack,
    write_method,
)
from tests.models import hashed_alpha as model

SIDE, TRIALS = 100, 10_000
RED_OVER_GREEN = [Layer(1.0, 0.45, RED), Layer(2.0, 0.45, GREEN)]
MIXED = [
    Layer(5.0, 0.3, (0.9, 0.2, 0.1)),
    Layer(1.5, 0.15, (0.1, 0.8, 0.3)),
    Layer(9.0, 0.7, WHITE),
    Layer(3.0, 0.55, (0.2, 0.1, 0.7)),
    Layer(7.0, 0.4, (0.5, 0.9, 0.0), (0.3, 0.3, 0.3)),
]
# The relative standard error of a variance that is estimated from n trials is √(2/n) to 2√(2/n).
SLACK = 1.1


def trials(
    device: Device, layers: list[Layer], name: str, background: RGB = BACKGROUND
) -> tuple[Floats, Floats]:
    """Return the pixels of the picture, shape (n, 3), and the exact color, shape (3,)."""
    lists = stack(layers, SIDE)
    found = render(device, scene_of(lists, background), name).reshape(-1, 3)
    return found.astype(np.float64), composite(stack(layers, 1), background)[0, 0]


def gathered(device: Device, layers: list[Layer], samples: int) -> Floats:
    """Return the uncorrected sum (alpha L v, o v) of depth-based sampling, (n, 4)."""
    name = f"stochastic[samples={samples},precision=float]"
    with opened(device, scene_of(stack(layers, SIDE), NOTHING), name) as frame:
        frame.render()
        return frame.read("sum").reshape(-1, 4).astype(np.float64)


def assert_mean(found: Floats, expected: npt.ArrayLike) -> None:
    """Compare the mean of independent trials with `expected`, within four standard errors."""
    deviation = found.std(axis=0) / np.sqrt(len(found))
    assert (abs(found.mean(axis=0) - np.asarray(expected)) <= 4 * deviation + 1e-6).all()


def independent_variance(layers: list[Layer], background: RGB, samples: int) -> Floats:
    """Return the variance of a mean of independent samples that each show one surface."""
    lists = stack(sorted(layers, key=lambda layer: layer.z), 1)
    opacity = 1 - transmittances(lists).mean(axis=-1)[:, 0, 0]
    seen = np.append(opacity, 1.0) * np.cumprod([1.0, *(1 - opacity)])
    color = lists.coverage[:, 0, 0, None] * lists.radiance[:, 0, 0] / opacity[:, None]
    shown = np.concatenate([color, [background]])
    mean = seen @ shown
    return np.asarray((seen @ shown**2 - mean**2) / samples)


@pytest.mark.parametrize("samples", [4, 8, 16, 64])
@pytest.mark.parametrize("layers", [RED_OVER_GREEN, MIXED])
def test_sampled_color_has_the_exact_mean_and_at_most_the_variance_of_independent_samples(
    device: Device, layers: list[Layer], samples: int
) -> None:
    name = f"stochastic[samples={samples},correction=none,precision=float]"
    found, exact = trials(device, layers, name)
    assert_mean(found, exact)
    assert found.std(axis=0).min() > 0
    bound = independent_variance(layers, BACKGROUND, samples)
    assert (found.var(axis=0) <= SLACK * bound).all()


def test_the_variance_of_independent_samples_equals_a_hand_example() -> None:
    bound = independent_variance(RED_OVER_GREEN, BLUE, 8)
    assert np.sqrt(bound) == pytest.approx([0.176, 0.153, 0.162], abs=5e-4)


@pytest.mark.parametrize("samples", [4, 16, 64])
def test_sampled_visibility_has_the_exact_mean(device: Device, samples: int) -> None:
    # The sum of depth-based sampling before its correction.
    _, exact = trials(device, MIXED, "alpha_blend", NOTHING)
    passed = transmittances(stack(MIXED, 1)).mean(axis=-1).prod()
    assert_mean(gathered(device, MIXED, samples), [*exact, 1 - passed])


@pytest.mark.parametrize("alpha", [0.45, 0.06])
def test_one_layer_has_the_variance_of_stratified_masks(device: Device, alpha: float) -> None:
    samples = 8
    rest = alpha * samples % 1
    expected = rest * (1 - rest) / samples**2
    name = f"stochastic[samples={samples},correction=none,precision=float]"
    found, _ = trials(device, [Layer(1.0, alpha, WHITE)], name, NOTHING)
    assert_mean(found, alpha)
    assert found.var() == pytest.approx(expected, rel=0.08)
    # The visibility of a layer behind it has the same variance.
    behind = [Layer(1.0, alpha, NOTHING), Layer(2.0, 1.0, WHITE)]
    seen = gathered(device, behind, samples)[:, 0]
    assert_mean(seen, 1 - alpha)
    assert seen.var() == pytest.approx(expected, rel=0.08)


@pytest.mark.parametrize(("layers", "passed"), [(2, 0.25), (5, 0.5**5)])
def test_surfaces_of_a_pixel_have_independent_masks(
    device: Device, layers: int, passed: float
) -> None:
    # The layers differ only in depth. With equal masks, half of the light would pass.
    planes = [Layer(1.0 + index, 0.5, NOTHING) for index in range(layers)]
    found, _ = trials(device, planes, "stochastic[correction=none,precision=float]", WHITE)
    assert_mean(found, passed)


def visibility_error(device: Device, samples: int) -> tuple[float, float]:
    """Return the RMSE of a background and of a probe behind eight layers."""
    layers = [Layer(1.0 + index, 0.25, NOTHING) for index in range(8)]
    name = f"stochastic[samples={samples},correction=none,precision=float]"
    found, exact = trials(device, layers, name, WHITE)
    seen = gathered(device, [*layers, Layer(10.0, 1.0, WHITE)], samples)[:, :3]
    return float(np.sqrt(((found - exact) ** 2).mean())), float(
        np.sqrt(((seen - exact) ** 2).mean())
    )


def test_errors_fall_with_the_root_of_the_number_of_samples(device: Device) -> None:
    samples = [8, 16, 32, 64]
    errors = np.log([visibility_error(device, count) for count in samples])
    slopes = np.polyfit(np.log(samples), errors, 1)[0]
    assert slopes == pytest.approx([-0.5, -0.5], abs=0.05)


def test_the_correction_reduces_noise_and_has_a_small_bias(device: Device) -> None:
    noise, bias = [], []
    for samples in (8, 32):
        found, exact = trials(device, MIXED, f"stochastic[samples={samples},precision=float]")
        noise.append(found.std(axis=0).max())
        bias.append(abs(found.mean(axis=0) - exact).max())
        plain, _ = trials(
            device, MIXED, f"stochastic[samples={samples},correction=none,precision=float]"
        )
        assert (found.std(axis=0) < plain.std(axis=0)).all()
    assert noise[1] < 0.65 * noise[0]
    assert bias[1] < 0.4 * bias[0] < 0.01


def taken_samples(device: Device, alpha: float, samples: int) -> npt.NDArray[np.bool_]:
    """Return which samples one layer takes in each trial, shape (n, samples)."""
    lists = stack([Layer(1.0, alpha)], SIDE)
    with opened(device, scene_of(lists), f"stochastic[samples={samples}]") as frame:
        frame.render()
        found = [frame.read(f"depths{i}") for i in range(samples // 4)]
    return np.concatenate(found, axis=-1).reshape(-1, samples) < 2


def test_every_set_of_samples_is_equally_likely(device: Device) -> None:
    taken = taken_samples(device, 3 / 8, 8)
    assert (taken.sum(axis=1) == 3).all()
    _, counts = np.unique(np.packbits(taken, axis=1), return_counts=True)
    assert len(counts) == comb(8, 3)
    expected = TRIALS / len(counts)
    # A chi-square of 55 degrees of freedom exceeds 93 with probability 0.001.
    assert ((counts - expected) ** 2 / expected).sum() < 93


@pytest.mark.parametrize(("alpha", "samples"), [(0.3, 16), (0.51, 32), (0.01, 4)])
def test_the_mean_number_of_samples_is_the_coverage(
    device: Device, alpha: float, samples: int
) -> None:
    counts = taken_samples(device, alpha, samples).sum(axis=1)
    low = int(alpha * samples)
    assert set(np.unique(counts)) == {low, low + 1}
    assert_mean(counts.astype(np.float64), alpha * samples)


PROBE = '(Gather("probe.glsl", writes={"color": REPLACE}),)'
SHOW = """#include "threshold.glsl"
void gather(Fragment fragment) { color = vec4(threshold(fragment.position)); }
"""


@pytest.fixture(scope="module")
def probe(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A method that shows the thresholds of hashed alpha testing."""
    threshold = (method("hashed_alpha").folders[0] / "threshold.glsl").read_text()
    return write_method(
        tmp_path_factory.mktemp("probe") / "probe",
        PROBE,
        '{"color": Target("rgba32f")}',
        members="scale = Parameter(1.0)",
        probe=SHOW,
        threshold=threshold,
    )


def thresholds_of(
    device: Device, probe: Path, scene: Scene | FragmentLists, scale: float, side: int = 128
) -> npt.NDArray[np.float32]:
    chosen = foreign_method(f"{probe}[scale={scale}]")
    return render(device, scene, chosen, size=(side, side))[..., 0]


@pytest.mark.parametrize("scale", [0.25, 1.0, 3.0])
@pytest.mark.parametrize("distance", [2, 3.7, 40])
def test_thresholds_are_uniform(device: Device, probe: Path, scale: float, distance: float) -> None:
    plane = collection().build_scene(f"layer_stack[count=1,first={distance}]")
    stride = int(np.ceil(2 * scale)) + 1  # pixels between samples in different cells
    values = np.sort(thresholds_of(device, probe, plane, scale, 192)[::stride, ::stride], axis=None)
    count = len(values)
    steps = np.arange(count + 1) / count
    distance_to_uniform = max((steps[1:] - values).max(), (values - steps[:-1]).max())
    # The statistic of Kolmogorov and Smirnov exceeds 1.63 with probability 0.01.
    assert distance_to_uniform * np.sqrt(count) < 1.63


def test_thresholds_move_with_surfaces(device: Device, probe: Path) -> None:
    side, distance, pixels = 128, 4.0, 3
    wall = Object("wall", quad((0, 0, -distance), (9, 0, 0), (0, 9, 0)), Material(coverage=0.5))
    width = 2 * distance * np.tan(np.radians(45) / 2) / side
    pictures = []
    for shift in (0.0, pixels * width):
        camera = Camera((shift, 0, 0), (shift, 0, -1))
        scene = Scene("wall", camera, (wall,))
        pictures.append(thresholds_of(device, probe, scene, 1.0, side))
    before, after = pictures
    same = abs(before[:, pixels:] - after[:, :-pixels]) < 0.05
    assert same.mean() > 0.9
    assert (abs(before - after) < 0.05).mean() < 0.3


def test_hashed_alpha_shows_the_nearest_layer_that_passes_its_threshold(
    device: Device, probe: Path
) -> None:
    lists = random_lists(6)
    single = [
        replace(lists, **{name: getattr(lists, name)[i : i + 1] for name in vars(lists)})
        for i in range(6)
    ]
    thresholds = [thresholds_of(device, probe, layer, 1.0, 16) for layer in single]
    expected = model.composite(lists, BACKGROUND, np.stack(thresholds))
    found = render(device, lists, "hashed_alpha")
    np.testing.assert_allclose(found, expected, rtol=2.0**-10, atol=2.0**-11)


@pytest.mark.parametrize("layers", [RED_OVER_GREEN, MIXED, MIXED[:1]])
def test_hashed_alpha_has_the_exact_mean(device: Device, layers: list[Layer]) -> None:
    found, exact = trials(device, layers, "hashed_alpha[scale=0.25]")
    # Colors are half floats.
    deviation = found.std(axis=0) / np.sqrt(TRIALS)
    assert (abs(found.mean(axis=0) - exact) <= 4 * deviation + 2.0**-12).all()
    bound = independent_variance(layers, BACKGROUND, 1)
    assert (found.var(axis=0) <= SLACK * bound).all()
    assert (found.var(axis=0) >= bound / SLACK).all()


def test_hashed_alpha_has_32_bits_per_pixel_and_one_pass(device: Device) -> None:
    with opened(device, scene_of(random_lists(2)), "hashed_alpha") as frame:
        assert accounting.memory(frame).bits_per_pixel == 32
        assert len(frame.plan.passes) == 1


def test_hashed_alpha_is_hidden_by_opaque_surfaces(device: Device) -> None:
    wall = Object("wall", quad((2, 0, -3), (2, 0, 0), (0, 9, 0)), Material(emission=GREEN))
    pane = Object("pane", quad((0, 0, -4), (9, 0, 0), (0, 9, 0)), Material(1 - 1e-7, emission=RED))
    scene = Scene("half", Camera((0, 0, 0), (0, 0, -1)), (wall, pane))
    found = render(device, scene, "hashed_alpha", size=(32, 32))
    assert (found[:, 17:] == np.asarray(GREEN)).all()
    assert (found[:, :15] == np.asarray(RED)).mean() > 0.99

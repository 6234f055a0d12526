"""Stochastic transparency against a model with the same random numbers; its accounts."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from oitbench.gl.device import Device
from oitbench.measure import accounting
from oitbench.method.passes import Gather
from oitbench.modeling.mesh import quad
from oitbench.scene import Camera, Material, Object, Scene
from tests.helpers import (
    BACKGROUND,
    BLUE,
    GREEN,
    NOTHING,
    RED,
    WHITE,
    Layer,
    bits_per_pixel,
    full_plan,
    method,
    opened,
    random_lists,
    render,
    scene_of,
    stack,
    step,
)
from tests.models.stochastic import composite, masks

CORRECTIONS = ("none", "alpha", "depth")
HALF = 2.0**-10


def allowed(precision: str, additions: int) -> float:
    """Return the largest error of a quotient of two sums: a step of the result per addition."""
    return {"half": HALF, "float": 2.0**-22}[precision] * (2 * additions + 4)


@settings(max_examples=12, deadline=None, derandomize=True)
@given(
    count=st.integers(1, 12),
    correction=st.sampled_from(CORRECTIONS),
    samples=st.sampled_from([4, 12, 32, 48, 64]),
    seed=st.integers(0, 65535),
    precision=st.sampled_from(["half", "float"]),
    noise=st.sampled_from(["white", "blue"]),
)
@example(count=5, correction="none", samples=64, seed=3, precision="float", noise="blue")
@example(count=5, correction="alpha", samples=48, seed=4, precision="float", noise="white")
@example(count=5, correction="depth", samples=64, seed=5, precision="float", noise="blue")
def test_pictures_follow_the_model(
    device: Device,
    count: int,
    correction: str,
    samples: int,
    seed: int,
    precision: str,
    noise: str,
) -> None:
    lists = random_lists(count, seed=seed)
    chosen = f"samples={samples},correction={correction},precision={precision},noise={noise}"
    expected = composite(lists, BACKGROUND, samples, correction, noise=noise)
    found = render(device, lists, f"stochastic[{chosen}]")
    assert abs(found - expected).max() <= allowed(precision, count * -(-samples // 32))


@pytest.mark.parametrize("samples", [4, 16, 24, 32])
def test_each_sample_keeps_the_nearest_layer_that_takes_it(device: Device, samples: int) -> None:
    lists = random_lists(5)
    with opened(device, scene_of(lists), f"stochastic[samples={samples}]") as frame:
        frame.render()
        targets = [frame.read(f"depths{i}") for i in range(samples // 4)]
    found = np.concatenate(targets, axis=-1)
    taken = masks(lists.coverage, samples)
    expected = np.where(taken, lists.z[..., None], np.finfo(np.float32).max).min(axis=0)
    np.testing.assert_array_equal(found, expected)


def test_the_seed_and_the_round_change_the_masks(device: Device) -> None:
    lists = random_lists(3)
    name = "stochastic[correction=none,seed={}]"
    first, again, other = (render(device, lists, name.format(seed)) for seed in (1, 1, 2))
    np.testing.assert_array_equal(first, again)
    assert abs(first - other).max() > 0.1
    opacity = np.full((1, 32, 32), 0.5, np.float32)
    assert 0.4 < (masks(opacity, 32, 1, 0) == masks(opacity, 32, 1, 1)).mean() < 0.6


def test_clear_layers_change_nothing(device: Device) -> None:
    some = [Layer(2.0, 0.4, RED), Layer(4.0, 0.6, GREEN)]
    clear = [Layer(z, 0.0, WHITE) for z in np.linspace(1.5, 5.0, 40)]
    for correction in CORRECTIONS:
        name = f"stochastic[correction={correction}]"
        picture = render(device, stack([*some, *clear]), name)
        np.testing.assert_array_equal(picture, render(device, stack(some), name))


@pytest.mark.parametrize("correction", CORRECTIONS)
def test_an_opaque_layer_takes_every_sample(device: Device, correction: str) -> None:
    front, behind = Layer(2.0, 1.0, (0.25, 0.5, 0.75)), Layer(3.0, 0.5, WHITE)
    found = render(device, stack([behind, front]), f"stochastic[correction={correction}]")
    np.testing.assert_array_equal(found, np.broadcast_to(np.array([0.25, 0.5, 0.75]), found.shape))


@pytest.mark.parametrize(("transmission", "shown"), [(1.0, 1.0), (0.999, 1.0), (0.97, 1.0)])
def test_clear_glass_keeps_its_highlight_with_a_correction(
    device: Device, transmission: float, shown: float
) -> None:
    glass = Layer(2.0, 1.0, WHITE, (transmission,) * 3)
    found = render(device, scene_of(stack([glass]), NOTHING), "stochastic")
    assert found == pytest.approx(np.full_like(found, shown), abs=0.02)
    lost = render(device, scene_of(stack([replace(glass, transmission=WHITE)]), NOTHING),
                  "stochastic[correction=none]")  # fmt: skip
    assert lost.max() == 0


@pytest.mark.parametrize(
    ("samples", "correction", "size"),
    [
        (4, "depth", 26),
        (8, "depth", 42),
        (16, "depth", 74),
        (16, "alpha", 74),
        (16, "none", 72),
        (32, "depth", 138),
        (64, "depth", 138),
        (48, "depth", 106),
    ],
)
def test_memory_is_4_bytes_per_sample_and_10_per_pixel(
    device: Device, samples: int, correction: str, size: int
) -> None:
    name = f"stochastic[samples={samples},correction={correction}]"
    assert bits_per_pixel(device, scene_of(random_lists(1)), name) == 8 * size


@pytest.mark.parametrize(("samples", "published"), [(8, 36.9), (16, 65.0)])
def test_memory_is_as_published(device: Device, samples: int, published: float) -> None:
    """Salvi et al. 2011, table 1: 1280×720 pixels, MBytes of 2^20."""
    bits = bits_per_pixel(device, scene_of(random_lists(1)), f"stochastic[samples={samples}]")
    assert bits / 8 * 1280 * 720 / 2**20 == pytest.approx(published, abs=0.05)


def test_traffic_is_12_bytes_per_sample_and_20_per_fragment(device: Device) -> None:
    count, samples = 6, 16
    with opened(device, scene_of(random_lists(count)), "stochastic") as frame:
        frame.render()
        measured = frame.measure()
        drawn = {item.name for item in frame.plan.passes if isinstance(item, Gather)}
        terms = [term for term in accounting.traffic(frame, measured).terms if term.pass_ in drawn]
        assert len(drawn) == 3
        assert sum(term.bytes for term in terms) == (12 * samples + 20) * count * 256
        assert {record.runs for record in measured.passes} == {1}


def test_64_samples_take_two_rounds(device: Device) -> None:
    with opened(device, scene_of(random_lists(3)), "stochastic[samples=64]") as frame:
        frame.render()
        measured = frame.measure()
        assert [record.runs for record in measured.passes] == [1, 2, 2, 1]


def test_half_coverage_takes_half_of_the_samples(device: Device) -> None:
    # Red takes 8 of 16 samples, and the background is visible in the others.
    lists = stack([Layer(1.0, 0.5, RED)], side=4)
    found = render(device, scene_of(lists, BLUE), "stochastic[correction=none]")
    np.testing.assert_array_equal(found, np.broadcast_to(np.array([0.5, 0.0, 0.5]), found.shape))
    assert step(full_plan(method("stochastic")).targets["sum"], 1.0) == HALF


@pytest.fixture
def slanted() -> Scene:
    """An inclined pane that fills the view, and a pane with edges, in front of a wall."""
    pane = Object("pane", quad((0, 0, -5), (8, 0, 6), (0, 8, 1)), Material(0.5, emission=RED))
    part = Object("part", quad((0, 0, -4), (0.9, 0.3, 0), (-0.3, 0.9, 0)), Material(0.5))
    wall = Object("wall", quad((0, 3, -30), (99, 0, 0), (0, 3, 0)), Material(emission=WHITE))
    return Scene("slanted", Camera((0, 0, 0), (0, 0, -1)), (pane, part, wall), background=BLUE)


@pytest.mark.parametrize("samples", [1, 4])
@pytest.mark.parametrize("correction", ["none", "depth"])
def test_a_surface_does_not_hide_itself(
    device: Device, slanted: Scene, correction: str, samples: int
) -> None:
    alone = replace(slanted, objects=slanted.objects[:1])
    name = f"stochastic[correction={correction},msaa={samples},precision=float]"
    found = render(device, alone, name, size=(96, 96))
    # Half of 16 samples in each pixel, for any slope.
    np.testing.assert_allclose(found, np.full_like(found, 0.5) * [1, 0, 1], atol=1e-6)


def test_four_samples_antialias_edges(device: Device, slanted: Scene) -> None:
    size = (96, 96)
    exact = render(device, slanted, "a_buffer", size=(384, 384))
    smooth = exact.reshape(96, 4, 96, 4, 3).mean(axis=(1, 3))
    error = {}
    for samples in (1, 4):
        name = f"stochastic[samples=64,precision=float,msaa={samples}]"
        error[samples] = abs(render(device, slanted, name, size=size) - smooth).mean(axis=-1)
    assert error[4].mean() < 0.6 * error[1].mean()
    assert np.quantile(error[4], 0.999) < 0.15


def test_four_samples_share_one_set_of_depths(device: Device, slanted: Scene) -> None:
    name = "stochastic[samples=16,msaa=4]"
    with opened(device, slanted, name, (64, 48)) as frame:
        # Salvi et al. 2011, table 1: 91.4 MBytes for 1280×720 pixels.
        bits = accounting.memory(frame).bits_per_pixel
        assert bits == 8 * (4 * 16 + 10 * 4)
        assert bits / 8 * 1280 * 720 / 2**20 == pytest.approx(91.4, abs=0.05)
        frame.render()
        measured = frame.measure()
        terms = accounting.traffic(frame, measured).terms
        clears = {t.resource: t.items for t in terms if t.kind == "clear"}
        assert clears["depths0"] == 64 * 48
        assert clears["sum"] == clears["total"] == 4 * 64 * 48
        cover = next(t for t in terms if t.pass_.startswith("cover") and t.kind == "write")
        gather = next(t for t in terms if t.pass_.startswith("gather") and t.kind == "write")
        assert 3.9 * cover.items < gather.items < 4.1 * cover.items
        centers = frame.read("depths0")
    with opened(device, slanted, "stochastic[samples=16]", (64, 48)) as frame:
        frame.render()
        np.testing.assert_array_equal(frame.read("depths0"), centers)


def test_four_samples_do_not_change_pixels_that_are_covered_completely(device: Device) -> None:
    for correction in CORRECTIONS:
        one, four = (
            render(device, random_lists(6), f"stochastic[correction={correction},msaa={n}]")
            for n in (1, 4)
        )
        np.testing.assert_array_equal(one, four)


@pytest.mark.parametrize("correction", CORRECTIONS)
def test_coincident_layers_transmit_their_product_and_are_not_negative(
    device: Device, correction: str
) -> None:
    pair = scene_of(stack([Layer(2.0, 0.5, NOTHING)] * 2), WHITE)
    found = render(device, pair, f"stochastic[correction={correction}]")
    assert (found >= 0).all()
    if correction != "none":
        assert found == pytest.approx(np.full_like(found, 0.25), abs=HALF)

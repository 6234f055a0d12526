"""The mean of several frames: random numbers of their own, convergence, and accounts."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from oitbench.errors import DeclarationError
from oitbench.gl.device import Device
from oitbench.measure import accounting
from oitbench.measure.oracle import composite
from oitbench.parameters import Parameter
from oitbench.scene import Floats
from tests.helpers import (
    BACKGROUND,
    GREEN,
    NOTHING,
    RED,
    WHITE,
    Layer,
    foreign_method,
    keeps_promises,
    method,
    opened,
    random_lists,
    render,
    scene_of,
    stack,
    write_method,
)
from tests.models import stochastic

LAYERS = [Layer(1.5, 0.3, RED), Layer(3.0, 0.55, (0.2, 0.1, 0.7)), Layer(5.0, 0.2, WHITE)]
UNBIASED = [
    "stochastic[samples=4,correction=none,precision=float,noise=white,frames={}]",
    "stochastic[samples=4,correction=none,precision=float,noise=blue,frames={}]",
    "hashed_alpha[scale=0.25,noise=white,frames={}]",
    "hashed_alpha[scale=0.25,noise=blue,frames={}]",
]


@pytest.mark.parametrize("noise", ["white", "blue"])
@pytest.mark.parametrize("samples", [8, 48])
def test_the_picture_is_the_mean_of_the_model_over_frames(
    device: Device, samples: int, noise: str
) -> None:
    lists, count = random_lists(5), 3
    name = f"stochastic[samples={samples},precision=float,noise={noise},frames={count}]"
    found = render(device, lists, name)
    frames = [
        stochastic.composite(lists, BACKGROUND, samples, "depth", frame=k, noise=noise)
        for k in range(count)
    ]
    assert abs(frames[0] - frames[1]).max() > 0.01
    np.testing.assert_allclose(found, np.mean(frames, axis=0), rtol=0, atol=2.0**-17)


def errors(device: Device, name: str, count: int) -> Floats:
    """Return the errors of the picture of `count` frames, (n, 3); all pixels have one list."""
    found = render(device, stack(LAYERS, 64), name.format(count)).reshape(-1, 3)
    return np.asarray(found - composite(stack(LAYERS, 1), BACKGROUND)[0, 0])


@pytest.mark.parametrize("name", UNBIASED)
def test_errors_fall_with_the_root_of_the_number_of_frames(device: Device, name: str) -> None:
    counts = [1, 4, 16, 64]
    found = [errors(device, name, count) for count in counts]
    for error in found:
        # The mean over all pixels is exact, within four standard errors and a half float.
        bound = 4 * error.std(axis=0) / np.sqrt(len(error)) + 2.0**-12
        assert (abs(error.mean(axis=0)) <= bound).all()
    sizes = [np.sqrt((error**2).mean()) for error in found]
    slope = np.polyfit(np.log(counts), np.log(sizes), 1)[0]
    assert slope == pytest.approx(-0.5, abs=0.03)
    assert sizes[-1] == pytest.approx(sizes[0] / 8, rel=0.1)


def test_the_bias_of_a_correction_is_left(device: Device) -> None:
    name = "stochastic[samples=4,precision=float,frames={}]"
    one, many = (errors(device, name, count) for count in (1, 64))
    assert many.std() < 0.2 * one.std()
    assert abs(many.mean(axis=0)).max() == pytest.approx(abs(one.mean(axis=0)).max(), rel=0.3)
    assert abs(many.mean(axis=0)).max() > 10 * many.std(axis=0).max() / 64


@pytest.mark.parametrize("name", ["stochastic", "stochastic[samples=64]", "hashed_alpha"])
def test_two_frames_differ_and_each_is_drawn_over_the_opaque_picture(
    device: Device, name: str
) -> None:
    def several(count: int) -> Floats:
        chosen = f"{name.rstrip(']')}{',' if '[' in name else '['}frames={count}]"
        return render(device, random_lists(4), chosen).astype(np.float64)

    first, mean = several(1), several(2)
    second = 2 * mean - first
    assert abs(first - second).max() > 0.01
    # The second frame by itself is a picture as good as the first one.
    exact = render(device, random_lists(4), "a_buffer")
    sizes = [np.sqrt(((picture - exact) ** 2).mean()) for picture in (first, second)]
    assert sizes[1] == pytest.approx(sizes[0], rel=0.25)


def test_memory_grows_by_the_sum_and_traffic_with_the_frames(device: Device) -> None:
    lists, pixels, count = random_lists(3), 256, 5
    found = {}
    for frames in (1, count):
        with opened(device, scene_of(lists), f"stochastic[frames={frames}]") as frame:
            frame.render()
            measured = frame.measure()
            memory = accounting.memory(frame).bytes
            found[frames] = memory, accounting.traffic(frame, measured).bytes
            runs = [record.runs for record in measured.passes]
            assert runs == [frames] * (4 if frames == 1 else 6)
            parts = list(frame.plan.parts.values())
    assert parts[-2:] == ["accumulate", "mean"]
    assert found[count][0] == found[1][0] + 16 * pixels
    # Accumulating reads 8 bytes, blends and writes 16 each; the mean reads 16 and writes 8.
    assert found[count][1] == count * (found[1][1] + 64 * pixels) + 16 * pixels


def test_samples_of_a_pixel_are_accumulated_one_by_one(device: Device) -> None:
    one, four = (render(device, random_lists(4), f"stochastic[frames=3,msaa={n}]") for n in (1, 4))
    np.testing.assert_array_equal(one, four)
    with opened(device, scene_of(random_lists(1)), "stochastic[frames=3,msaa=4]") as frame:
        assert ("accumulated", 4 * 16 * 256) in frame.plan.target_bytes()


class Repeated(type(method("a_buffer"))):  # type: ignore[misc]
    """The list method that counts fragments first; its frames are all the same."""

    frames = Parameter(1, low=1)
    storage = Parameter("counted", choices=("linked", "counted"))


def test_frames_of_lists_that_do_not_fit_in_memory_are_drawn_in_parts(device: Device) -> None:
    lists = random_lists(6, side=160)
    expected = render(device, lists, Repeated())
    with opened(device, scene_of(lists), Repeated(frames=4), block_limit=2**19) as frame:
        assert len(frame.resources.regions) > 1
        frame.render()
        np.testing.assert_array_equal(frame.image(), expected)
        measured = frame.measure()
        assert measured.passes[0].fragments == 4 * int(frame.complexity.sum())
        terms = accounting.traffic(frame, measured).terms
        cleared = {term.resource: term.items for term in terms if term.kind == "clear"}
        # Fragments are counted twice.
        counters = {"stored": 4 * 160**2, "heads": 4 * 160**2}
        assert cleared == {**counters, "accumulated": 160**2}


def test_interleaved_passes_run_once_per_frame(device: Device) -> None:
    class Twice(type(method("sorted_two_pass"))):  # type: ignore[misc]
        frames = Parameter(1, low=1)

    lists = random_lists(4)
    with opened(device, scene_of(lists), Twice(frames=4)) as frame:
        frame.render()
        assert [record.runs for record in frame.measure().passes] == [4] * 4
        np.testing.assert_array_equal(frame.image(), render(device, lists, "sorted_two_pass"))


@pytest.mark.parametrize("name", ["stochastic[frames=3]", "hashed_alpha[frames=3]"])
def test_a_picture_that_is_drawn_again_has_the_same_random_numbers(
    device: Device, name: str
) -> None:
    with opened(device, scene_of(random_lists(4)), name) as frame:
        frame.render()
        first = frame.image()
        frame.render()
        np.testing.assert_array_equal(frame.image(), first)


def test_transmittance_is_accumulated_too(device: Device) -> None:
    glass = stack([Layer(1.0, 0.5, RED), Layer(2.0, 0.5, GREEN)])
    with opened(device, scene_of(glass, NOTHING), "hashed_alpha[frames=64]") as frame:
        frame.render(transmittance=True)
        assert frame.image().mean() == pytest.approx(0.25, abs=0.02)


def test_a_target_cannot_have_the_name_of_the_sum(device: Device, tmp_path: Path) -> None:
    folder = write_method(
        tmp_path / "named", "()", '{"accumulated": Target("r8")}', members="frames = Parameter(2)"
    )
    with pytest.raises(DeclarationError, match="rename the target 'accumulated'"):
        render(device, random_lists(1), foreign_method(folder))


@pytest.mark.parametrize(
    "name",
    [
        "stochastic[noise=blue,frames=2]",
        "hashed_alpha[noise=blue,frames=2]",
        "hashed_alpha[frames=2]",
    ],
)
def test_the_mean_of_frames_keeps_the_promises(device: Device, name: str) -> None:
    keeps_promises(device, name)

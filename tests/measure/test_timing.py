"""Times of frames under a clock that only the patched parts of the engine advance."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import ExitStack
from typing import Any

import pytest

from oitbench.errors import CapabilityError
from oitbench.gl.batches import Batch
from oitbench.gl.device import Device
from oitbench.gl.frame import Frame
from oitbench.gl.program.compiled_pass import CompiledPass
from oitbench.gl.shading.backdrop import Backdrop
from oitbench.gl.shading.opaque import OpaquePicture
from oitbench.gl.uploaded_scene import UploadedScene
from oitbench.measure import timing
from oitbench.measure.clock import Drawn, Parts, WallClock
from oitbench.measure.disturbance import Usage
from oitbench.measure.rounds import WARM_UP, Schedule
from oitbench.measure.timing import MethodSample, Timings, remark
from oitbench.results.times import Processor
from oitbench.scene import Camera
from tests.helpers import collection, method

SORT, DRAW, OPAQUE, DERIVE = (count / 1024 for count in (5.0, 1.0, 2.0, 0.25))
"""Seconds that the patched parts take."""
CPU = Processor("abacus", 1)
NINE = Schedule(9, budget=0.0)


class Time:
    """A clock that stands still between the patched parts."""

    def __init__(self, patch: pytest.MonkeyPatch, device: Device) -> None:
        self.seconds, self._patch = 0.0, patch
        self.clock = WallClock(device.finish, lambda: self.seconds)
        for owner, name, taken in (
            (Batch, "arrange", SORT),
            (CompiledPass, "draw", DRAW),
            (CompiledPass, "draw_screen", DRAW),
            (OpaquePicture, "draw", OPAQUE),
            (Backdrop, "derive", DERIVE),
        ):
            self.slow(owner, name, taken)

    def patch(self, owner: type, name: str, value: Callable[..., Any]) -> None:
        """Replace a method."""
        self._patch.setattr(owner, name, value)

    def slow(self, owner: type, name: str, taken: float) -> None:
        """Let a method take some time."""
        original: Callable[..., Any] = getattr(owner, name)

        def slowed(*arguments: Any, **named: Any) -> Any:
            self.seconds += taken
            return original(*arguments, **named)

        self._patch.setattr(owner, name, slowed)


@pytest.fixture
def time(device: Device, monkeypatch: pytest.MonkeyPatch) -> Time:
    return Time(monkeypatch, device)


def frames_of(
    stack: ExitStack, device: Device, scene: str, names: Iterable[str]
) -> dict[str, Frame]:
    """Return rendered frames of a scene."""
    uploaded = stack.enter_context(UploadedScene(device, collection().build_scene(scene)))
    frames = {}
    for name in names:
        chosen = method(name)
        effects = uploaded.scene.effects & chosen.shows
        frames[name] = stack.enter_context(Frame(uploaded, chosen, (16, 12), effects))
        frames[name].render()
    return frames


def measured(
    device: Device, time: Time, *names: str, scene: str = "layer_stack[count=3]", **more: Any
) -> Timings:
    with ExitStack() as stack:
        frames = frames_of(stack, device, scene, names)
        # To the schedule, nothing takes time: no task is slow, however busy the machine is.
        given: Mapping[str, Any] = {"meter": lambda: None, "now": lambda: 0.0, **more}
        return timing.measure(frames, NINE, time.clock, CPU, **given)


def test_sorting_is_a_part_of_the_method(device: Device, time: Time) -> None:
    found = measured(device, time, "sorted_over", "alpha_blend").times
    sorted_over, alpha_blend = found["sorted_over"], found["alpha_blend"]
    assert sorted_over.method_ms.samples == [1000 * (SORT + DERIVE + DRAW)] * 9
    assert sorted_over.sort_ms is not None
    assert sorted_over.sort_ms.samples == [1000 * SORT] * 9
    # Geometry that stays in the order of submission is arranged once, before any frame.
    assert alpha_blend.method_ms.samples == [1000 * (DERIVE + DRAW)] * 9
    assert alpha_blend.sort_ms is None


def test_every_sort_computes_the_distances_again(
    device: Device, time: Time, monkeypatch: pytest.MonkeyPatch
) -> None:
    time.slow(Camera, "view_distance", DRAW)
    found = measured(device, time, "sorted_over", "sorted_two_pass[sort=triangle]").times
    for one in found.values():
        assert one.sort_ms is not None
        assert one.sort_ms.samples == [1000 * (SORT + DRAW)] * 9


def test_a_frame_is_the_sum_of_the_method_and_of_shading(device: Device, time: Time) -> None:
    found = measured(device, time, "alpha_blend").times["alpha_blend"]
    assert found.shading_ms.samples == [1000 * OPAQUE] * 9
    assert found.frame_ms.samples == [1000 * (OPAQUE + DERIVE + DRAW)] * 9
    assert found.gpu_ms is None
    assert found.block.clock == "wall"
    assert found.block.cpu == CPU


def test_every_pass_has_samples(device: Device, time: Time) -> None:
    found = measured(device, time, "weighted_blended", "sorted_two_pass", "depth_peeling").times
    names = {name: [part.name for part in one.passes] for name, one in found.items()}
    assert names == {
        "weighted_blended": ["start of the frame", "gather", "resolve"],
        "sorted_two_pass": ["start of the frame", "modulate and add"],
        "depth_peeling": [
            "start of the frame",
            "peel",
            "add",
            "attenuate",
            "mark block=16",
            "combine",
        ],
    }
    for one in found.values():
        assert all(len(part.ms.samples) == 9 for part in one.passes)
        drawn = one.method_ms.median - (one.sort_ms.median if one.sort_ms else 0.0)
        assert sum(part.ms.median for part in one.passes) == drawn
        assert one.remark == ""
    # Two draws for each of three objects.
    assert found["sorted_two_pass"].passes[1].ms.median == 1000 * 2 * 3 * DRAW


LIT = "foggy_street[detail=0.05]"


def calls_of(patch: pytest.MonkeyPatch, name: str) -> list[Frame]:
    """Return a list that grows with each call of a method of `Frame`."""
    calls: list[Frame] = []
    original = getattr(Frame, name)

    def counted(frame: Frame, *arguments: Any) -> None:
        calls.append(frame)
        original(frame, *arguments)

    patch.setattr(Frame, name, counted)
    return calls


def test_shared_shading_is_timed_once_per_round(
    device: Device, time: Time, monkeypatch: pytest.MonkeyPatch
) -> None:
    shaded, opaque = (calls_of(monkeypatch, name) for name in ("shade", "draw_backdrop"))
    names = ("alpha_blend", "weighted_blended", "phenomenological", "a_buffer")
    found = measured(device, time, *names, scene=LIT).times
    # As a whole and by its parts. `a_buffer` has an opaque picture in another number format.
    assert len(shaded) == 2 * (9 + WARM_UP)
    assert len(opaque) == 2 * (9 + WARM_UP)
    # Fog is drawn by the method: its shading is that of a method without fog.
    assert len({str(found[name].shading[:-1]) for name in names}) == 1
    assert found["alpha_blend"].shading_ms == found["phenomenological"].shading_ms


def test_shading_is_the_sum_of_its_parts(device: Device, time: Time) -> None:
    one = measured(device, time, "alpha_blend", scene=LIT).times["alpha_blend"]
    parts = {part.name: part.ms.median for part in one.shading}
    assert list(parts) == ["shadow maps", "opacity slices", "opaque picture"]
    assert all(median >= 1000 * DRAW for median in parts.values())
    assert one.shading_ms.samples == [sum(parts.values())] * 9
    assert one.frame_ms.samples == [one.shading_ms.median + one.method_ms.median] * 9


def test_a_scene_without_lights_has_no_other_shading(
    device: Device, time: Time, monkeypatch: pytest.MonkeyPatch
) -> None:
    shaded = calls_of(monkeypatch, "shade")
    found = measured(device, time, "alpha_blend").times["alpha_blend"]
    assert [part.name for part in found.shading] == ["opaque picture"]
    assert shaded == []


def test_a_frame_that_fails_costs_no_other_its_times(
    device: Device, time: Time, monkeypatch: pytest.MonkeyPatch
) -> None:
    composite = Frame.composite

    def failing(frame: Frame, *arguments: Any) -> None:
        if frame.plan.label == "alpha_blend":
            raise CapabilityError("no more memory")
        composite(frame, *arguments)

    monkeypatch.setattr(Frame, "composite", failing)
    found = measured(device, time, "alpha_blend", "weighted_blended")
    assert list(found.times) == ["weighted_blended"]
    assert str(found.errors["alpha_blend"]) == "no more memory"


def moments(shares: Iterable[float]) -> Iterator[Usage]:
    """Yield the CPU time before and after blocks in which others took these shares of it."""
    for share in shares:
        yield Usage(0.0, 0.0, 0.0, cores=2)
        yield Usage(2.02 + 2 * 10 * share, 2.0, 10.0, cores=2)


@pytest.mark.parametrize(
    ("shares", "foreign", "repeated", "disturbed"),
    [
        ([0.049], 0.049, False, False),
        ([0.06, 0.01], 0.01, True, False),
        ([0.06, 0.20], 0.06, True, True),
        ([0.30, 0.07], 0.07, True, True),
    ],
)
def test_a_disturbed_block_is_repeated_once_and_then_marked(
    device: Device,
    time: Time,
    shares: list[float],
    foreign: float,
    repeated: bool,
    disturbed: bool,
) -> None:
    left = moments(shares)
    found = measured(device, time, "alpha_blend", meter=lambda: next(left))
    block = found.times["alpha_blend"].block
    assert block.foreign == pytest.approx(foreign)
    assert (block.repeated, block.disturbed) == (repeated, disturbed)
    assert list(left) == []


def test_an_unknown_disturbance_is_no_disturbance(device: Device, time: Time) -> None:
    block = measured(device, time, "alpha_blend").times["alpha_blend"].block
    assert (block.foreign, block.repeated, block.disturbed) == (None, False, False)


def drawn(ms: float, gpu: float | None = None) -> list[MethodSample]:
    gpus = [None if gpu is None else gpu + k / 100 for k in range(9)]
    return [MethodSample(None, Drawn(ms + k / 100, gpus[k])) for k in range(9)]


def passes(ms: float) -> list[Parts]:
    return [Parts({0: ms / 2 + k / 100, 1: ms / 2}, laps=24) for k in range(9)]


@pytest.mark.parametrize(
    ("method", "parts", "text"),
    [
        (drawn(10.0), passes(10.0), ""),
        (drawn(10.0), passes(10.05), ""),
        (
            drawn(10.0),
            passes(12.0),
            "One by one, the parts of the drawing take 12 ms, 2 ms more than together: the renderer"
            " is waited for 24 times.",
        ),
        (drawn(10.0)[:5], passes(10.0)[:5], "There are too few samples to add up the passes."),
        (drawn(10.0, gpu=10.0), passes(10.0), ""),
        (
            drawn(20.0, gpu=10.0),
            passes(10.0),
            "The CPU takes 20 ms to submit the passes, which counts: the GPU needs 10 ms to draw"
            " them.",
        ),
    ],
    ids=["equal", "within the interval", "waits", "few samples", "GPU", "submission"],
)
def test_a_remark_says_why_the_passes_do_not_add_up(
    method: list[MethodSample], parts: list[Parts], text: str
) -> None:
    assert remark(method, parts) == text


def test_a_slow_frame_of_long_passes_is_timed_once_for_itself_and_its_passes(
    device: Device, time: Time, monkeypatch: pytest.MonkeyPatch
) -> None:
    drawn: list[int] = []
    original, taken = Frame.composite, [0.0]

    def composite(frame: Frame, *arguments: Any) -> None:
        drawn.append(1)
        time.seconds += taken[0]
        original(frame, *arguments)

    def run(seconds: float, long_lap: float) -> Any:
        monkeypatch.setattr(timing, "_LONG_LAP", long_lap)
        before, taken[0] = len(drawn), seconds
        names = ("sorted_two_pass", "alpha_blend")
        found = measured(device, time, *names, now=lambda: time.seconds).times[names[0]]
        return found, len(drawn) - before

    time.patch(Frame, "composite", composite)
    (quick, most), (together, few), (apart, many) = run(0.0, 10.0), run(0.5, 10.0), run(0.5, 1000.0)
    # Two frames, each as a whole and by its passes: eleven rounds, or one and six. Passes that come
    # before the first whole frame are timed as well.
    assert most == 2 * 2 * 11
    assert 2 * 7 <= few <= 2 * 8
    assert many == 2 * 2 * 7
    for found, count, seconds in ((quick, 9, 0.0), (together, 6, 0.5), (apart, 6, 0.5)):
        assert [one.name for one in found.passes] == [one.name for one in quick.passes]
        assert {len(one.ms.samples) for one in found.passes} == {count}
        assert found.method_ms.median == quick.method_ms.median + 1000 * seconds
        assert found.remark == ""

"""Renderings of shots, and the lifetime of scenes and frames."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import Any

import pytest

from oitbench.gl.device import Device
from oitbench.gl.frame import Frame
from oitbench.gl.uploaded_scene import UploadedScene
from oitbench.stability import render
from oitbench.stability.check import Check, Expectation, Rendering, Shot
from oitbench.stability.layers import random_lists, scene_of
from oitbench.stability.result import CheckResult
from tests.helpers import method, run_checks


class UnexpectedError(Exception):
    """An error that no part of the suite expects."""


@dataclass
class Watch:
    """Kinds of the scenes and frames that exist, and the number of those that were made."""

    alive: list[str] = field(default_factory=list)
    made: Counter[str] = field(default_factory=Counter)
    broken: str = ""
    """Kind that fails from the second one on."""


@pytest.fixture
def watch(monkeypatch: pytest.MonkeyPatch) -> Watch:
    """Watch the lifetime of scenes and frames."""
    found = Watch()

    def watched(base: type[Any], kind: str) -> type[Any]:
        class Watched(base):  # type: ignore[misc]
            def __init__(self, *arguments: Any) -> None:
                if kind == found.broken and found.made[kind]:
                    raise UnexpectedError
                super().__init__(*arguments)
                found.alive.append(kind)
                found.made[kind] += 1

            def release(self) -> None:
                found.alive.remove(kind)
                super().release()

        return Watched

    monkeypatch.setattr(render, "Frame", watched(Frame, "frame"))
    monkeypatch.setattr(render, "UploadedScene", watched(UploadedScene, "scene"))
    return found


def check_of(expect: Any) -> Check:
    return Check("fails", "", tuple(Shot(scene_of(random_lists(n))) for n in (1, 2)), expect)


def test_shots_of_one_scene_and_size_share_a_frame(device: Device, watch: Watch) -> None:
    scene, other = scene_of(random_lists(3)), scene_of(random_lists(2))
    shots = [
        Shot(scene),
        Shot(scene, permutation=1),
        Shot(scene, transmittance=True),
        Shot(scene, (4, 4)),
        Shot(other),
    ]
    with render.UploadedScenes(device, shots) as scenes:
        assert watch.alive == ["scene", "scene"]
        found = scenes.render(method("alpha_blend"), shots, times=2)
        assert watch.alive == ["scene", "scene"]
    assert watch.made == {"scene": 2, "frame": 3}
    assert watch.alive == []
    assert [len(taken) for taken in found] == [2] * 5
    first = [one.image for one, _ in found]
    assert [image.shape[0] for image in first] == [16, 16, 16, 4, 16]
    for a, b in ((0, 1), (0, 2)):
        assert (first[a] != first[b]).any()


def test_images_of_random_methods_are_enlarged(device: Device) -> None:
    shots = [Shot(scene_of(random_lists(1)))]
    with render.UploadedScenes(device, shots) as scenes:
        for name, side in (("a_buffer", 16), ("stochastic", 32)):
            ((found,),) = scenes.render(method(name), shots)
            assert found.color.shape == found.opaque_color.shape == (side, side, 4)


def test_nothing_leaks_if_an_expectation_raises(device: Device, watch: Watch) -> None:
    def expect(renderings: Sequence[Rendering]) -> Iterable[Expectation]:
        assert watch.alive == ["scene", "scene"]
        raise UnexpectedError

    with pytest.raises(UnexpectedError):
        run_checks(device, [method("a_buffer")], [check_of(expect)])
    assert watch.alive == []


def test_nothing_leaks_if_a_frame_raises(
    device: Device, watch: Watch, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(self: Frame, name: str) -> None:
        assert "frame" in watch.alive
        raise UnexpectedError

    monkeypatch.setattr(Frame, "read", fail)
    with pytest.raises(UnexpectedError):
        run_checks(device, [method("a_buffer")], [check_of(list)])
    assert watch.alive == []


def test_nothing_leaks_if_progress_cannot_be_reported(device: Device, watch: Watch) -> None:
    def expect(renderings: Sequence[Rendering]) -> Iterable[Expectation]:
        yield Expectation(renderings[0].image, renderings[0].image)

    def report(result: CheckResult) -> None:
        raise UnexpectedError

    with pytest.raises(UnexpectedError):
        run_checks(device, [method("a_buffer")], [check_of(expect)], report)
    assert watch.alive == []


@pytest.mark.parametrize("kind", ["scene", "frame"])
def test_nothing_leaks_if_the_second_one_cannot_be_made(
    device: Device, watch: Watch, kind: str
) -> None:
    watch.broken = kind
    with pytest.raises(UnexpectedError):
        run_checks(device, [method("a_buffer")], [check_of(list)])
    assert watch.made[kind] == 1
    assert watch.alive == []

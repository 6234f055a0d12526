"""Timed pictures equal scored ones, for every method; methods that cheat are caught."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import pytest

from oitbench.gl.device import Device
from oitbench.gl.frame import Frame
from oitbench.gl.uploaded_scene import UploadedScene
from oitbench.matrix.bench import Bench
from oitbench.matrix.cell import Cell
from oitbench.matrix.timed_cells import ScoredCell, Timing, time_cells
from oitbench.measure.rounds import Schedule
from oitbench.plugins import Collection
from oitbench.results.schema import Record
from oitbench.truths import EXACT
from tests.helpers import collection, method, write_method

METHODS = (
    *Collection.load().methods,
    "a_buffer[msaa=4]",
    "a_buffer[node=compact,resolve=iterative]",
    "sorted_two_pass[sort=triangle]",
    "stochastic[msaa=4]",
)
CASES = {
    "layer_stack[count=12]": METHODS,
    "smoke_and_glass[detail=0.03]": ("phenomenological[subsample=4]", "sorted_over"),
    "foggy_street[detail=0.05]": ("phenomenological", "alpha_blend"),
    "foliage[light=sky,detail=0.1]": ("stochastic[msaa=4]",),
}
"""All methods; particles and refraction; fog and diffusion; ambient occlusion, in few frames since
their shaders take long to compile."""
SIZE = (40, 30)
ONCE = Schedule(rounds=1, budget=0.0)


Timed = dict[str, dict[str, Timing]]


@pytest.fixture(scope="module")
def timings(device: Device) -> Timed:
    """The times of all cases by scene and method, with the verdict on their pictures."""
    with device.context:
        return {scene: time_all(device, scene, names) for scene, names in CASES.items()}


def time_all(device: Device, label: str, names: Sequence[str]) -> dict[str, Timing]:
    fine = (2 * SIZE[0], 2 * SIZE[1])
    scene = collection().build_scene(label)
    cells = []
    with UploadedScene(device, scene) as uploaded:
        for name in names:
            chosen = method(name)
            with Frame(uploaded, chosen, fine, scene.effects & chosen.shows) as scored:
                cells.append(ScoredCell(Cell(label, name, SIZE), scored.plan.digest))
        timings = time_cells(device, collection(), scene, cells, ONCE)
        return dict(zip(names, timings, strict=True))


@pytest.mark.parametrize(
    ("scene", "name"), [(scene, name) for scene, names in CASES.items() for name in names]
)
def test_the_timed_picture_is_the_scored_one(timings: Timed, scene: str, name: str) -> None:
    timing = timings[scene][name]
    assert timing.reason == ""
    assert not timing.suspect
    assert timing.time is not None


def test_a_timed_frame_that_lacks_a_pass_is_suspect(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The engine's own claim is checked: here its timed frame stops before the last pass."""
    composite = Frame.composite

    def incomplete(frame: Frame, *arguments: Any) -> None:
        steps = frame._steps
        frame._steps = steps[:-1]
        composite(frame, *arguments)
        frame._steps = steps

    monkeypatch.setattr(Frame, "composite", incomplete)
    (timing,) = timed(Collection.load(), tmp_path, "weighted_blended")
    assert timing.suspect
    assert timing.time is None
    assert "the timed picture differs from the scored one" in timing.reason


def timed(plugins: Collection, folder: Path, *names: str) -> list[Timing]:
    """Score the methods in one scene, and time them."""
    with Bench(plugins, folder) as bench:
        cells = [
            Cell("layer_stack[count=3]", name, (12, 8), permutations=1, truths=(EXACT,))
            for name in names
        ]
        records = [bench.run(cell) for cell in cells]
        assert [record.reason for record in records] == [""] * len(records)
        plans = [record.outcome.plan for record in records if record.outcome is not None]
        scored = [ScoredCell(cell, plan) for cell, plan in zip(cells, plans, strict=True)]
        return bench.time(scored, ONCE)


def cheat(folder: Path, honest_calls: int) -> Collection:
    """Return a collection with a method that leaves its passes out after some calls of `plan`."""
    write_method(
        folder / "cheat",
        passes="(Gather('draw.glsl', writes={'color': OVER}),) if honest() else ()",
        members="expresses = Effect.COVERAGE",
        draw="void gather(Fragment fragment) { color = premultiplied(fragment); }\n",
    )
    text = (folder / "cheat" / "method.py").read_text(encoding="utf-8")
    text += (
        "\ncalls = []\ndef honest():\n    calls.append(1)\n"
        f"    return len(calls) <= {honest_calls}\n"
    )
    (folder / "cheat" / "method.py").write_text(text, encoding="utf-8")
    plugins = Collection.load()
    plugins.places.add_method(folder / "cheat")
    return plugins


def test_a_method_with_other_passes_while_it_is_timed_is_suspect(tmp_path: Path) -> None:
    found = timed(cheat(tmp_path, honest_calls=3), tmp_path / "out", "cheat", "alpha_blend")
    reason = "the method declares other passes when it is timed"
    assert found[0] == Timing(reason=reason, suspect=True)
    assert found[1].time is not None


@pytest.mark.parametrize(
    ("honest_calls", "reason"),
    [(1, "when it is counted"), (2, "when its draws are permuted")],
)
def test_a_method_with_other_passes_while_it_is_measured_fails(
    honest_calls: int, reason: str, tmp_path: Path
) -> None:
    cell = Cell("layer_stack[count=3]", "cheat", (12, 8), permutations=1, truths=(EXACT,))
    with Bench(cheat(tmp_path, honest_calls), tmp_path / "out") as bench:
        record: Record = bench.run(cell)
    assert record.status == "failed"
    assert reason in record.reason


def test_a_cell_whose_method_changed_since_it_was_scored_gets_no_time(tmp_path: Path) -> None:
    plugins = cheat(tmp_path, honest_calls=99)
    cell = Cell("layer_stack[count=3]", "cheat", (12, 8), permutations=1, truths=(EXACT,))
    with Bench(plugins, tmp_path / "out") as bench:
        record = bench.run(cell)
        assert record.outcome is not None
        scored = [ScoredCell(cell, record.outcome.plan, record.fingerprints)]
        assert bench.time(scored, ONCE)[0].time is not None
        with (tmp_path / "cheat" / "draw.glsl").open("a") as file:
            file.write("float more() { return 1.0; }\n")
        (timing,) = bench.time(scored, ONCE)
        # A later run would not believe that cell either.
        assert bench.run(cell).reason == "cheat: its files changed during the run; run again"
    assert timing == Timing(reason="its files changed during the run; run again")

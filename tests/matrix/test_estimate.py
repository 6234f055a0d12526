"""What a run would take."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import cast

import pytest

from oitbench.errors import UsageError
from oitbench.image.metrics import RMSE
from oitbench.matrix import sampling
from oitbench.matrix.cell import Cell
from oitbench.matrix.estimate import estimate, speedup, timing_seconds
from oitbench.matrix.plan import Matrix, plan_matrix
from oitbench.matrix.probe import ProbedTruth, UsageProbed
from oitbench.matrix.run import run_matrix
from oitbench.matrix.samples import Drawn, Sample, SceneSamples, extrapolate
from oitbench.matrix.sampling import Sampler, choose
from oitbench.measure.rounds import Schedule
from oitbench.results.schema import Scores
from oitbench.results.store import CELLS
from oitbench.truths import EXACT
from oitbench.workers.process import Process
from tests.made_up import outcome_of

SCENES, METHODS = ["glass_bars", "layer_stack[count=3]"], ["a_buffer", "weighted_sum"]


def files(folder: Path) -> set[Path]:
    return {path for path in folder.rglob("*") if path.is_file()}


def test_a_cost_grows_with_the_pixels_from_what_does_not() -> None:
    pixels = (16, 64, 256)
    assert extrapolate(pixels, 5.0 + 16, 5.0 + 64) == pytest.approx(5.0 + 256)
    assert extrapolate(pixels, 5.0, 5.0) == 5.0
    # Noise may make the larger picture the faster one.
    assert extrapolate(pixels, 6.0, 5.0) == 5.0
    assert extrapolate((1, 1, 1), 6.0, 5.0) == 5.0


@pytest.mark.parametrize(
    ("rounds", "schedule", "seconds"),
    [
        # Two to warm up, all that are wanted, and one to open frames.
        ([0.1, 0.1], Schedule(9, 100.0), 0.2 * (2 + 9 + 1)),
        # The budget ends in the 21st round, two of which do not count.
        ([0.1, 0.1], Schedule(31, 4.0), 0.2 * (21 + 1)),
        # The budget is over at once, but each cell takes part in nine rounds, and a slow one in 6.
        ([0.125], Schedule(31, 0.1), 0.125 * (2 + 9 + 1)),
        # A slow cell is timed by its passes alone: one task instead of two.
        ([4.0], Schedule(31, 0.1), 4.0 + 2.0 * (1 + 6)),
        ([0.0], Schedule(9, 4.0), 0.0),
    ],
)
def test_timing_takes_rounds_within_a_budget(
    rounds: list[float], schedule: Schedule, seconds: float
) -> None:
    assert timing_seconds(rounds, schedule) == pytest.approx(seconds)


@pytest.mark.parametrize(
    ("workers", "cores", "busy", "expected"),
    [
        (1, 8, 1.0, 1.0),
        (2, 8, 1.0, 2.0),
        (8, 4, 1.0, 4.0),
        # A software renderer that uses one and a half of two cores leaves little to another worker.
        (2, 2, 1.5, 4 / 3),
        (2, 1, 1.2, 1.0),
        (3, 4, 0.0, 3.0),
    ],
)
def test_workers_share_the_cores(workers: int, cores: int, busy: float, expected: float) -> None:
    assert speedup(workers, cores, busy) == pytest.approx(expected)


def test_all_methods_are_sampled_in_some_scene() -> None:
    cells = [Cell("x", str(number), (8, 8)) for number in range(10)]
    found = {cell for number in range(5) for cell in choose(cells, number, 2)}
    assert found == {*cells}
    assert choose(cells[:1], 3, 2) == cells[:1]
    assert all(len({*choose(cells, number, 4)}) == 4 for number in range(10))


def test_an_estimate_lists_what_is_kept_and_writes_nothing(tmp_path: Path) -> None:
    def planned(scenes: list[str], methods: list[str]) -> Matrix:
        return plan_matrix(
            scenes, methods, "quick", (16, 16), ssaa=1, out=tmp_path / "out", truths=("exact",)
        )

    run_matrix(planned(SCENES[:1], METHODS[:1]))
    before = files(tmp_path)
    found = estimate(planned(SCENES, METHODS))
    assert files(tmp_path) == before
    counts = [(scene.label, len(scene.done), len(scene.todo)) for scene in found.scenes]
    assert counts == [(SCENES[0], 1, 1), (SCENES[1], 0, 2)]
    assert found.todo == 3
    assert found.seconds.keys() == {"building", "drawing", "metrics", "timing", "rest"}
    assert all(0.0 < seconds < math.inf for seconds in found.seconds.values())
    assert found.total == pytest.approx(sum(found.seconds.values()))
    assert 2**27 < found.memory < 2**33
    # Nothing is left to do, so nothing is probed.
    found = estimate(planned(SCENES[:1], METHODS[:1]))
    assert (found.todo, found.seconds, found.unknown) == (0, {}, [])


@pytest.mark.parametrize(("resident", "peak"), [(0, 10**12), (10**12, 0)])
def test_frames_that_are_timed_need_memory_beside_what_is_resident(
    resident: int, peak: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The peak of the probes is past when all frames of a scene are opened."""
    usage = UsageProbed(resident, peak, 0.0)
    monkeypatch.setattr("oitbench.matrix.estimate._usage", lambda worker: usage)
    matrix = plan_matrix(SCENES[:1], METHODS, preset="quick", size=(16, 16), out=tmp_path / "out")
    found = estimate(matrix)
    if peak:
        assert found.memory == peak
    else:
        assert resident < found.memory < resident + 2**26


def test_the_estimated_disk_space_is_that_of_a_run(tmp_path: Path) -> None:
    out = tmp_path / "out"
    matrix = plan_matrix(SCENES[:1], METHODS, preset="guard", size=(64, 64), out=out)
    found = estimate(matrix)
    assert not out.exists()
    run_matrix(matrix)
    written = sum(path.stat().st_size for path in files(out) if path.name != "run.json")
    assert (out / CELLS).is_file()
    assert written / 2 < found.disk < 2 * written


def test_a_cell_that_is_slow_at_a_small_size_is_drawn_at_a_smaller_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sampling, "_SLOW", 0.0)
    matrix = plan_matrix(SCENES[:1], METHODS, preset="quick", size=(64, 64), out=tmp_path / "out")
    stages: list[str] = []
    found = estimate(matrix, lambda labels, stage: stages.append(stage))
    sizes = {stage.split()[-1] for stage in stages if stage.startswith("probing at")}
    # Cells of the costliest scenes are drawn at their full size, if they are fast enough there.
    assert sizes == {"8x8", "16x16", "64x64"}
    assert all(0.0 < seconds < math.inf for seconds in found.seconds.values())


def sample_of(cost: Callable[[tuple[int, int], bool], Drawn | None], cell: Cell) -> Sample:
    """Return the sample of a cell, given what it costs at a size, with permuted draws or not."""
    (sample,) = samples_of(cost, cell).samples
    return sample


def samples_of(cost: Callable[[tuple[int, int], bool], Drawn | None], cell: Cell) -> SceneSamples:
    """Return the samples of a scene with a single cell, as `sample_of`."""

    class MadeUp(Sampler):
        def draw(
            self, cell: Cell, size: tuple[int, int], *, permuted: bool = False
        ) -> Drawn | None:
            return cost(size, permuted)

        def _truths(self, cell: Cell) -> list[ProbedTruth]:
            return []

    sampler = MadeUp(cast(Process, None), None, False, lambda labels, stage: None)
    return sampler.sample([cell], 0, 1)


def drawn(seconds: float, permutations: float = 0.0, rmse: float = 0.1) -> Drawn:
    outcome = outcome_of({EXACT: Scores({RMSE: rmse})}, {})
    return Drawn(seconds, permutations, 0.0, 3.0, 0, outcome)


def test_the_fixed_cost_of_a_slow_cell_does_not_grow() -> None:
    """Millions of triangles take as long in a small picture as in a large one."""
    sample = sample_of(
        lambda size, permuted: drawn(5 + 1e-3 * math.prod(size)), Cell("s", "m", (64, 64))
    )
    assert sample.again == pytest.approx(5 + 1e-3 * 64 * 64)


def test_a_slow_cell_that_fails_at_a_smaller_size_is_drawn_at_a_larger_one() -> None:
    """All layers of hair lie at few pixels then, which are more than a method may hold."""

    def cost(size: tuple[int, int], permuted: bool) -> Drawn | None:
        return None if size[0] < 16 else drawn(5 + 1e-3 * math.prod(size))

    sample = sample_of(cost, Cell("s", "m", (64, 64)))
    assert sample.again == pytest.approx(5 + 1e-3 * 64 * 64)


@pytest.mark.parametrize(
    ("size", "growth"),
    [
        ((512, 512), 1.0),
        # Permuted pictures of a quarter have 64 x 64 pixels, those of a half 128 x 128.
        ((256, 256), 1.0),
        # Permuted pictures of 256 x 144 pixels; those of a quarter of the size have 320 x 180.
        ((1280, 720), (256 * 144) / (320 * 180)),
    ],
)
def test_permuted_draws_do_not_grow_with_the_picture(size: tuple[int, int], growth: float) -> None:
    def cost(size: tuple[int, int], permuted: bool) -> Drawn:
        return drawn(1e-6 * math.prod(size), 7.0 if permuted else 0.0)

    sample = sample_of(cost, Cell("s", "m", size))
    assert sample.permutations == pytest.approx(7.0 * growth)
    assert sample.again == pytest.approx(1e-6 * math.prod(size) + 7.0 * growth)


def test_what_cells_share_may_grow_with_the_picture_and_counts_once() -> None:
    """The first cell at each size uploads its scene (2 s), and draws exact compositing."""
    seen = set()

    def cost(size: tuple[int, int], permuted: bool) -> Drawn:
        shared = 0.0 if size in seen else 2 + 1e-4 * math.prod(size)
        seen.add(size)
        return drawn(1e-5 * math.prod(size) + shared)

    found = samples_of(cost, Cell("s", "m", (256, 256)))
    assert found.sharing == pytest.approx(2 + 1e-4 * 256 * 256)
    assert found.samples[0].again == pytest.approx(1e-5 * 256 * 256)
    assert found.samples[0].first == pytest.approx(0.0)


def test_a_picture_that_equals_exact_compositing_does_not_show_what_scoring_takes() -> None:
    cell = Cell("s", "m", (64, 64))
    assert sample_of(lambda size, permuted: drawn(1.0), cell).metrics == 3.0
    assert sample_of(lambda size, permuted: drawn(1.0, rmse=0.0), cell).metrics is None


def test_truths_that_are_missing_are_counted_and_not_rendered(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    matrix = plan_matrix(
        SCENES[:1],
        METHODS[:1],
        preset="guard",
        size=(17, 17),
        truths=("matched",),
        out=tmp_path / "out",
    )
    assert estimate(matrix).missing == {"matched": 1}
    assert not (tmp_path / "cache" / "oitbench").exists()


def test_truths_that_cannot_be_traced_are_not_missing(tmp_path: Path) -> None:
    matrix = plan_matrix(
        ["fragment_lists[width=8,height=8]"],
        METHODS[:1],
        preset="guard",
        size=(8, 8),
        truths=("matched",),
        out=tmp_path / "out",
    )
    assert estimate(matrix).missing == {}


def test_scenes_that_cannot_be_drawn_are_named(plugins: Path, tmp_path: Path) -> None:
    matrix = plan_matrix(
        ["calm", "crasher"], ["weighted_sum", "broken"], preset="guard", size=(8, 8), out=tmp_path,
        collections=[plugins],
    )  # fmt: skip
    found = estimate(matrix)
    assert found.unknown == ["crasher"]
    assert [len(scene.todo) for scene in found.scenes] == [2, 2]


def test_a_folder_of_something_else_is_refused(tmp_path: Path) -> None:
    (tmp_path / "letter.txt").write_text("x")
    matrix = plan_matrix(SCENES[:1], METHODS[:1], preset="guard", size=(8, 8), out=tmp_path)
    with pytest.raises(UsageError, match="holds something else"):
        estimate(matrix)


def test_forced_cells_are_all_to_do(tmp_path: Path) -> None:
    matrix = plan_matrix(SCENES[1:], METHODS[1:], preset="guard", size=(8, 8), out=tmp_path)
    run_matrix(matrix)
    assert estimate(matrix).todo == 0
    assert estimate(replace(matrix, force=True)).todo == 1

"""Choices from stored records: losses, ties, scenes, renderers."""

from __future__ import annotations

from pathlib import Path

import msgspec
import pytest

from oitbench.choosing import facts
from oitbench.choosing.choice import choose
from oitbench.choosing.constraints import Constraints
from oitbench.errors import UsageError
from oitbench.results.schema import Record, Renderer
from tests.choosing.made_up import cell, demanding
from tests.made_up import failed, write

LISTS = demanding(atomics=True)
SMALL = Constraints(atomics=False)


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Two scenes: lists are best in both, means and peels in one each."""
    cells = [
        cell("lists", 0.0, "panes", demands=LISTS),
        cell("mean", 0.1, "panes"),
        cell("peel", 0.3, "panes"),
        cell("lists", 0.1, "smoke", demands=LISTS),
        cell("mean", 0.3, "smoke"),
        cell("peel", 0.2, "smoke"),
    ]
    return write(tmp_path, cells)


def test_losses_are_to_the_best_of_all_and_the_best_is_among_those_that_fit(folder: Path) -> None:
    found = choose([folder], (), SMALL)
    panes, smoke = found.scenes
    assert [item.cell.method for item in panes.candidates] == ["lists", "mean", "peel"]
    assert [item.loss for item in smoke.candidates] == pytest.approx([0.0, 0.1, 0.2])
    assert (panes.best, panes.chosen) == (("lists",), ("mean",))
    assert (smoke.best, smoke.chosen) == (("lists",), ("peel",))
    assert found.chosen == ("mean",)
    (mean, peel) = found.means
    assert (mean.error, mean.loss, mean.worst) == pytest.approx((0.2, 0.15, 0.2))
    assert peel.method == "peel"
    assert (peel.error, peel.worst) == pytest.approx((0.25, 0.3))
    assert found.misfits() == {"lists": {"needs buffers with atomics": ["panes", "smoke"]}}


def test_without_constraints_the_best_fits(folder: Path) -> None:
    assert choose([folder]).chosen == ("lists",)


def test_scenes_are_chosen_by_label_or_name(tmp_path: Path) -> None:
    labels = ["panes[n=4]", "panes[n=8]", "smoke"]
    cells = [cell("mean", 0.1, label) for label in labels]
    folder = write(tmp_path, [*cells, cell("mean", 0.1, "panes[n=8]", view="plan")])

    def titles(*names: str) -> list[str]:
        return [scene.title for scene in choose([folder], names).scenes]

    assert titles() == ["panes[n=4]", "panes[n=8]", "smoke", "panes[n=8]@plan"]
    assert titles("panes") == ["panes[n=4]", "panes[n=8]", "panes[n=8]@plan"]
    assert titles("panes[n=8]") == ["panes[n=8]", "panes[n=8]@plan"]
    assert titles("panes[n=8]@plan", "smoke") == ["smoke", "panes[n=8]@plan"]
    with pytest.raises(UsageError, match="unknown scene 'smokes'; did you mean smoke"):
        titles("smokes")


def test_methods_that_tie_are_all_best(tmp_path: Path) -> None:
    steps = [1e-3, -1e-3] * 4
    # The standard error of the difference is 2.6e-3, that of the mean of two scenes is 1.9e-3.
    cells = []
    for scene in ("panes", "smoke"):
        cells.append(cell("mean", 0.1, scene, jackknife=[0.1] * 8))
        cells.append(cell("peel", 0.105, scene, jackknife=[0.105 + step for step in steps]))
        cells.append(cell("glow", 0.104, scene, jackknife=[0.104 + step for step in steps]))
        cells.append(cell("lists", 0.2, scene, jackknife=[0.2] * 8))
    found = choose([write(tmp_path, cells)])
    assert [scene.chosen for scene in found.scenes] == [("mean", "glow", "peel")] * 2
    assert [item.loss for item in found.scenes[0].candidates][:2] == [0.0, 0.0]
    # Two scenes with the same difference are more certain than one: 4.4e-3 is clear.
    assert found.chosen == ("mean", "glow")


def test_a_method_that_is_missing_somewhere_is_no_best_of_all(tmp_path: Path) -> None:
    cells = [
        cell("lists", 0.0, "panes"),
        cell("mean", 0.1, "panes"),
        cell("mean", 0.1, "smoke"),
        failed("peel", "no such shader", scene="smoke"),
    ]
    found = choose([write(tmp_path, cells)])
    assert [mean.method for mean in found.means] == ["mean"]
    assert found.chosen == ("mean",)
    assert dict(facts.misfit_rows(found)) == {
        "lists": "was not run (smoke)",
        "peel": "was not run (panes); failed: no such shader (smoke)",
    }


def test_a_method_without_an_error_fits_but_is_no_best(tmp_path: Path) -> None:
    found = choose([write(tmp_path, [cell("mean", None)])])
    assert found.fits
    assert found.chosen == ()
    assert facts.unscored(found) == ["panes: no error against exact compositing of mean"]


def with_renderer(item: Record, name: str) -> Record:
    return msgspec.structs.replace(item, gl=Renderer(name))


def test_results_of_several_renderers_need_a_choice(tmp_path: Path) -> None:
    folders = [
        write(tmp_path / name, [with_renderer(cell("mean", error), name)])
        for name, error in (("fast 1", 0.1), ("fast 12", 0.2), ("slow", 0.3))
    ]
    with pytest.raises(UsageError, match="'fast 1', 'fast 12', 'slow' share no axis"):
        choose(folders)
    with pytest.raises(UsageError, match="unknown renderer 'slowly'; did you mean slow"):
        choose(folders, renderer="slowly")
    # The whole name is meant, although it is part of another one.
    for name, error in (("FAST 1", 0.1), ("12", 0.2), ("low", 0.3)):
        assert choose(folders, renderer=name).means[0].error == error


def test_folders_add_up_but_hold_no_cell_twice(tmp_path: Path) -> None:
    one = write(tmp_path / "one", [cell("mean")])
    other = write(tmp_path / "other", [cell("peel")])
    assert len(choose([one, other]).means) == 2
    with pytest.raises(UsageError, match="one and in an earlier folder; give one"):
        choose([one, other, one])


def test_a_limit_of_time_needs_times(tmp_path: Path) -> None:
    untimed = msgspec.structs.replace(cell("mean"), time=None)
    folder = write(tmp_path, [untimed])
    with pytest.raises(UsageError, match="no cell of these scenes was timed"):
        choose([folder], (), Constraints(milliseconds=5.0))
    assert choose([folder]).fits


def test_a_folder_without_results_is_refused(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="give the folder of a run"):
        choose([tmp_path])

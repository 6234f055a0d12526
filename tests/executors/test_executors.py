"""All executors keep the same promises."""

from __future__ import annotations

import os
import threading
import time
from collections import deque
from collections.abc import Iterator
from pathlib import Path

import psutil
import pytest

from oitbench.errors import UsageError
from oitbench.executors import inventory
from oitbench.executors.executor import Worker
from oitbench.executors.places import Place
from oitbench.matrix.agenda import Agenda, SceneWork
from oitbench.matrix.cell import Cell
from oitbench.workers.cores import usable_cores
from oitbench.workers.process import WorkerError
from tests.executors.far import Act, Done, far_end

PLACES = ("in process", "processes", "cluster")
OTHERS = PLACES[1:]
"""Those whose workers can be lost."""


@pytest.fixture
def place(request: pytest.FixtureRequest) -> Place:
    """A place of two workers, or of this process."""
    match request.param:
        case "in process":
            return Place(workers=0)
        case "processes":
            return Place(workers=2, memory_gib=1.0)
    return Place(dask=request.getfixturevalue("address"))


def act(worker: Worker, unit: list[Act]) -> Iterator[Done]:
    for request in unit:
        yield worker.ask(request, Done)


every = pytest.mark.parametrize("place", PLACES, indirect=True)
others = pytest.mark.parametrize("place", OTHERS, indirect=True)


@every
def test_results_come_one_by_one_and_units_may_be_added(place: Place, tmp_path: Path) -> None:
    units = deque([[Act("1a"), Act("1b")], [Act("2")]])
    found: list[Done] = []
    with place.open(far_end(tmp_path)) as executor:
        for done in executor.collect(units, act):
            if done.text == "1a":
                units.append([Act("3")])
            found.append(done)
        assert executor.ask(Act("alone"), Done).text == "alone"
    texts = [done.text for done in found]
    assert sorted(texts) == ["1a", "1b", "2", "3"]
    assert texts.index("1a") < texts.index("1b")
    of_unit = {done.text: done.pid for done in found}
    assert of_unit["1a"] == of_unit["1b"]
    assert (os.getpid() in of_unit.values()) == (place.workers == 0)


@others
def test_an_idle_worker_joins_the_last_scene(place: Place, tmp_path: Path) -> None:
    cells, joined = [Cell("a", f"m{number}", (8, 8)) for number in range(6)], threading.Event()

    def work(worker: Worker, scene: SceneWork) -> Iterator[tuple[Cell, int]]:
        alone = scene.join()
        if alone:
            scene.begin(cells)
        for place, cell in enumerate(scene.take()):
            if alone and place == 2:
                assert joined.wait(60)
            done = worker.ask(Act("draw"), Done)
            if not alone:
                joined.set()
            scene.count(1.0 if place else 0.0, first=not place)
            yield cell, done.pid

    with place.open(far_end(tmp_path)) as executor:
        found = list(executor.collect(Agenda(cells), work))
    assert sorted(cell.method for cell, _ in found) == [cell.method for cell in cells]
    assert len({pid for _, pid in found}) == 2


@every
def test_files_lie_in_the_folder_when_the_answer_has_come(place: Place, tmp_path: Path) -> None:
    with place.open(far_end(tmp_path)) as executor:
        executor.ask(Act("write"), Done)
        assert (tmp_path / "images" / "one.bin").read_bytes() == bytes(range(256))
    assert [path.name for path in (tmp_path / "images").iterdir()] == ["one.bin"]


@every
def test_an_error_of_a_user_is_the_same_everywhere(place: Place, tmp_path: Path) -> None:
    with place.open(far_end(tmp_path)) as executor:
        with pytest.raises(UsageError, match=r"^no$"):
            executor.ask(Act("refuse"), Done)
        assert executor.ask(Act("next"), Done).text == "next"


@others
def test_a_crash_has_a_reason_and_a_step(place: Place, tmp_path: Path) -> None:
    with place.open(far_end(tmp_path)) as executor:
        with pytest.raises(WorkerError, match=r"ended with code 7 while acting$") as caught:
            executor.ask(Act("exit"), Done)
        assert caught.value.shared
        with pytest.raises(WorkerError, match=r"took longer than 0\.5 s") as caught:
            executor.ask(Act("hang"), Done, 0.5)
        assert caught.value.timeout
        assert executor.ask(Act("next"), Done).text == "next"


@others
def test_a_process_that_was_killed_costs_only_time(place: Place, tmp_path: Path) -> None:
    mark = str(tmp_path / "mark")
    units = deque([[Act("1"), Act("be killed", mark), Act("2")], [Act("3")]])
    with place.open(far_end(tmp_path)) as executor:
        found = sorted(done.text for done in executor.collect(units, act))
        assert found == ["1", "2", "3", "be killed"]
        with pytest.raises(WorkerError, match=r"signal 9 \(SIGKILL\)"):
            executor.ask(Act("be killed"), Done)


def test_a_cluster_survives_the_loss_of_all_its_workers(address: str, tmp_path: Path) -> None:
    lines: list[str] = []
    marks = [str(tmp_path / name) for name in ("first", "second")]
    units = deque([[Act("1"), Act("kill the worker", mark), Act("2")] for mark in marks])
    with Place(dask=address).open(far_end(tmp_path), lines.append) as executor:
        found = sorted(done.text for done in executor.collect(units, act))
    assert found == ["1", "1", "2", "2", "kill the worker", "kill the worker"]
    assert len([line for line in lines if line.startswith("lost: tcp://")]) == 2


def test_a_command_that_stops_ends_what_the_cluster_does_for_it(
    address: str, tmp_path: Path
) -> None:
    units = deque([[Act("start"), Act("hang")]])
    executor = Place(dask=address).open(far_end(tmp_path))
    with executor:
        for done in executor.collect(units, act):
            process = psutil.Process(done.pid)
            time.sleep(0.5)
            break
    executor.stop()
    process.wait(20)


def test_a_worker_of_other_versions_is_left_out(
    address: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(inventory, "package_version", lambda name: "0.0")
    message = r"no worker of the cluster can be used: left out: tcp://.*: it has \S+ \S+, this"
    with pytest.raises(UsageError, match=message + r" machine 0\.0; install the same version"):
        Place(dask=address).open(far_end(tmp_path))


def test_workers_that_fail_a_check_are_left_out(address: str, tmp_path: Path) -> None:
    lines: list[str] = []
    with Place(dask=address).open(far_end(tmp_path), lines.append) as executor:
        seen: list[str] = []

        def check(worker: Worker) -> None:
            seen.append(worker.name)
            if len(seen) == 1:
                raise UsageError("it is slow")

        executor.admit(check)
        assert lines == [f"left out: {seen[0]}: it is slow"]
        units = deque([[Act("1")], [Act("2")]])
        assert len({done.pid for done in executor.collect(units, act)}) == 1

        def refuse(worker: Worker) -> None:
            raise UsageError("it is old")

        with pytest.raises(UsageError, match="it is old"):
            executor.admit(refuse)


def test_places_that_do_not_exist_are_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with pytest.raises(UsageError, match="workers is -1"):
        Place(workers=-1)
    pytest.importorskip("distributed")
    # Nothing answers at these places, however long one waits.
    monkeypatch.setattr("oitbench.executors.cluster._CONNECT_SECONDS", 2.0)
    for wrong in ("tcp://127.0.0.1:9", "nonsense"):
        with pytest.raises(UsageError, match=f"no Dask scheduler answers at {wrong}"):
            Place(dask=wrong).open(far_end(tmp_path))


def test_processes_share_the_cores_among_their_threads(tmp_path: Path) -> None:
    for count in (1, len(usable_cores()), 8 * len(usable_cores())):
        with Place(workers=count).open(far_end(tmp_path)) as executor:
            threads = int(executor.ask(Act("greet"), Done).threads)
        assert threads == max(1, len(usable_cores()) // count)

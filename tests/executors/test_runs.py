"""Runs of the matrix by each executor: equal records, whatever happens to workers."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from oitbench.executors.places import Place
from oitbench.image import stored
from oitbench.matrix.plan import plan_matrix
from oitbench.matrix.run import run_matrix
from oitbench.path_traced.references import making, storage
from oitbench.path_traced.references.storage import Reference
from oitbench.path_traced.references.worker import Job, far_end
from oitbench.places import PluginFiles, own_folder
from oitbench.results.schema import Record
from oitbench.results.store import CELLS, read_cells
from oitbench.truths import EXACT, FULL, MATCHED
from tests.executors.clusters import cluster
from tests.path_traced.agreement import needs_mitsuba

SCENE = '''"""Panes that end a process while they are built for the first time."""
import os, signal, time
from pathlib import Path

from oitbench import Parameter
from oitbench.modeling.mesh import quad, sphere
from oitbench.scene import Camera, DirectionalLight, Material, Medium, Object, Scene

parameters = {{"kills": Parameter("none", choices=("none", "worker", "parent")),
              "look": Parameter("panes", choices=("panes", "fog"))}}
MARK = Path({mark!r})


def _end(kills: str) -> None:
    try:
        (MARK / kills).touch(exist_ok=False)
    except FileExistsError:
        return
    os.kill(os.getpid() if kills == "worker" else os.getppid(), signal.SIGKILL)
    time.sleep(60)


def build(*, name: str, kills: str, look: str) -> Scene:
    if kills != "none":
        _end(kills)
    panes = tuple(
        Object(f"{{z}}", quad((0, 0, z), (1, 0, 0), (0, 1, 0)), Material(0.5, emission=(z, 0, 1)))
        for z in (0.25, 0.5, 0.75)
    )
    if look == "panes":
        return Scene(name, Camera((0.0, 0.0, 4.0)), panes, background=(0.1, 0.2, 0.3))
    fog = Medium(1.0, (-1.0, -1.0, -1.0), (1.0, 1.0, 1.0))
    sun = DirectionalLight((0.0, -1.0, 0.0), (1.0, 1.0, 1.0))
    ball = Object("ball", sphere((0.0, 0.0, 0.0), 0.5, 8, 4), Material(0.5))
    return Scene(name, Camera((0.0, 0.0, 4.0)), (ball,), lights=(sun,), medium=fog)
'''
METHODS = ["alpha_blend", "a_buffer"]


@pytest.fixture(scope="module")
def mine(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A collection with the scene `mortal`."""
    folder = tmp_path_factory.mktemp("mine")
    (folder / "scenes").mkdir()
    (folder / "marks").mkdir()
    (folder / "scenes" / "mortal.py").write_text(SCENE.format(mark=str(folder / "marks")))
    return folder


def run(
    mine: Path, out: Path, scenes: list[str], preset: str = "guard", **more: Any
) -> list[Record]:
    """Run cells; return their records."""
    given = {"size": (16, 16), "ssaa": 1, "collections": [mine], **more}
    summary = run_matrix(plan_matrix(scenes, METHODS, preset, out=out, **given))
    assert set(summary.statuses) == {"ok"}, summary.troubled
    records = list(read_cells(out / CELLS).values())
    for record in records:
        assert record.outcome is not None
        for image in record.outcome.images.values():
            stored.verify(out, image)
    return records


def content(records: list[Record]) -> dict[tuple[str, str], Any]:
    """Return metrics, counts and digests by scene, without what it kills, and method."""
    return {
        (record.scene.partition("[")[0], record.method): (record.fingerprints, record.outcome)
        for record in records
    }


@pytest.fixture(scope="module")
def expected(mine: Path, tmp_path_factory: pytest.TempPathFactory) -> dict[tuple[str, str], Any]:
    """The content of cells that this process has rendered."""
    return content(run(mine, tmp_path_factory.mktemp("own"), ["mortal", "layer_stack"], workers=0))


def test_three_executors_give_equal_records(
    mine: Path, tmp_path: Path, expected: dict[tuple[str, str], Any], address: str
) -> None:
    scenes = ["mortal", "layer_stack"]
    assert len(expected) == 4
    assert content(run(mine, tmp_path / "local", scenes, workers=2)) == expected
    assert content(run(mine, tmp_path / "dask", scenes, dask=address)) == expected


@pytest.mark.parametrize("kills", ["worker", "parent"])
def test_a_worker_that_is_killed_costs_only_time(
    mine: Path, tmp_path: Path, expected: dict[tuple[str, str], Any], address: str, kills: str
) -> None:
    more: dict[str, Any] = {"workers": 1} if kills == "worker" else {"dask": address}
    scenes = ["layer_stack", f"mortal[kills={kills}]"]
    assert content(run(mine, tmp_path, scenes, **more)) == expected
    assert (mine / "marks" / kills).exists()


def test_cells_are_timed_by_one_worker_of_the_cluster(
    mine: Path, tmp_path: Path, address: str
) -> None:
    records = run(mine, tmp_path, ["mortal", "layer_stack"], "quick", truths=(EXACT,), dask=address)
    assert all(record.time is not None for record in records)


def test_workers_with_another_renderer_are_left_out(mine: Path, tmp_path: Path) -> None:
    lines: list[str] = []
    given: dict[str, Any] = {"size": (16, 16), "ssaa": 1, "collections": [mine]}
    # llvmpipe names the width of its vectors.
    with cluster({}, {"LP_NATIVE_VECTOR_WIDTH": "128"}) as address:

        def renderers(out: str) -> set[str]:
            matrix = plan_matrix(
                ["mortal", "layer_stack"],
                METHODS,
                "guard",
                out=tmp_path / out,
                dask=address,
                **given,
            )
            run_matrix(matrix, on_line=lines.append)
            records = read_cells(tmp_path / out / CELLS).values()
            return {record.gl.renderer for record in records if record.gl is not None}

        first = renderers("one")
        if not any("llvmpipe" in name for name in first):
            pytest.skip("the renderer is not llvmpipe")
        assert len(first) == 1
        (line,) = lines
        assert line.startswith("left out: tcp://")
        assert "it renders with 'llvmpipe" in line
        # A folder keeps its renderer, although another one may come first.
        assert renderers("one") == first


def references(mine: Path, tmp_path: Path, place: Place, kills: str) -> dict[str, Reference]:
    """Render the references of the foggy scene, and return what is stored."""
    scratch, folder = tmp_path / "scratch", tmp_path / "reference"
    scratch.mkdir(parents=True)
    scene = f"mortal[kills={kills},look=fog]"
    orders = [making.Order(Job(scene, (6, 4), 1, truth), folder) for truth in (MATCHED, FULL)]
    seen: dict[str, list[int]] = {}

    def note(job: Job, done: int, count: int) -> None:
        seen.setdefault(job.truth, []).append(done)
        assert count == 8

    with place.open(far_end(PluginFiles([own_folder(), mine]), scratch)) as executor:
        for _, made in making.render(executor, orders, 9, 1, None, scratch, note):
            assert isinstance(made, Reference), made
    assert seen == {MATCHED: [*range(9)], FULL: [*range(9)]}
    assert not list(scratch.iterdir())
    found = {
        key.rpartition(".")[2]: storage.read(folder, key) for key in storage.read_manifest(folder)
    }
    return {truth: reference for truth, reference in found.items() if reference is not None}


@needs_mitsuba
def test_references_are_equal_whoever_renders_their_pieces(
    mine: Path, tmp_path: Path, address: str
) -> None:
    for mark in (mine / "marks").iterdir():
        mark.unlink()
    expected = references(mine, tmp_path / "own", Place(workers=0), "none")
    assert expected.keys() == {MATCHED, FULL}
    for name, place, kills in (
        ("local", Place(workers=2), "worker"),
        ("dask", Place(dask=address), "parent"),
    ):
        found = references(mine, tmp_path / name, place, kills)
        assert (mine / "marks" / kills).exists()
        for truth, reference in expected.items():
            assert found[truth].noise_floor == reference.noise_floor
            parts = zip(found[truth].parts, reference.parts, strict=True)
            assert all((one == other).all() for one, other in parts)

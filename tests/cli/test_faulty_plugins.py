"""Files of plugins that exit, crash, hang or print cost their own cells, in every command."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from oitbench.path_traced.references import storage
from oitbench.results.store import CELLS, read_cells
from oitbench.stability import files
from tests.cli.helpers import SMALL, Answer, spawn
from tests.path_traced.agreement import needs_mitsuba

FAULTS = {
    "exits": "import os; os._exit(7)",
    "crashes": "import ctypes; ctypes.string_at(0)",
    "hangs": "import time; time.sleep(3600)",
    "raises": "raise ValueError('unwell')",
}
REASONS = {
    "exits": "ended with code 7",
    "crashes": "signal 11 (SIGSEGV)",
    "hangs": "took longer than 8 s",
    "raises": "ValueError: unwell",
}
METHOD = '''"""A method."""
import oitbench as oit

{loading}


class Mine(oit.Method):
    expresses = oit.Effect.COVERAGE

    def plan(self, request: oit.Request) -> oit.Plan:
        {planning}
        gather = oit.Gather("gather.glsl", writes={{"color": oit.ADD}})
        return oit.Plan({{}}, (gather,))
'''
GATHER = "void gather(Fragment fragment) {{\n    {0}\n    color = premultiplied(fragment);\n}}\n"
# llvmpipe leaves its loops after 65,535 steps together, so each step takes long.
ENDLESS = f"""float total = fragment.z;
    for (int step = 0; step < 2000000000; step++) {{
        {"total = sin(total) + float(step);" * 1000}
    }}
    if (total == 0.5) discard;"""
SCENE = '''"""A scene."""
from oitbench.modeling.mesh import quad
from oitbench.scene import Camera, Material, Object, Scene

{loading}
parameters = {{}}


def build(*, name: str) -> Scene:
    {building}
    print("a line that is no message")
    camera = Camera((0, 0, 0), (0, 0, -1))
    pane = Object("pane", quad((0, 0, -2), (1, 0, 0), (0, 1, 0)), Material(coverage=0.5))
    return Scene(name, camera, (pane,))
'''


def write_method(folder: Path, loading: str = "", planning: str = "pass", shader: str = "") -> None:
    folder.mkdir(parents=True)
    (folder / "method.py").write_text(METHOD.format(loading=loading, planning=planning))
    (folder / "gather.glsl").write_text(GATHER.format(shader))


@pytest.fixture(scope="module")
def faulty(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A collection whose files fail when they are loaded, planned and built."""
    folder = tmp_path_factory.mktemp("faulty")
    (folder / "scenes").mkdir()
    (folder / "reports").mkdir()
    for name, text in FAULTS.items():
        write_method(folder / "methods" / f"m_{name}", loading=text)
        write_method(folder / "methods" / f"plan_{name}", planning=text)
        for kind, loading, building in (("s", text, "pass"), ("build", "", text)):
            path = folder / "scenes" / f"{kind}_{name}.py"
            path.write_text(SCENE.format(loading=loading, building=building))
        (folder / "reports" / f"r_{name}.py").write_text(f"title = ''\nbuild = None\n{text}\n")
    write_method(folder / "methods" / "endless", shader=ENDLESS)
    write_method(folder / "methods" / "good", 'print("hello")')
    # Touching so much memory can take seconds, so it must not race with a short time limit.
    huge = "import numpy; kept = [numpy.ones(2**27) for _ in range(24)]  # 24 GiB"
    (folder / "scenes" / "huge.py").write_text(SCENE.format(loading="", building=huge))
    write_method(folder / "methods" / "plan_huge", planning=huge)
    (folder / "scenes" / "fine.py").write_text(SCENE.format(loading="", building="pass"))
    return folder


@pytest.fixture(scope="module")
def run(faulty: Path, tmp_path_factory: pytest.TempPathFactory) -> tuple[Answer, Path]:
    """A run with each fault, and good cells before, between and after."""
    out = tmp_path_factory.mktemp("out")
    scenes = [f"{kind}_{name}" for name in FAULTS for kind in ("s", "build")]
    methods = [f"{kind}_{name}" for name in FAULTS for kind in ("m", "plan")]
    arguments = [word for scene in [*scenes, "fine"] for word in ("--scene", scene)]
    arguments += [word for m in [*methods, "endless", "good"] for word in ("--method", m)]
    place = ("--collection", str(faulty), "--out", str(out))
    limits = ("--timeout", "8", "--workers", "2", "--preset", "guard")
    return spawn("run", *arguments, *SMALL, *limits, *place), out


def test_each_fault_costs_its_cells_and_has_its_reason(run: tuple[Answer, Path]) -> None:
    answer, out = run
    cells = {(c.scene, c.method): c for c in read_cells(out / CELLS).values()}
    assert len(cells) == 9 * 10, answer.err
    for name, reason in REASONS.items():
        for kind in ("s", "build"):
            for method in ("good", "plan_exits"):
                assert reason in cells[f"{kind}_{name}", method].reason
        for kind in ("m", "plan"):
            assert reason in cells["fine", f"{kind}_{name}"].reason
    assert cells["fine", "endless"].status == "timeout"
    assert cells["fine", "good"].status == "ok"
    assert [key for key, cell in cells.items() if cell.status == "ok"] == [("fine", "good")]
    assert "Traceback" not in answer.out
    assert "a line that is no message" not in answer.out


def test_a_scene_that_needs_too_much_memory_costs_its_cells(faulty: Path, tmp_path: Path) -> None:
    arguments = (
        "--scene",
        "huge",
        "--scene",
        "fine",
        "--method",
        "good",
        "--method",
        "sorted_over",
    )
    place = ("--collection", str(faulty), "--out", str(tmp_path), "--preset", "guard")
    answer = spawn("run", *arguments, *SMALL, *place, "--memory", "1")
    cells = {(c.scene, c.method): c for c in read_cells(tmp_path / CELLS).values()}
    assert len(cells) == 4, answer.err
    for method in ("good", "sorted_over"):
        reason = "needs more than 1 GiB of memory while building the scene"
        assert (cells["huge", method].status, cells["huge", method].reason) == ("failed", reason)
        assert cells["fine", method].status == "ok"


def test_list_and_doctor_name_the_faults(faulty: Path, tmp_path: Path) -> None:
    (tmp_path / "methods").mkdir()
    for name in ("m_exits", "m_crashes", "m_raises", "good"):
        (tmp_path / "methods" / name).symlink_to(faulty / "methods" / name)
    listed = spawn("list", "methods", "--collection", str(tmp_path))
    checked = spawn("doctor", "--collection", str(tmp_path))
    assert (listed.code, checked.code) == (0, 1)
    for name in ("exits", "crashes", "raises"):
        assert REASONS[name] in listed.out
        assert REASONS[name] in checked.out
    assert "good" in listed.out
    assert "hello" not in listed.out + checked.out


@pytest.mark.parametrize(
    ("scene", "method", "name"),
    [
        ("build_exits", "good", "exits"),
        ("s_crashes", "good", "crashes"),
        ("fine", "plan_raises", "raises"),
        ("fine", "plan_hangs", "hangs"),
        ("fine", "m_hangs", "hangs"),
    ],
)
def test_a_picture_that_cannot_be_drawn_is_one_line(
    faulty: Path, tmp_path: Path, scene: str, method: str, name: str
) -> None:
    out = ("-o", str(tmp_path / "x.png"), "--collection", str(faulty), "--timeout", "8")
    answer = spawn("render", scene, method, *SMALL, *out)
    assert (answer.code, answer.out) == (2, "")
    assert REASONS[name] in answer.err.splitlines()[-1]
    assert not (tmp_path / "x.png").exists()


def test_stability_loses_faulty_methods_only(faulty: Path, tmp_path: Path) -> None:
    names = ["m_crashes", *(f"plan_{name}" for name in FAULTS), "good"]
    arguments = [word for name in names for word in ("--method", name)]
    limits = ("--timeout", "8", "--collection", str(faulty))
    answer = spawn("stability", *arguments, *limits, "--out", str(tmp_path))
    assert answer.code == 1, answer.err
    lines = [line for line in answer.out.splitlines() if ": no image for " in line]
    reasons = {line.partition(":")[0]: line for line in lines}
    assert len(lines) == len(reasons) == 5
    assert REASONS["crashes"] in reasons["m_crashes"]
    for name, reason in REASONS.items():
        assert reason in reasons[f"plan_{name}"]
    results = files.read(tmp_path / files.JSON)
    good = [result for result in results if result.name == "good"]
    assert len(good) == len(results) / len(names)
    assert any(result.status == "holds" for result in good)
    assert not any(result.reason for result in good if result.applies)


def test_stability_names_a_method_that_needs_too_much_memory(faulty: Path, tmp_path: Path) -> None:
    place = ("--collection", str(faulty), "--out", str(tmp_path))
    answer = spawn("stability", "--method", "plan_huge", "--memory", "1", *place)
    assert answer.code == 1, answer.err
    assert "plan_huge: no image for" in answer.out
    assert "needs more than 1 GiB" in answer.out


@needs_mitsuba
def test_reference_loses_a_scene_that_needs_too_much_memory(faulty: Path, tmp_path: Path) -> None:
    limits = ("--memory", "2", "--size", "8x8", "--truth", "full")
    place = ("--collection", str(faulty), "-o", str(tmp_path))
    answer = spawn("reference", "huge", "fine", *limits, *place)
    assert answer.code == 1, answer.err
    assert "huge: needs more than 2 GiB" in answer.err
    assert storage.read_manifest(tmp_path).keys() == {"fine@8x8.full"}


@needs_mitsuba
def test_reference_loses_faulty_scenes_only(faulty: Path, tmp_path: Path) -> None:
    scenes = ("s_raises", *(f"build_{name}" for name in FAULTS), "fine")
    limits = ("--timeout", "8", "--size", "8x8", "--truth", "full")
    place = ("--collection", str(faulty), "-o", str(tmp_path))
    answer = spawn("reference", *scenes, *limits, *place)
    assert answer.code == 1, answer.err
    lines = [line for line in answer.err.splitlines() if line.startswith("failed ")]
    assert len(lines) == len(scenes) - 1
    for name, reason in REASONS.items():
        (line,) = [line for line in lines if f" build_{name}: " in line]
        assert reason in line
    assert storage.read_manifest(tmp_path).keys() == {"fine@8x8.full"}
    assert answer.out.startswith("rendered ")
    assert spawn("reference", "fine", *limits, *place).code == 0


@pytest.mark.parametrize(
    ("arguments", "name"),
    [
        (("stability", "--method", "m_exits"), "exits"),
        (("visibility", "fine", "--method", "m_exits"), "exits"),
        (("visibility", "s_exits", "--method", "good"), "exits"),
        (("visibility", "fine", "--method", "good", "--method", "plan_crashes"), "crashes"),
        (("visibility", "build_hangs", "--method", "good"), "hangs"),
        (("reference", "s_exits", "--size", "8x8"), "exits"),
        (("reference", "build_exits", "--size", "8x8"), "exits"),
    ],
)
def test_a_fault_that_leaves_nothing_to_do_is_one_line(
    faulty: Path, tmp_path: Path, arguments: tuple[str, ...], name: str
) -> None:
    if arguments[0] == "visibility":
        arguments = (*arguments, "--pixel", "4,4", "--size", "8x8")
    option = "-o" if arguments[0] == "reference" else "--out"
    place = (option, str(tmp_path / "out"), "--collection", str(faulty))
    answer = spawn(*arguments, *place, "--timeout", "8")
    assert (answer.code, answer.out) == (2, "")
    assert REASONS[name] in answer.err.splitlines()[-1]


def test_the_page_lacks_only_faulty_sections(
    faulty: Path, run: tuple[Answer, Path], tmp_path: Path
) -> None:
    # The page asks each method and scene of the results for its words, and would wait for these.
    lines = (run[1] / CELLS).read_text(encoding="utf-8").splitlines(keepends=True)
    kept = [line for line in lines if "_hangs" not in line]
    results = tmp_path / "results"
    shutil.copytree(run[1], results)
    (results / CELLS).write_text("".join(kept), encoding="utf-8")
    place = ("-o", str(tmp_path / "page"), "--collection", str(faulty), "--timeout", "20")
    answer = spawn("report", str(results), *place)
    assert answer.code == 1
    assert answer.out.strip() == str(tmp_path / "page" / "index.html")
    for name, reason in REASONS.items():
        (line,) = [line for line in answer.err.splitlines() if f"r_{name}.py" in line]
        assert reason.replace("8 s", "20 s") in line
    page = (tmp_path / "page" / "index.html").read_text(encoding="utf-8")
    assert page.count("This section is missing.") == len(FAULTS)
    assert (tmp_path / "page" / "table.csv").is_file()

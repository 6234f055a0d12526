"""No OpenGL object is left when a cell fails, at any point."""

from __future__ import annotations

import ctypes
import gc
import weakref
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from typing import Any

import pytest

from oitbench.errors import OitbenchError
from oitbench.gl.device import Device
from oitbench.gl.frame import Frame
from oitbench.gl.geometry import Geometry
from oitbench.gl.uploaded_scene import UploadedScene
from oitbench.matrix.bench import Bench
from oitbench.matrix.cell import Cell
from oitbench.plugins import Collection
from oitbench.shading import read_shading

KINDS = ("Buffer", "Framebuffer", "Program", "Query", "Sampler", "Shader", "Texture", "VertexArray")
NAMES = 1024
CREATORS = (
    "buffer", "depth_texture", "framebuffer", "texture", "texture3d", "texture_array",
    "vertex_array",
)  # fmt: skip
CELLS = 50
SMALL = "shadow_map=64"
"""Shading of the cells, for speed."""
# Shadows, occlusion, a medium, lists, and targets of two resolutions.
VICTIMS = (
    ("smoke_and_glass[detail=0.02]", "phenomenological[subsample=4]"),
    ("foliage[detail=0.05]", "a_buffer"),
    ("light_shafts[detail=0.1]", "depth_peeling[layers=2]"),
)


class OutOfMemoryError(OitbenchError):
    """The injected error."""


def live_objects() -> dict[str, int]:
    """Return the number of live objects of each kind in the current context."""
    library = ctypes.CDLL("libGL.so.1")
    found = {}
    for kind in KINDS:
        exists = getattr(library, f"glIs{kind}")
        exists.restype, exists.argtypes = ctypes.c_ubyte, (ctypes.c_uint,)
        found[kind] = sum(exists(name) for name in range(1, NAMES))
    return found


def difference(after: dict[str, int], before: dict[str, int]) -> dict[str, int]:
    """Return the number of additional objects, by kind; kinds with none are left out."""
    return {kind: after[kind] - before[kind] for kind in KINDS if after[kind] > before[kind]}


@contextmanager
def failing(device: Device, call: int) -> Iterator[list[str]]:
    """Raise at the creation of object number `call`; yield the names of the creators called."""
    calls: list[str] = []
    originals: dict[str, Callable[..., Any]] = {n: getattr(device.context, n) for n in CREATORS}

    def counted(name: str) -> Callable[..., Any]:
        def create(*arguments: Any, **options: Any) -> Any:
            calls.append(name)
            if len(calls) - 1 == call:
                raise OutOfMemoryError(f"no memory for {name} {call}")
            return originals[name](*arguments, **options)

        return create

    try:
        for name in CREATORS:
            setattr(device.context, name, counted(name))
        yield calls
    finally:
        for name in CREATORS:
            delattr(device.context, name)


@pytest.fixture
def bench(plugins: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Bench]:
    """A bench that builds each scene once, for speed."""
    collection = Collection.load([plugins])
    monkeypatch.setattr(collection, "build_scene", cache(collection.build_scene))
    with Bench(collection, tmp_path / "out") as bench:
        yield bench


def attempt(bench: Bench, cell: Cell, call: int) -> tuple[str, int]:
    """Run a cell; return its status and the number of objects that it tried to create."""
    with failing(bench.device, call) as calls:
        record = bench.run(cell)
    bench.leave_scene()
    return record.status, len(calls)


def test_no_object_is_left_when_a_creation_fails(bench: Bench) -> None:
    cells = [
        Cell(scene, method, (16, 16), 1, permutations=1, truths=("exact",), shading=SMALL)
        for scene, method in VICTIMS
    ]
    whole = [attempt(bench, cell, -1) for cell in cells]
    assert [status for status, _ in whole] == ["ok"] * len(cells)
    before = live_objects()
    for number in range(CELLS):
        cell, (_, created) = cells[number % len(cells)], whole[number % len(cells)]
        call = number // len(cells) * created // (CELLS // len(cells) + 1)
        status, _ = attempt(bench, cell, call)
        assert status == "failed", f"{cell.method} survived without object {call}"
        lost = difference(live_objects(), before)
        assert not lost, f"{cell.method} lost {lost} when object {call} failed"


def test_no_object_is_left_of_methods_and_scenes_that_fail(bench: Bench) -> None:
    cells = [
        Cell("calm", method, (8, 8), 1, truths=("exact",), shading=SMALL)
        for method in ("broken", "demanding", "unstable")
    ]
    cells += [
        Cell(scene, "alpha_blend", (8, 8), 1, truths=("exact",), shading=SMALL)
        for scene in ("raiser", "poisoned")
    ]
    expected = ["failed", "failed", "unstable", "failed", "failed"]
    assert [bench.run(cell).status for cell in cells] == expected
    bench.leave_scene()
    before = live_objects()
    for _ in range(CELLS // len(cells)):
        for cell in cells:
            bench.run(cell)
            bench.leave_scene()
            # moderngl keeps the program of a failed compilation.
            lost = difference(live_objects(), before).keys() - {"Program", "Shader"}
            assert not lost, cell


@pytest.mark.parametrize("victim", VICTIMS)
def test_a_released_scene_needs_no_collector_of_cycles(victim: tuple[str, str]) -> None:
    # A cycle would keep the arrays of large scenes until the collector happens to run.
    collection = Collection.load()
    label, method = victim
    (chosen,) = collection.expand_methods([method])
    scene = collection.build_scene(label)
    settings = read_shading(SMALL)
    with Device() as device:

        def draw() -> weakref.ref[Geometry]:
            effects = scene.effects & chosen.shows
            with (
                UploadedScene(device, scene, settings, 16) as uploaded,
                Frame(uploaded, chosen, (16, 16), effects) as frame,
            ):
                frame.render()
                return weakref.ref(uploaded.geometry)

        gc.disable()
        try:
            assert draw()() is None
        finally:
            gc.enable()

"""The declaration of a method as plain data, through the worker of a catalog."""

from __future__ import annotations

from pathlib import Path

import pytest

from oitbench.catalog.catalog import Catalog
from oitbench.catalog.messages import Portrait
from oitbench.catalog.outline import FRAGMENT, PIXEL, Access, Storage
from tests.catalog.test_catalog import write_method

METHOD = '''"""Lists: some.

Known failures: many.
"""
import oitbench as oit
from oitbench.method.passes import Loop
from oitbench.method.storage import Items


class Lists(oit.Method):
    family = "lists"
    expresses = oit.Effect.COVERAGE
    count = oit.Parameter(2, choices=(2, 4), help="of things")
    promises = oit.promise("order_independent")

    def plan(self, request):
        targets = {"sum": oit.Target("rgba16f"), "near": oit.Target("depth32f")}
        buffers = {"nodes": oit.Buffer({"depth": "float", "color": "vec4"}, Items.FRAGMENTS)}
        fill = oit.Gather("fill.glsl", buffers=("nodes",), depth="near", order=oit.Order.OBJECTS)
        sums = {"sum": oit.ADD}
        some = oit.Objects.PARTICLES
        add = oit.Gather("add.glsl", writes=sums, objects=some, depth="near", depth_writes=False)
        over = {"color": oit.OVER}
        end = oit.Resolve("end.glsl", reads=("sum",), writes=over, buffers=("nodes",))
        return oit.Plan(targets, (fill, Loop((add,), times=3), end), buffers)
'''


@pytest.fixture(scope="module")
def portrait(tmp_path_factory: pytest.TempPathFactory) -> Portrait:
    folder = tmp_path_factory.mktemp("collection")
    write_method(folder / "methods" / "lists", METHOD)
    write_method(folder / "methods" / "broken", "this is no Python")
    with Catalog([folder]) as catalog:
        found = catalog.portrait("lists[count=4]")
        assert "SyntaxError" in str(catalog.portrait("broken"))
        assert str(catalog.portrait("gone[x=1]")).startswith("no collection has a method 'gone'")
    assert isinstance(found, Portrait), found
    return found


def test_a_portrait_says_what_the_file_says(portrait: Portrait) -> None:
    assert portrait.label == "lists[count=4]"
    assert portrait.doc.splitlines()[-1] == "Known failures: many."
    assert portrait.family == "lists"
    assert portrait.parameters == {"count": ("4", "2, 4", "of things")}
    assert portrait.promises == ["opaque_unchanged", "order_independent"]
    assert portrait.expresses == ["coverage"]
    assert portrait.demands.capability_class == "atomics"


def test_storage_has_formats_and_bits(portrait: Portrait) -> None:
    assert portrait.outline.storages == [
        Storage("sum", "rgba16f", 64.0),
        Storage("near", "depth32f", 32.0),
        Storage("nodes", "2 fields", 160, FRAGMENT),
        Storage("color", "rgba16f", 64, PIXEL, shared=True),
    ]


def test_passes_have_accesses_and_remarks(portrait: Portrait) -> None:
    fill, add, end = portrait.outline.passes
    assert (fill.name, fill.draws, fill.remark) == (
        "fill",
        "all fragments",
        "far to near by object",
    )
    assert fill.accesses == [
        Access("near", True, True, "depth test"), Access("nodes", True, True, "append")
    ]  # fmt: skip
    assert (add.draws, add.remark) == ("fragments of particles", "repeated up to 3 times")
    assert add.accesses == [
        Access("near", True, False, "depth test"), Access("sum", True, True, "add")
    ]  # fmt: skip
    assert end.draws == "all pixels"
    assert end.accesses == [
        Access("sum", True, False, "read"), Access("color", True, True, "over"),
        Access("nodes", True, True, "access"),
    ]  # fmt: skip


def test_the_fingerprint_is_that_of_records(portrait: Portrait, tmp_path: Path) -> None:
    write_method(tmp_path / "methods" / "lists", METHOD.replace("times=3", "times=4"))
    with Catalog([tmp_path]) as catalog:
        other = catalog.portrait("lists[count=4]")
    assert isinstance(other, Portrait)
    assert other.fingerprint != portrait.fingerprint

"""Diagrams of declarations, from the method's file or from the accounts of a cell."""

from __future__ import annotations

import msgspec

from oitbench.catalog.outline import Access, Outline, PassOutline, Storage
from oitbench.report.method_pages.diagram import diagram, of_outcome
from oitbench.results.schema import Memory, MemoryTerm, PassRuns, Traffic, TrafficTerm
from tests.made_up import outcome_of


def outline(*storages: Storage, words: tuple[str, ...] = ()) -> Outline:
    accesses = [
        Access(item.name, True, False, word)
        for item, word in zip(storages, words or ("read",) * len(storages), strict=True)
    ]
    return Outline(list(storages), [PassOutline("one", "all pixels", "", accesses)])


def test_numbered_targets_that_are_alike_are_one_column() -> None:
    three = [Storage(f"slice{n}", "r16f", 16) for n in range(3)]
    made = diagram(outline(*three, Storage("sum", "rgba16f", 64)))
    assert [(c.title, c.format, c.size) for c in made.columns] == [
        ("slice0 … 2", "3 × r16f", "48 bit/px"),
        ("sum", "rgba16f", "64 bit/px"),
    ]
    assert [arrow.x for arrow in made.rows[0].arrows] == [column.x for column in made.columns]


def test_targets_that_differ_stay_apart() -> None:
    formats = diagram(outline(Storage("a0", "r8", 8), Storage("a1", "r16f", 16)))
    assert [column.title for column in formats.columns] == ["a0", "a1"]
    two = (Storage("a0", "r8", 8), Storage("a1", "r8", 8))
    uses = diagram(outline(*two, words=("read", "add")))
    assert [column.title for column in uses.columns] == ["a0", "a1"]


def test_nothing_overlaps() -> None:
    storages = [Storage(name, "rgba32f", 128) for name in ("a" * 40, "b", "c" * 25)]
    passes = [PassOutline("long name " * 2, "all fragments", "word " * 20, []) for _ in range(3)]
    made = diagram(Outline(storages, passes))
    assert made.columns[0].x - 40 * 3.5 > made.box
    assert made.columns[2].x - made.columns[1].x > 25 * 3.5
    for row, following in zip(made.rows, made.rows[1:], strict=False):
        assert row.y + row.height < following.y
        assert row.height >= 15 * (1 + len(row.remarks))
    assert made.height > made.rows[-1].y + made.rows[-1].height


def test_the_words_say_the_same() -> None:
    made = diagram(outline(Storage("sum", "r8", 8)))
    assert made.words == "one: sum (read)."


def test_accounts_give_a_diagram_too() -> None:
    outcome = msgspec.structs.replace(
        outcome_of({}, {}),
        passes=[PassRuns("gather", 1), PassRuns("resolve", 1)],
        memory=Memory(96, 64.0, [MemoryTerm("sum", 96)]),
        traffic=Traffic(
            0,
            [
                TrafficTerm("clear", "sum", "clear", 12, 8, 96),
                TrafficTerm("gather", "sum", "blend", 5, 8, 40),
                TrafficTerm("gather", "sum", "write", 5, 8, 40),
                TrafficTerm("gather", "depth", "clear", 12, 4, 48),
                TrafficTerm("resolve", "sum.x", "read", 12, 8, 96),
                TrafficTerm("resolve", "color", "write", 12, 16, 192),
            ],
        ),
    )
    found = of_outcome(outcome, (4, 3))
    assert found.storages == [
        Storage("sum", "", 64.0), Storage("depth", "", 32, shared=True),
        Storage("color", "", 128, shared=True),
    ]  # fmt: skip
    gather, resolve = found.passes
    assert gather.accesses == [
        Access("sum", True, True, "blend"), Access("depth", False, True, "write")
    ]  # fmt: skip
    assert resolve.accesses == [
        Access("sum", True, False, "read"), Access("color", False, True, "write")
    ]  # fmt: skip
    assert len(diagram(found).rows) == 2

"""A declaration as a diagram: passes are rows, storage is columns, and arrows are accesses.

The template `diagram.svg` draws it. All lengths are in CSS pixels.
"""

from __future__ import annotations

import textwrap
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import msgspec

from oitbench.catalog.outline import FRAGMENT, Access, Outline, PassOutline, Storage
from oitbench.method.steps import indexed_families
from oitbench.results.schema import Outcome

_BOLD, _LETTER = 8.8, 7.4
"""Widths of letters of names and of other texts, in a wide typeface."""
_BOX_LETTERS = 30
_COLUMN, _PADDING = 104.0, 18.0
_HEADER, _ROW, _LINE, _GAP = 66.0, 48.0, 15.0, 12.0
_WORDS = {(True, True): "read and write", (True, False): "read", (False, True): "write"}


@dataclass(frozen=True)
class Column:
    """A storage, or several that are alike; `x` is its middle."""

    title: str
    format: str
    size: str
    shared: bool
    x: float


@dataclass(frozen=True)
class Arrow:
    """An access, at the column with the middle `x`."""

    x: float
    reads: bool
    writes: bool
    word: str


@dataclass(frozen=True)
class Row:
    """A pass with its box; `remarks` are lines below its name, and `y` is its top."""

    title: str
    remarks: tuple[str, ...]
    y: float
    height: float
    arrows: tuple[Arrow, ...]

    @property
    def middle(self) -> float:
        """The y of its arrows."""
        return self.y + self.height / 2


@dataclass(frozen=True)
class Diagram:
    """All that the template draws, and the sentences that say the same."""

    width: float
    height: float
    box: float
    columns: tuple[Column, ...]
    rows: tuple[Row, ...]
    words: str


def diagram(outline: Outline) -> Diagram:
    """Return the diagram of an outline; storage that is numbered and used alike is one column."""
    outline = _joined(outline)
    texts = [(item.name, *_lines(item.draws), *_lines(item.remark)) for item in outline.passes]
    box = _PADDING + max((_width(*lines) for lines in texts), default=0.0)
    places: dict[str, Column] = {}
    left = box + _PADDING
    for storage in outline.storages:
        title, size = _title(storage), _size(storage)
        width = max(_COLUMN, _width(title, storage.format, size) + _PADDING)
        middle = left + width / 2
        places[storage.name] = Column(title, storage.format, size, storage.shared, middle)
        left += width
    rows: list[Row] = []
    top = _HEADER
    for item, (name, *remarks) in zip(outline.passes, texts, strict=True):
        height = max(_ROW, _LINE * (2 + len(remarks)))
        arrows = tuple(
            Arrow(places[access.storage].x, access.reads, access.writes, access.word)
            for access in item.accesses
        )
        rows.append(Row(name, tuple(remarks), top, height, arrows))
        top += height + _GAP
    return Diagram(left, top, box, tuple(places.values()), tuple(rows), _sentences(outline))


def _width(name: str, *lines: str) -> float:
    return max(_BOLD * len(name), _LETTER * max(map(len, lines), default=0))


def of_outcome(outcome: Outcome, size: tuple[int, int]) -> Outline:
    """Return the outline of the accounts of a cell, which name no formats.

    Parameters
    ----------
    outcome : Outcome
    size : (int, int)
        Pixels of the frame.
    """
    pixels = size[0] * size[1]
    storages = {
        term.resource: Storage(term.resource, "", 8 * term.bytes / pixels)
        for term in outcome.memory.terms
    }
    found: dict[str, dict[str, set[str]]] = {item.name: {} for item in outcome.passes}
    for term in outcome.traffic.terms:
        resource = term.resource.partition(".")[0]
        if term.pass_ in found:
            found[term.pass_].setdefault(resource, set()).add(term.kind)
            shared = Storage(resource, "", 8 * term.bytes_per_item, shared=True)
            storages.setdefault(resource, shared)
    passes = [
        PassOutline(name, "", "", [_access(resource, kinds) for resource, kinds in used.items()])
        for name, used in found.items()
    ]
    touched = {access.storage for item in passes for access in item.accesses}
    return Outline([item for item in storages.values() if item.name in touched], passes)


def _access(resource: str, kinds: set[str]) -> Access:
    reads = bool(kinds & {"read", "blend", "atomic"})
    writes = bool(kinds & {"write", "atomic", "clear"})
    return Access(resource, reads, writes, "blend" if "blend" in kinds else _WORDS[reads, writes])


def _joined(outline: Outline) -> Outline:
    """Return an outline in which numbered storage that is alike is one, named by the first."""
    known = {item.name: item for item in outline.storages}
    uses = {name: list(_uses(outline.passes, name)) for name in known}
    gone: set[str] = set()
    joined = dict(known)
    for base, count in indexed_families(known).items():
        first, *rest = (f"{base}{number}" for number in range(count))
        alike = all(
            msgspec.structs.replace(known[name], name=first) == known[first]
            and uses[name] == uses[first]
            for name in rest
        )
        if rest and alike:
            gone |= set(rest)
            one = known[first]
            form = f"{count} × {one.format}".rstrip(" ×")
            joined[first] = msgspec.structs.replace(one, bits=one.bits * count, format=form)
    passes = [
        msgspec.structs.replace(
            item, accesses=[access for access in item.accesses if access.storage not in gone]
        )
        for item in outline.passes
    ]
    return Outline([item for name, item in joined.items() if name not in gone], passes)


def _uses(passes: Sequence[PassOutline], name: str) -> Iterator[tuple[int, bool, bool, str]]:
    for number, item in enumerate(passes):
        for access in item.accesses:
            if access.storage == name:
                yield number, access.reads, access.writes, access.word


def _title(item: Storage) -> str:
    count = item.format.partition(" × ")[0]
    if not count.isdigit():
        return item.name
    return f"{item.name} … {int(count) - 1}"


def _size(item: Storage) -> str:
    return f"{_number(item.bits)} bit/{'fragment' if item.unit == FRAGMENT else 'px'}"


def _number(bits: float) -> str:
    return f"{bits:,.0f}" if bits >= 1 else f"{bits:.2g}"


def _lines(text: str) -> list[str]:
    return textwrap.wrap(text, _BOX_LETTERS)


def _sentences(outline: Outline) -> str:
    """Return the diagram in words, for readers who do not see it."""
    parts = []
    for item in outline.passes:
        used = ", ".join(f"{access.storage} ({access.word})" for access in item.accesses)
        parts.append(f"{item.name}: {used or 'nothing'}.")
    return " ".join(parts)

"""The rows of a PLY file's elements, as text or binary, with checked bounds."""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from typing import Protocol

import numpy as np
import numpy.typing as npt

from oitbench.errors import SceneError
from oitbench.importing.ply.header import Element
from oitbench.importing.shapes import Indices
from oitbench.scene import Floats

_ENDS = "it ends before its last element; the file is damaged"
Columns = dict[str, Floats]


class Body(Protocol):
    """Reads elements in their order."""

    def columns(self, element: Element) -> Columns:
        """Return the columns of an element without lists."""

    def lists(self, element: Element, names: tuple[str, ...]) -> list[Indices]:
        """Return the lists of one property, those of equal length as rows of one array.

        The property is the first one with one of the `names`; all others are skipped.
        """


class TextBody:
    """Numbers that are separated by blanks."""

    def __init__(self, content: bytes) -> None:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            try:
                self._numbers = np.fromstring(content.decode("ascii"), dtype=np.float64, sep=" ")
            except (DeprecationWarning, UnicodeDecodeError, ValueError) as error:
                raise SceneError("its text has something that is no number") from error
        self._start = 0

    def _take(self, count: int) -> Floats:
        end = self._start + count
        if end > len(self._numbers):
            raise SceneError(_ENDS)
        found = self._numbers[self._start : end]
        self._start = end
        return found

    def columns(self, element: Element) -> Columns:
        """See `Body`."""
        width = len(element.properties)
        table = self._take(element.rows * width).reshape(element.rows, width)
        return {item.name: table[:, k] for k, item in enumerate(element.properties)}

    def lists(self, element: Element, names: tuple[str, ...]) -> list[Indices]:
        """See `Body`."""
        wanted = _wanted(element, names)
        numbers, place = self._numbers, self._start
        starts, counts = [], []
        for _ in range(element.rows):
            for number, item in enumerate(element.properties):
                count = 1
                if item.count is not None:
                    if place >= len(numbers):
                        raise SceneError(_ENDS)
                    count = _count(float(numbers[place]))
                    place += 1
                if number == wanted:
                    starts.append(place)
                    counts.append(count)
                place += count
            if place > len(numbers):
                raise SceneError(_ENDS)
        self._start = place
        return [
            _indices(numbers[rows[:, None] + np.arange(count)])
            for count, rows in _groups(starts, counts)
        ]


class BinaryBody:
    """Numbers of fixed size."""

    def __init__(self, content: memoryview) -> None:
        self._content, self._start = content, 0

    def columns(self, element: Element) -> Columns:
        """See `Body`."""
        fields = [(str(k), item.type) for k, item in enumerate(element.properties)]
        table = self._table(np.dtype(fields), element.rows)
        return {
            item.name: table[str(k)].astype(np.float64) for k, item in enumerate(element.properties)
        }

    def _table(self, kind: np.dtype[np.void], rows: int) -> npt.NDArray[np.void]:
        if self._start + rows * kind.itemsize > len(self._content):
            raise SceneError(_ENDS)
        found = np.frombuffer(self._content, kind, rows, self._start)
        self._start += rows * kind.itemsize
        return found

    def lists(self, element: Element, names: tuple[str, ...]) -> list[Indices]:
        """See `Body`."""
        wanted = _wanted(element, names)
        equal = self._equal_lists(element, wanted)
        if equal is not None:
            return equal
        content, place = self._content, self._start
        starts, counts = [], []
        for _ in range(element.rows):
            for number, item in enumerate(element.properties):
                count = 1
                if item.count is not None:
                    end = place + item.count.itemsize
                    if end > len(content):
                        raise SceneError(_ENDS)
                    count = _count(float(np.frombuffer(content[place:end], item.count)[0]))
                    place = end
                if number == wanted:
                    starts.append(place)
                    counts.append(count)
                place += count * item.type.itemsize
            if place > len(content):
                raise SceneError(_ENDS)
        self._start = place
        if not starts:
            return []
        kind = element.properties[wanted].type
        data = np.frombuffer(content, np.uint8)
        return [
            _indices(data[rows[:, None] + np.arange(count * kind.itemsize)].view(kind))
            for count, rows in _groups(starts, counts)
        ]

    def _equal_lists(self, element: Element, wanted: int) -> list[Indices] | None:
        """Return the lists if they are all as long as the first; None if not."""
        if wanted < 0 or sum(item.count is not None for item in element.properties) != 1:
            return None
        item = element.properties[wanted]
        assert item.count is not None
        before = sum(other.type.itemsize for other in element.properties[:wanted])
        start = self._start + before
        if element.rows == 0 or start + item.count.itemsize > len(self._content):
            return None
        first = self._content[start : start + item.count.itemsize]
        count = _count(float(np.frombuffer(first, item.count)[0]))
        if count == 0 or count * item.type.itemsize > len(self._content):
            return None
        fields: list[tuple[str, object]] = []
        for number, other in enumerate(element.properties):
            if number == wanted:
                fields += [("count", item.count), ("list", (item.type, (count,)))]
            else:
                fields.append((str(number), other.type))
        kind = np.dtype(fields)
        if self._start + element.rows * kind.itemsize > len(self._content):
            return None
        table = np.frombuffer(self._content, kind, element.rows, self._start)
        if not (table["count"] == count).all():
            return None
        self._start += element.rows * kind.itemsize
        return [_indices(table["list"])]


def _wanted(element: Element, names: tuple[str, ...]) -> int:
    """Return the number of the first list with one of the names; −1 if there is none."""
    found = (
        k
        for k, item in enumerate(element.properties)
        if item.count is not None and item.name in names
    )
    return next(found, -1)


def _count(value: float) -> int:
    if not 0 <= value < 2**31:
        raise SceneError("a list has an impossible length; the file is damaged")
    return int(value)


def _groups(starts: list[int], counts: list[int]) -> Iterator[tuple[int, Indices]]:
    """Yield each length of a list, and where the lists of that length start."""
    places, lengths = np.array(starts, dtype=np.int64), np.array(counts, dtype=np.int64)
    for count in np.unique(lengths).tolist():
        yield count, places[lengths == count]


def _indices(values: npt.NDArray[np.generic]) -> Indices:
    """Return whole numbers; those that no index can be become −1."""
    if values.dtype.kind == "f":
        number = np.asarray(values, dtype=np.float64)
        return np.where((number >= 0) & (number < 2**53), number, -1).astype(np.int64)
    return values.astype(np.int64)

"""The header of a PLY file: which elements follow, with which properties."""

from __future__ import annotations

import re
from dataclasses import dataclass

import numpy as np

from oitbench.errors import SceneError
from oitbench.importing.limits import short

_LONGEST = 1 << 16
_MOST = 256
_TYPES = {
    "char": "i1", "int8": "i1", "uchar": "u1", "uint8": "u1", "short": "i2", "int16": "i2",
    "ushort": "u2", "uint16": "u2", "int": "i4", "int32": "i4", "uint": "u4", "uint32": "u4",
    "float": "f4", "float32": "f4", "double": "f8", "float64": "f8",
}  # fmt: skip
ORDERS = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}


@dataclass(frozen=True)
class Property:
    """A number, or a list of numbers if `count` is a type."""

    name: str
    type: np.dtype[np.generic]
    count: np.dtype[np.generic] | None = None


@dataclass(frozen=True)
class Element:
    """Rows of equal properties."""

    name: str
    rows: int
    properties: tuple[Property, ...]

    @property
    def has_lists(self) -> bool:
        """Whether a property is a list."""
        return any(item.count is not None for item in self.properties)


def read_header(content: bytes) -> tuple[str, list[Element], bytes, int]:
    """Return the order of bytes ("" for text), the elements, the comments, and the header's length.

    Raises
    ------
    SceneError
        The header is damaged.
    """
    found = re.search(rb"(?:^|\n)end_header[ \t]*(?:\r\n|\n|\r)", content[:_LONGEST])
    if not content.startswith(b"ply") or found is None:
        raise SceneError("it is no PLY file: its header is missing or damaged")
    head = content[: found.end()]
    order: str | None = None
    elements: list[Element] = []
    for line in head.decode("latin-1").splitlines()[1:]:
        words = line.split()
        if not words or words[0] in ("comment", "obj_info", "end_header"):
            continue
        try:
            if words[0] == "format":
                order = ORDERS[words[1]]
            elif words[0] == "element":
                rows = int(words[2])
                elements.append(Element(words[1], rows, ()))
            elif words[0] == "property":
                last = elements.pop()
                item = _property(words, order or "<")
                elements.append(Element(last.name, last.rows, (*last.properties, item)))
            else:
                raise KeyError(words[0])
        except (KeyError, IndexError, ValueError) as error:
            raise SceneError(f"its header has an unknown line: {short(line)}") from error
    if order is None or any(item.rows < 0 for item in elements):
        raise SceneError("its header has no format, or a negative count; it is damaged")
    if len(elements) > _MOST or any(len(item.properties) > _MOST for item in elements):
        raise SceneError(f"its header lists more than {_MOST} elements or properties")
    return order, elements, head, found.end()


def _property(words: list[str], order: str) -> Property:
    if words[1] == "list":
        count = np.dtype(order + _TYPES[words[2]])
        if count.kind not in "iu":
            raise ValueError("counts are whole numbers")
        return Property(words[4], np.dtype(order + _TYPES[words[3]]), count)
    return Property(words[2], np.dtype(order + _TYPES[words[1]]))

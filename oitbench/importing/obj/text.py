"""Lines of Wavefront files."""

from __future__ import annotations

import codecs

import numpy as np

from oitbench.errors import SceneError
from oitbench.importing.limits import short
from oitbench.scene import Floats

_MARKS = (
    (codecs.BOM_UTF8, "utf-8-sig"), (codecs.BOM_UTF16_LE, "utf-16"),
    (codecs.BOM_UTF16_BE, "utf-16"),
)  # fmt: skip


def lines_of(content: bytes) -> list[str]:
    """Return the lines of a file; a backslash at the end of a line continues it."""
    encoding = next((name for mark, name in _MARKS if content.startswith(mark)), "latin-1")
    try:
        text = content.decode(encoding)
    except UnicodeDecodeError as error:
        raise SceneError(f"its text cannot be read: {error}") from error
    if encoding == "latin-1" and not content.isascii():
        # Names may be UTF-8; numbers are the same in both.
        text = content.decode("utf-8", "surrogateescape")
    text = text.replace("\r\n", "\n").replace("\r", "\n")
    return text.replace("\\\n", " ").split("\n")


def keyword_of(line: str) -> tuple[str, str]:
    """Return the keyword of a line, and the text after it; both are empty for an empty line."""
    words = line.split(None, 1)
    return (words[0], words[1].rstrip()) if len(words) == 2 else ("".join(words), "")


def numbers_of(text: str, owner: str) -> list[float]:
    """Return the finite numbers of a text.

    Raises
    ------
    SceneError
        Something is no number, or NaN or infinite.
    """
    try:
        values = [float(word) for word in text.split()]
    except ValueError:
        raise SceneError(f"'{short(owner)}' has something that is no number") from None
    if not np.isfinite(values).all():
        raise SceneError(f"'{short(owner)}' holds NaN or infinity; export the file again")
    return values


def table_of(rows: list[str], least: int, owner: str) -> Floats:
    """Return rows of numbers as an array with as many columns as all rows have, `least` or more."""
    if not rows:
        return np.zeros((0, least))
    widths = {len(row.split()) for row in rows}
    if min(widths) < least:
        raise SceneError(f"a line '{owner}' has {min(widths)} numbers; it needs {least}")
    try:
        if len(widths) == 1:
            table = np.array(" ".join(rows).split(), dtype=np.float64).reshape(len(rows), -1)
        else:
            width = min(widths)
            table = np.array([row.split()[:width] for row in rows], dtype=np.float64)
    except ValueError:
        raise SceneError(f"a line '{owner}' has something that is no number") from None
    if not np.isfinite(table).all():
        raise SceneError(f"a line '{owner}' holds NaN or infinity; export the file again")
    return table

"""Damage of files, and disks that are full, for tests of code that must notice them."""

from __future__ import annotations

import resource
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path


def flip_bit(path: Path, number: int) -> None:
    """Flip one bit of a file."""
    content = bytearray(path.read_bytes())
    content[number // 8] ^= 1 << number % 8
    path.write_bytes(content)


def cut(path: Path, count: int) -> None:
    """Remove bytes from the end of a file."""
    path.write_bytes(path.read_bytes()[:-count])


@contextmanager
def largest_file(size: int) -> Iterator[None]:
    """Let this process, and those that it starts, write no file beyond `size` bytes.

    The system answers as on a full disk, with another number of the error.
    """
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)

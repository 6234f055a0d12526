"""The results folder: one fsynced line per cell, run facts, images; it survives a killed run."""

from __future__ import annotations

import hashlib
import logging
import os
import re
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import TypeVar

import msgspec

from oitbench import json_text
from oitbench.atomic import replacing
from oitbench.errors import UsageError
from oitbench.results.schema import VERSION, CellKey, Record, RunFacts

CELLS = "cells.jsonl"
RUN = "run.json"
IMAGES = "images"
_OURS = frozenset({CELLS, RUN, IMAGES, "report"})
_LOG = logging.getLogger(__name__)
Typed = TypeVar("Typed", Record, RunFacts)


def read_cells(path: Path) -> dict[CellKey, Record]:
    """Read a `cells.jsonl`, in order of first appearance; a later line replaces an earlier one.

    A damaged line, as a killed run leaves behind, is skipped and logged as a warning.

    Raises
    ------
    UsageError
        The file cannot be read, or another version of the suite wrote it.
    """
    cells: dict[CellKey, Record] = {}
    try:
        lines = path.read_bytes().split(b"\n")
    except FileNotFoundError:
        return cells
    except OSError as error:
        raise UsageError(f"{path} cannot be read: {error.strerror}") from error
    for number, line in enumerate(lines, start=1):
        if not line.strip():
            continue
        try:
            record = _decode(line, Record, path)
        except ValueError:
            _LOG.warning("%s: line %d is damaged and skipped; its cell runs again", path, number)
            continue
        cells[record.key] = record
    return cells


def read_run(path: Path) -> RunFacts | None:
    """Read a `run.json`; None if there is none.

    Raises
    ------
    UsageError
        The file is damaged, or another version of the suite wrote it.
    """
    try:
        return _decode(path.read_bytes(), RunFacts, path)
    except FileNotFoundError:
        return None
    except (OSError, ValueError) as error:
        raise UsageError(f"{path} is damaged; delete it and run again") from error


def _decode(text: bytes, kind: type[Typed], path: Path) -> Typed:
    """Return the record or the facts in `text`; raise `ValueError` if it is damaged."""
    try:
        return msgspec.json.decode(text, type=kind)
    except (msgspec.DecodeError, UnicodeDecodeError, RecursionError) as error:
        try:
            content = json_text.loads(text)
        except ValueError:
            content = None
        if isinstance(content, dict) and content and content.get("schema") != VERSION:
            raise UsageError(
                f"{path} was written by another version of oitbench (schema"
                f" {content.get('schema', 0)}, this one has {VERSION}); use a new folder"
            ) from error
        raise ValueError(str(error)) from error


def image_path(key: CellKey, kind: str) -> str:
    """Return the path of an image of a cell below the results folder: `images/….exr`.

    Labels contain brackets and slashes, so a digest follows the readable part of the name.
    """
    readable = re.sub(r"[^A-Za-z0-9._=-]+", "_", f"{key.scene}-{key.method}").strip("_.")
    digest = hashlib.sha256(msgspec.json.encode(key)).hexdigest()[:8]
    return f"{IMAGES}/{readable[:80]}-{key.size[0]}x{key.size[1]}-{digest}-{kind}.exr"


@dataclass(frozen=True)
class Store:
    """An open results folder. `Store.open` makes one; only one process may write to it."""

    folder: Path
    _cells: dict[CellKey, Record] = field(repr=False)

    @classmethod
    def open(cls, folder: Path | str) -> Store:
        """Open a results folder; it is created if it does not exist.

        Raises
        ------
        UsageError
            The folder cannot be written to, holds something other than results, or results of
            another version of the suite.
        """
        folder = Path(folder)
        _refuse_foreign(folder)
        try:
            (folder / IMAGES).mkdir(parents=True, exist_ok=True)
            probe = folder / f".{os.getpid()}.partial"
            probe.touch()
            probe.unlink()
        except OSError as error:
            raise UsageError(
                f"{folder} cannot be written to ({error.strerror}); give another folder"
            ) from error
        return cls(folder, read_cells(folder / CELLS))

    def records(self) -> list[Record]:
        """Return the newest record of every cell, in order of first appearance."""
        return list(self._cells.values())

    def find(self, key: CellKey) -> Record | None:
        """Return the newest record of that cell, or None."""
        return self._cells.get(key)

    def append(self, record: Record) -> None:
        """Add a record; it is on the disk when this returns."""
        line = _line(record)
        stored = msgspec.json.decode(line, type=Record)
        path = self.folder / CELLS
        with _writing(path):
            descriptor = os.open(path, os.O_RDWR | os.O_APPEND | os.O_CREAT, 0o644)
            try:
                if not _ends_with_newline(descriptor):
                    # A killed run left half a line, which must not swallow this one.
                    line = b"\n" + line
                while line:
                    line = line[os.write(descriptor, line) :]
                os.fsync(descriptor)
            finally:
                os.close(descriptor)
        self._cells[stored.key] = stored

    def compact(self) -> None:
        """Rewrite `cells.jsonl` with one line per cell, atomically."""
        _replace(self.folder / CELLS, b"".join(_line(record) for record in self.records()))

    def write_run(self, facts: RunFacts) -> None:
        """Write `run.json`, atomically.

        Raises
        ------
        UsageError
            The folder's cells come from another renderer: their times share no axis.
        """
        known = read_run(self.folder / RUN)
        before = known.renderer if known else ""
        if self._cells and before and facts.renderer and before != facts.renderer:
            raise UsageError(
                f"{self.folder} holds cells rendered by '{before}', but this is"
                f" '{facts.renderer}'; give another folder"
            )
        text = msgspec.json.format(msgspec.json.encode(facts), indent=2)
        _replace(self.folder / RUN, text + b"\n")


def _refuse_foreign(folder: Path) -> None:
    try:
        names = {entry.name for entry in folder.iterdir() if not entry.name.startswith(".")}
    except FileNotFoundError:
        return
    except OSError as error:
        raise UsageError(f"{folder} is no results folder ({error.strerror})") from error
    if names - _OURS and not names & {CELLS, RUN}:
        raise UsageError(
            f"{folder} holds something else ({min(names - _OURS)}); give an empty or a new folder"
        )


def _line(record: Record) -> bytes:
    return msgspec.json.encode(record) + b"\n"


def _ends_with_newline(descriptor: int) -> bool:
    size = os.fstat(descriptor).st_size
    return size == 0 or os.pread(descriptor, 1, size - 1) == b"\n"


def _replace(path: Path, content: bytes) -> None:
    with replacing(path) as partial, partial.open("wb") as file:
        file.write(content)
        file.flush()
        os.fsync(file.fileno())


@contextmanager
def _writing(path: Path) -> Iterator[None]:
    try:
        yield
    except OSError as error:
        raise UsageError(f"{path} cannot be written ({error.strerror})") from error

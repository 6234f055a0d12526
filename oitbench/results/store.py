"""The results folder: one checked line per cell, run facts, images.

It survives a killed run, a full disk and damaged files: what is damaged is noticed, never believed.
"""

from __future__ import annotations

import logging
import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import TypeVar

import msgspec

from oitbench import json_text
from oitbench.atomic import locked, remove_partial_files, replacing, writing
from oitbench.errors import StorageError, UsageError
from oitbench.results.checksum import CHECKSUM, seal, unseal
from oitbench.results.schema import VERSION, CellKey, Record, RunFacts

CELLS = "cells.jsonl"
RUN = "run.json"
CONFIG = "run.toml"
IMAGES = "images"
SCENES = "scenes"
"""Folder of the scenes that were built in Python, so that a later run finds them."""
_LOCK = "run.lock"
_OURS = frozenset(
    {
        CELLS,
        RUN,
        CONFIG,
        IMAGES,
        SCENES,
        _LOCK,
        "engines",
        "motion",
        "reference_check",
        "report",
        "stability",
        "visibility",
    }
)
"""What a run and other commands write to a results folder by default."""
_SHOWN = 5
_LOG = logging.getLogger(__name__)
Typed = TypeVar("Typed", Record, RunFacts)


def read_cells(path: Path) -> dict[CellKey, Record]:
    """Read a `cells.jsonl`, in order of first appearance; a later line replaces an earlier one.

    A damaged line, as a killed run leaves behind, is skipped. One warning names all of them.

    Raises
    ------
    UsageError
        The file cannot be read, or another version of the suite wrote it.
    """
    cells, damaged = _parse_cells(path)
    if damaged:
        lines = ", ".join(map(str, damaged[:_SHOWN]))
        more = f" and {len(damaged) - _SHOWN} more" if len(damaged) > _SHOWN else ""
        _LOG.warning(
            "%s: damaged and skipped: line %s%s; a run renders their cells again", path, lines, more
        )
    return cells


def damaged_lines(path: Path) -> list[int]:
    """Return the numbers of the lines of a `cells.jsonl` whose content does not fit its checksum.

    Raises
    ------
    UsageError
        As `read_cells` does.
    """
    return _parse_cells(path)[1]


def _parse_cells(path: Path) -> tuple[dict[CellKey, Record], list[int]]:
    """Return what `read_cells` does, and the numbers of damaged lines."""
    cells: dict[CellKey, Record] = {}
    damaged: list[int] = []
    try:
        lines = path.read_bytes().split(b"\n")
    except FileNotFoundError:
        lines = []
    except OSError as error:
        raise UsageError(f"{path} cannot be read ({error.strerror})") from error
    for number, line in enumerate(lines, start=1):
        if not line.strip():
            continue
        record = _decode(line, Record, path)
        if record is None:
            damaged.append(number)
        else:
            cells[record.key] = record
    return cells, damaged


def read_run(path: Path) -> RunFacts | None:
    """Read a `run.json`; None if there is none, or if it is damaged, which a warning says.

    Raises
    ------
    UsageError
        The file cannot be read, or another version of the suite wrote it.
    """
    try:
        facts = _decode(path.read_bytes().strip(), RunFacts, path)
    except FileNotFoundError:
        return None
    except OSError as error:
        raise UsageError(f"{path} cannot be read ({error.strerror})") from error
    if facts is None:
        _LOG.warning("%s is damaged and ignored; the next run writes it anew", path)
    return facts


def _decode(text: bytes, kind: type[Typed], path: Path) -> Typed | None:
    """Return the record or the facts in `text`; None if it is damaged."""
    body = unseal(text)
    if body is not None:
        with suppress(msgspec.DecodeError, UnicodeDecodeError):
            return msgspec.json.decode(body, type=kind)
    try:
        content = json_text.loads(text)
    except ValueError:
        return None
    if not isinstance(content, dict) or not content:
        return None
    # A version without a valid checksum is only believed where no checksum was ever written.
    version = content.get("schema", 0)
    if version != VERSION and (body is not None or CHECKSUM not in content):
        raise UsageError(
            f"{path} was written by another version of oitbench (schema {version}, this one has"
            f" {VERSION}); use a new folder"
        )
    return None


@dataclass(frozen=True)
class Store:
    """An open results folder. `Store.open` makes one, and only one process has it at a time."""

    folder: Path
    _cells: dict[CellKey, Record] = field(repr=False)

    @classmethod
    @contextmanager
    def open(cls, folder: Path | str) -> Iterator[Store]:
        """Open a results folder until the end of the block; it is created if it does not exist.

        Raises
        ------
        UsageError
            The folder cannot be written to, another run writes to it, or it holds something other
            than results, or results of another version of the suite.
        """
        folder = Path(folder)
        refuse_foreign(folder)
        try:
            (folder / IMAGES).mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise StorageError(
                f"{folder} cannot be written to ({error.strerror}); give another folder"
            ) from error
        with locked(folder / _LOCK):
            with writing(folder):
                remove_partial_files(folder)
                remove_partial_files(folder / IMAGES)
            yield cls(folder, read_cells(folder / CELLS))

    @classmethod
    def read(cls, folder: Path | str) -> Store:
        """Return a results folder that is only read; it need not exist.

        Raises
        ------
        UsageError
            The folder holds something other than results, or results of another version.
        """
        folder = Path(folder)
        refuse_foreign(folder)
        return cls(folder, read_cells(folder / CELLS))

    def records(self) -> list[Record]:
        """Return the newest record of every cell, in order of first appearance."""
        return list(self._cells.values())

    def find(self, key: CellKey) -> Record | None:
        """Return the newest record of that cell, or None."""
        return self._cells.get(key)

    def append(self, record: Record) -> None:
        """Add a record; it is on the disk when this returns.

        Raises
        ------
        StorageError
            The file cannot be written. It then holds what it held before.
        """
        line = _line(record)
        stored = msgspec.json.decode(msgspec.json.encode(record), type=Record)
        path = self.folder / CELLS
        with writing(path):
            descriptor = os.open(path, os.O_RDWR | os.O_APPEND | os.O_CREAT, 0o644)
            try:
                _append(descriptor, line)
            finally:
                os.close(descriptor)
        self._cells[stored.key] = stored

    def compact(self) -> None:
        """Rewrite `cells.jsonl` with one line per cell, and remove images that no cell names.

        Cells that are only in the file are kept.
        """
        cells = _parse_cells(self.folder / CELLS)[0] | self._cells
        _replace(self.folder / CELLS, b"".join(map(_line, cells.values())))
        named = {
            image.path
            for record in cells.values()
            if record.outcome is not None
            for image in record.outcome.images.values()
        }
        with writing(self.folder / IMAGES):
            for path in (self.folder / IMAGES).glob("*.exr"):
                if f"{IMAGES}/{path.name}" not in named:
                    path.unlink(missing_ok=True)

    def check_renderer(self, renderer: str) -> None:
        """Raise `UsageError` if cells come from another renderer: their times share no axis."""
        for record in self._cells.values():
            if record.gl is not None and record.gl.renderer != renderer:
                raise UsageError(
                    f"{self.folder} holds cells rendered by '{record.gl.renderer}', but this is"
                    f" '{renderer}'; give another folder"
                )

    def write_run(self, facts: RunFacts) -> None:
        """Write `run.json`, atomically."""
        text = msgspec.json.format(msgspec.json.encode(facts), indent=2)
        _replace(self.folder / RUN, seal(text) + b"\n")

    def write_config(self, text: str) -> None:
        """Write `run.toml`, the options that repeat the run, atomically; nothing if `text` is "".

        Text that is no UTF-8, as in names of some files, is escaped.
        """
        if text:
            _replace(self.folder / CONFIG, text.encode(errors="backslashreplace"))


def refuse_foreign(folder: Path) -> None:
    """Raise `UsageError` if a folder holds something other than results."""
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
    return seal(msgspec.json.encode(record)) + b"\n"


def _append(descriptor: int, line: bytes) -> None:
    size = os.fstat(descriptor).st_size
    if size and os.pread(descriptor, 1, size - 1) != b"\n":
        # A killed run left half a line, which must not swallow this one.
        line = b"\n" + line
    try:
        while line:
            line = line[os.write(descriptor, line) :]
        os.fsync(descriptor)
    except OSError:
        os.ftruncate(descriptor, size)
        raise


def _replace(path: Path, content: bytes) -> None:
    with replacing(path) as partial:
        partial.write_bytes(content)

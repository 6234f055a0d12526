"""The results folder: one fsynced line per cell, run facts, images; it survives a killed run."""

from __future__ import annotations

import hashlib
import json
import logging
import math
import os
import re
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from oitbench.errors import UsageError

Record = dict[str, Any]
"""One cell of the matrix of scenes and methods, as `cells.jsonl` holds it."""

CELLS = "cells.jsonl"
RUN = "run.json"
IMAGES = "images"
_OURS = frozenset({CELLS, RUN, IMAGES, "report"})
_LOG = logging.getLogger(__name__)


@dataclass(frozen=True)
class CellKey:
    """What tells one cell from another.

    Parameters
    ----------
    scene, method : str
        Labels with those parameters that differ from their defaults.
    size : (int, int)
        Width and height in pixels.
    variant : str
        The cell's variant mapping (sub-pixel grid, effects, …) as canonical JSON.
    """

    scene: str
    method: str
    size: tuple[int, int]
    variant: str

    @classmethod
    def of(cls, record: Mapping[str, Any]) -> CellKey:
        """Return the key of `record`; KeyError if it lacks one of the four fields."""
        width, height = record["size"]
        variant = json.dumps(sanitize(record["variant"]), sort_keys=True)
        return cls(record["scene"], record["method"], (int(width), int(height)), variant)


def sanitize(value: Any) -> Any:
    """Return `value` as plain JSON: floats that are not finite become None.

    Raises
    ------
    TypeError
        For anything that JSON has no word for.
    """
    if isinstance(value, np.generic | np.ndarray):
        value = value.tolist()
    if value is None or isinstance(value, bool | int | str):
        return value
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if isinstance(value, Mapping):
        return {str(key): sanitize(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [sanitize(item) for item in value]
    if isinstance(value, Path):
        return value.as_posix()
    raise TypeError(f"{type(value).__name__} cannot be stored in a results folder")


def read_cells(path: Path) -> dict[CellKey, Record]:
    """Read a `cells.jsonl`, in order of first appearance; a later line supersedes an earlier one.

    A line that cannot be read, as a killed run leaves behind, is left out and logged as a warning.
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
            record = json.loads(line, parse_constant=lambda _: None)
            key = CellKey.of(record)
            hash(key)
        except (ValueError, KeyError, TypeError):
            _LOG.warning("%s: line %d is damaged and left out; its cell runs again", path, number)
            continue
        cells[key] = record
    return cells


def read_run(path: Path) -> dict[str, Any]:
    """Read a `run.json`; empty if there is none, `UsageError` if it is damaged."""
    try:
        facts = json.loads(path.read_bytes())
    except FileNotFoundError:
        return {}
    except (OSError, ValueError) as error:
        raise UsageError(f"{path} is damaged; delete it and run again") from error
    if not isinstance(facts, dict):
        raise UsageError(f"{path} holds no facts of a run; delete it and run again")
    return facts


def image_path(key: CellKey, kind: str) -> str:
    """Return where an image of a cell goes, relative to the folder: `images/….exr`.

    Labels hold brackets and slashes, so the readable part of the name is followed by a digest.
    """
    readable = re.sub(r"[^A-Za-z0-9._=-]+", "_", f"{key.scene}-{key.method}").strip("_.")
    digest = hashlib.sha256(repr(key).encode()).hexdigest()[:8]
    return f"{IMAGES}/{readable[:80]}-{key.size[0]}x{key.size[1]}-{digest}-{kind}.exr"


@dataclass(frozen=True)
class Store:
    """An open results folder. `Store.open` makes one; only one process may write to it."""

    folder: Path
    _cells: dict[CellKey, Record] = field(repr=False)

    @classmethod
    def open(cls, folder: Path | str) -> Store:
        """Open a results folder, made if need be.

        Raises
        ------
        UsageError
            If the folder cannot be written to, or holds something else than results.
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

    def append(self, record: Mapping[str, Any]) -> None:
        """Add a record; when this returns, it is on the disk."""
        stored: Record = sanitize(record)
        key = CellKey.of(stored)
        line = _line(stored)
        path = self.folder / CELLS
        with _writing(path):
            descriptor = os.open(path, os.O_RDWR | os.O_APPEND | os.O_CREAT, 0o644)
            try:
                if not _ends_with_newline(descriptor):
                    # A killed run left half a line; it must not swallow this one.
                    line = b"\n" + line
                while line:
                    line = line[os.write(descriptor, line) :]
                os.fsync(descriptor)
            finally:
                os.close(descriptor)
        self._cells[key] = stored

    def compact(self) -> None:
        """Rewrite `cells.jsonl` with one line per cell, all at once."""
        _replace(self.folder / CELLS, b"".join(_line(record) for record in self.records()))

    def write_run(self, facts: Mapping[str, Any]) -> None:
        """Write `run.json`, all at once.

        Raises
        ------
        UsageError
            If the folder's cells come from another renderer: their times share no axis.
        """
        before = _renderer(read_run(self.folder / RUN))
        now = _renderer(facts)
        if self._cells and before and now and before != now:
            raise UsageError(
                f"{self.folder} holds cells rendered by '{before}', but this is '{now}'; "
                "give another folder"
            )
        text = json.dumps(sanitize(facts), indent=2, allow_nan=False, ensure_ascii=False)
        _replace(self.folder / RUN, text.encode() + b"\n")


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


def _renderer(facts: Mapping[str, Any]) -> str:
    gl = facts.get("gl")
    return str(gl.get("renderer", "")) if isinstance(gl, Mapping) else ""


def _line(record: Mapping[str, Any]) -> bytes:
    return json.dumps(record, allow_nan=False, ensure_ascii=False).encode() + b"\n"


def _ends_with_newline(descriptor: int) -> bool:
    size = os.fstat(descriptor).st_size
    return size == 0 or os.pread(descriptor, 1, size - 1) == b"\n"


def _replace(path: Path, content: bytes) -> None:
    """Write `path` so that a reader sees the old content or the new one, never a part."""
    partial = path.with_name(f".{path.name}.{os.getpid()}.partial")
    with _writing(path):
        with partial.open("wb") as file:
            file.write(content)
            file.flush()
            os.fsync(file.fileno())
        os.replace(partial, path)


@contextmanager
def _writing(path: Path) -> Iterator[None]:
    try:
        yield
    except OSError as error:
        raise UsageError(f"{path} cannot be written ({error.strerror})") from error

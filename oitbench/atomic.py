"""Writing files so that readers never find a part, and so that writers do not mix.

A file is written under a temporary name and then renamed. A lock file names the process that holds
it; the lock itself is the kernel's, so it ends with the process, however that ends.
"""

from __future__ import annotations

import errno
import fcntl
import os
import re
import socket
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from datetime import datetime, timezone
from pathlib import Path

import psutil

from oitbench.errors import StorageError, UsageError

FULL_DISK = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG)
"""Errors of the system that mean a lack of space: of the disk, of a user, or of a file."""


@contextmanager
def partial_file(path: Path) -> Iterator[Path]:
    """Yield a temporary path beside `path`; a file that is still there at the end is removed.

    Missing folders are created. Temporary files of `path` that killed processes of this machine
    left behind are removed first.

    Yields
    ------
    Path
        In the same folder and with the same suffix, unique to this process.

    Raises
    ------
    StorageError
        If the file cannot be written.
    """
    partial = path.with_name(f".{path.stem}.{os.getpid()}.partial{path.suffix}")
    with writing(path):
        path.parent.mkdir(parents=True, exist_ok=True)
        _remove_abandoned(path)
        try:
            yield partial
        finally:
            partial.unlink(missing_ok=True)


@contextmanager
def replacing(path: Path) -> Iterator[Path]:
    """Yield a temporary path, and move the file that is written there to `path`.

    Missing folders are created. If an exception is raised inside, `path` stays as it was. At the
    end the file is on the disk, so that a loss of power cannot empty it.

    Raises
    ------
    StorageError
        If the file cannot be written.
    """
    with partial_file(path) as partial:
        yield partial
        _synchronize(partial)
        os.replace(partial, path)
        _synchronize(path.parent)


@contextmanager
def writing(path: Path) -> Iterator[None]:
    """Turn an `OSError` inside into a `StorageError` that names `path` and the fix."""
    try:
        yield
    except OSError as error:
        fix = "free some space" if error.errno in FULL_DISK else "choose another folder"
        reason = error.strerror or str(error)
        raise StorageError(f"{path} cannot be written ({reason}); {fix}") from error


def _remove_abandoned(path: Path) -> None:
    """Remove temporary files of `path` whose processes no longer exist."""
    pattern = re.compile(
        rf"\.{re.escape(path.stem)}\.(\d+)\.partial{re.escape(path.suffix)}", re.ASCII
    )
    # It is possible that a folder can be written to, but not read.
    with suppress(OSError):
        for found in path.parent.iterdir():
            match = pattern.fullmatch(found.name)
            if match is not None and not psutil.pid_exists(int(match[1])):
                found.unlink(missing_ok=True)


def remove_partial_files(folder: Path) -> None:
    """Remove temporary files that a killed process left in `folder`.

    The caller must know that no process is writing there, for example from a lock.
    """
    for path in folder.glob(".*.partial*"):
        path.unlink(missing_ok=True)


@contextmanager
def locked(path: Path, *, wait: bool = False) -> Iterator[None]:
    """Hold the lock file `path`; it is removed at the end.

    A file that a killed process left behind locks nothing and is taken over.

    Parameters
    ----------
    path : Path
        Its folder must exist.
    wait : bool
        Wait until another process releases the lock, or refuse at once.

    Raises
    ------
    UsageError
        Another process holds the lock. The message names it.
    StorageError
        If the file cannot be written.
    """
    with writing(path):
        descriptor = _acquire(path, wait)
        try:
            host, start = socket.gethostname(), datetime.now(timezone.utc)
            text = f"process {os.getpid()} on {host} since {start:%Y-%m-%d %H:%M:%S} UTC\n"
            os.ftruncate(descriptor, 0)
            os.pwrite(descriptor, text.encode(), 0)
        except BaseException:
            os.close(descriptor)
            raise
    try:
        yield
    finally:
        # Removed while the lock is held, so that nobody locks a file that is about to vanish.
        path.unlink(missing_ok=True)
        os.close(descriptor)


def _acquire(path: Path, wait: bool) -> int:
    """Return a descriptor of the file that is at `path`, with its lock."""
    while True:
        descriptor = os.open(path, os.O_RDWR | os.O_CREAT, 0o644)
        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX | (0 if wait else fcntl.LOCK_NB))
            if _is_at(descriptor, path):
                return descriptor
        except BlockingIOError:
            holder = os.pread(descriptor, 200, 0).decode(errors="replace").strip()
            os.close(descriptor)
            raise UsageError(
                f"{path.parent} is in use by {holder or 'another process'};"
                " wait for it to end, or give another folder"
            ) from None
        except BaseException:
            os.close(descriptor)
            raise
        os.close(descriptor)  # Its holder removed the file after it was opened here.


def _is_at(descriptor: int, path: Path) -> bool:
    try:
        return os.path.samestat(os.fstat(descriptor), path.stat())
    except FileNotFoundError:
        return False


def _synchronize(path: Path) -> None:
    descriptor = os.open(path, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)

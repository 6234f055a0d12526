"""Writing a file so that readers find the old content or the new content, never a part."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from oitbench.errors import UsageError


@contextmanager
def replacing(path: Path) -> Iterator[Path]:
    """Yield a temporary path, and move the file that is written there to `path`.

    Missing folders are created. If an exception is raised inside, `path` stays as it was.

    Parameters
    ----------
    path : Path

    Yields
    ------
    Path
        In the same folder and with the same suffix, unique to this process.

    Raises
    ------
    UsageError
        If the file cannot be written.
    """
    partial = path.with_name(f".{path.stem}.{os.getpid()}.partial{path.suffix}")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        try:
            yield partial
            os.replace(partial, path)
        except BaseException:
            partial.unlink(missing_ok=True)
            raise
    except OSError as error:
        raise UsageError(f"{path} cannot be written; choose another folder") from error

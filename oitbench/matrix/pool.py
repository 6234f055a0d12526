"""The near end of a process that renders, scores and times cells."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from oitbench.catalog.catalog import Catalog
from oitbench.matrix.worker import Hello, Reply, Settings
from oitbench.workers import memory
from oitbench.workers.process import Process


class WorkerProcess(Process):
    """A worker process; it starts with the first request, and again after it has ended.

    Parameters
    ----------
    collections : sequence of Path
        All collection folders.
    methods : sequence of Path
        Folders of further methods.
    scenes : sequence of Path
        Files that are scenes.
    folder : Path
        The results folder.
    memory_limit : int
        Bytes that the process and its children may use.
    """

    def __init__(
        self,
        collections: Sequence[Path],
        methods: Sequence[Path],
        scenes: Sequence[Path],
        folder: Path,
        memory_limit: int,
    ) -> None:
        settings = Settings(
            [os.fsencode(path) for path in collections],
            [os.fsencode(path) for path in methods],
            [os.fsencode(path) for path in scenes],
            os.fsencode(folder),
        )
        super().__init__("oitbench.matrix.worker", settings, Reply, memory_limit, Hello())


@contextmanager
def lone_worker(
    scene: str, collections: Iterable[Path | str], memory_gib: float | None
) -> Iterator[tuple[Process, Path]]:
    """Yield a worker process for a single request, and an empty folder for its answer.

    Parameters
    ----------
    scene : str
        The scene of the request, `NAME[param=v]` or `FILE[param=v]`; a file is checked.
    collections : iterable of path
        Folders of further collections.
    memory_gib : float, optional
        Memory that the process may use, in GiB. Default: 75 % of the machine's.
    """
    with Catalog(collections) as catalog:
        folders = catalog.places.folders
        files = catalog.check_files([scene])
    limit = memory.limit(memory_gib, 1)
    with tempfile.TemporaryDirectory(prefix="oitbench-") as name:
        folder = Path(name)
        with WorkerProcess(folders, (), files, folder, limit) as worker:
            yield worker, folder

"""The near end of a process that renders, scores and times cells."""

from __future__ import annotations

import tempfile
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path

from oitbench.catalog.catalog import Catalog
from oitbench.matrix.worker import Hello, Reply, Settings
from oitbench.places import PluginFiles
from oitbench.workers import memory
from oitbench.workers.process import Process


class WorkerProcess(Process):
    """A worker process; it starts with the first request, and again after it has ended.

    Parameters
    ----------
    plugins : PluginFiles
    folder : Path
        The results folder.
    memory_limit : int
        Bytes that the process and its children may use.
    """

    def __init__(self, plugins: PluginFiles, folder: Path, memory_limit: int) -> None:
        settings = Settings(plugins, folder)
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
        catalog.check_files([scene])
        plugins = catalog.places.files()
    limit = memory.limit(memory_gib, 1)
    with tempfile.TemporaryDirectory(prefix="oitbench-") as name:
        folder = Path(name)
        with WorkerProcess(plugins, folder, limit) as worker:
            yield worker, folder

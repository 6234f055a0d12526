"""A worker process for a single request."""

from __future__ import annotations

import tempfile
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path

from oitbench.catalog.catalog import Catalog
from oitbench.executors.processes import LocalWorker
from oitbench.matrix.worker import far_end
from oitbench.workers import memory
from oitbench.workers.process import Process


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
        with LocalWorker(far_end(plugins, folder), limit) as worker:
            yield worker, folder

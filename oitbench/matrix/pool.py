"""The near end of a process that renders, scores and times cells."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path

from oitbench.matrix.worker import Hello, Reply, Settings
from oitbench.workers.process import Process


class WorkerProcess(Process):
    """A worker process; it starts with the first request, and again after it has ended.

    Parameters
    ----------
    collections : sequence of Path
        All collection folders.
    methods : sequence of Path
        Folders of further methods.
    folder : Path
        The results folder.
    memory_limit : int
        Bytes that the process and its children may use.
    """

    def __init__(
        self,
        collections: Sequence[Path],
        methods: Sequence[Path],
        folder: Path,
        memory_limit: int,
    ) -> None:
        settings = Settings(
            [os.fsencode(path) for path in collections],
            [os.fsencode(path) for path in methods],
            os.fsencode(folder),
        )
        super().__init__("oitbench.matrix.worker", settings, Reply, memory_limit, Hello())

"""Local processes: the default, and the only ones that survive crashes of plugins by themselves."""

from __future__ import annotations

from oitbench.executors.executor import Executor, Far, OnLine
from oitbench.workers.cores import usable_cores
from oitbench.workers.process import Process


class LocalWorker(Process):
    """A process of this machine; it starts with the first request, and again after it has ended.

    Parameters
    ----------
    far : Far
    memory_limit : int
        Bytes that the process and its children may use.
    threads : int, optional
        See `Process`.
    """

    name = "this machine"

    def __init__(self, far: Far, memory_limit: int, threads: int | None = None) -> None:
        super().__init__(far.module, far.settings, far.replies, memory_limit, far.greeting, threads)


class Processes(Executor):
    """Processes of this machine.

    Parameters
    ----------
    far : Far
    count : int
    memory_limit : int
        Bytes that each of them may use.
    on_line : callable
        See `Executor`.
    """

    def __init__(self, far: Far, count: int, memory_limit: int, on_line: OnLine) -> None:
        # More threads than cores wait for each other in metrics.
        threads = max(1, len(usable_cores()) // count)
        super().__init__([LocalWorker(far, memory_limit, threads) for _ in range(count)], on_line)

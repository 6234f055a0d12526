"""The place where a user wants work to be done."""

from __future__ import annotations

from dataclasses import dataclass

from oitbench.errors import UsageError
from oitbench.executors.executor import Executor, Far, OnLine
from oitbench.executors.in_process import InProcess
from oitbench.executors.processes import Processes
from oitbench.workers import memory


@dataclass(frozen=True)
class Place:
    """A place of work.

    Parameters
    ----------
    workers : int
        Processes of this machine that work at once. 0: this process, for debugging.
    dask : str
        Address of a Dask scheduler, whose workers are used instead; empty for none.
    memory_gib : float, optional
        Memory that each process may use, in GiB. Default: 75 % of its machine's, divided by the
        number of workers there.

    Raises
    ------
    UsageError
        `workers` is negative, or `memory_gib` is too little.
    """

    workers: int = 1
    dask: str = ""
    memory_gib: float | None = None

    def __post_init__(self) -> None:
        if self.workers < 0:
            raise UsageError(f"workers is {self.workers}; give at least 0")
        memory.limit(self.memory_gib, 1)

    @property
    def memory_limit(self) -> int:
        """Bytes that each process of this machine may use."""
        return memory.limit(self.memory_gib, max(self.workers, 1))

    def open(self, far: Far, on_line: OnLine = lambda line: None) -> Executor:
        """Return the executor.

        Parameters
        ----------
        far : Far
        on_line : callable
            See `Executor`.

        Raises
        ------
        UsageError
            The cluster cannot be used.
        """
        if self.dask:
            try:
                from oitbench.executors.cluster import Cluster
            except ImportError as error:
                raise UsageError(
                    f"--dask needs a package ({error}); run: pip install 'oitbench[cluster]'"
                ) from error
            return Cluster(far, self.dask, self.memory_gib, on_line)
        if self.workers == 0:
            return InProcess(far, on_line)
        return Processes(far, self.workers, self.memory_limit, on_line)

"""The near end of a process that checks and measures methods."""

from __future__ import annotations

from collections.abc import Sequence

from oitbench.catalog.catalog import Catalog, Choice
from oitbench.errors import DeclarationError
from oitbench.results.schema import Renderer
from oitbench.stability.check import METHOD_SECONDS, Check
from oitbench.stability.overview import Overview
from oitbench.stability.result import BREAKS, CheckResult
from oitbench.stability.worker import (
    Examine,
    Examined,
    Greeting,
    Hello,
    Measure,
    Measured,
    Reply,
)
from oitbench.workers.messages import Step
from oitbench.workers.process import Process, WorkerError


class Laboratory:
    """Checks and measures methods in a process of its own; a context manager.

    The process starts again after a method has ended it. That method is *lost*: it is not used
    again, and other methods are not affected.

    Parameters
    ----------
    catalog : Catalog
        It must have the files of all methods; it may be closed afterwards.
    methods : sequence of Choice
        The methods that are used. Those that cannot be loaded are lost from the start.
    memory_limit : int
        Bytes that the process may use.
    timeout : float, optional
        Seconds for each check of a method, or for its overview. Default: no limit.

    Attributes
    ----------
    lost : dict of str to str
        From the label of a method to the reason.

    Raises
    ------
    DeclarationError
        No method can be loaded.
    """

    def __init__(
        self,
        catalog: Catalog,
        methods: Sequence[Choice],
        memory_limit: int,
        timeout: float | None = METHOD_SECONDS,
    ) -> None:
        self._names = {method.label: method.name for method in methods}
        self.lost = {method.label: method.error for method in methods if method.error}
        if len(self.lost) == len(self._names):
            raise DeclarationError("; ".join(dict.fromkeys(self.lost.values())))
        files = catalog.places.files(self._names.values())
        self._timeout = timeout
        self._worker = Process("oitbench.stability.worker", files, Reply, memory_limit, Hello())

    def __enter__(self) -> Laboratory:
        return self

    def __exit__(self, *error: object) -> None:
        self._worker.stop()

    def renderer(self) -> Renderer:
        """Return the renderer of the process.

        Raises
        ------
        CapabilityError
            There is no OpenGL on this machine.
        """
        return self._worker.ask(Hello(), Greeting, retry=True).gl

    def examine(self, check: Check, method: str) -> CheckResult:
        """Run one check on the method of a label; a lost method breaks every check."""
        if method not in self.lost:
            step, request = Step(f"checking {check.name}"), Examine(check.name, method)
            try:
                return self._worker.ask(request, Examined, self._timeout, step).result
            except (WorkerError, DeclarationError) as error:
                self.lost[method] = str(error)
        return CheckResult(
            method,
            self._names[method],
            check.name,
            check.sentence,
            check.identity,
            promised=False,
            status=BREAKS,
            reason=self.lost[method],
        )

    def overview(self, method: str) -> list[Overview]:
        """Return the overview of the method of a label; none if it is or gets lost."""
        if method not in self.lost:
            step, request = Step("measuring the method"), Measure(method)
            try:
                return self._worker.ask(request, Measured, self._timeout, step).rows
            except (WorkerError, DeclarationError) as error:
                self.lost[method] = str(error)
        return []

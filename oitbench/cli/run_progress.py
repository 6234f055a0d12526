"""Progress of `oitbench run`: one line on a terminal, else one line for each finished cell."""

from __future__ import annotations

from collections.abc import Sequence
from types import TracebackType
from typing import TYPE_CHECKING

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn
from rich.table import Column

from oitbench.matrix.cell import Cell
from oitbench.matrix.forecast import Forecast, duration
from oitbench.results.schema import TROUBLED, Record

if TYPE_CHECKING:
    from oitbench.matrix.plan import Matrix


class RunProgress:
    """Shows a run while it goes on; a context manager.

    A terminal shows one line with the scene, the method, the stage and the time left. Other outputs
    get a line for each finished cell, so that no control characters end in a file.

    Parameters
    ----------
    matrix : Matrix
    quiet : bool
        Show only what went wrong.
    """

    def __init__(self, matrix: Matrix, quiet: bool = False) -> None:
        self._forecast = Forecast(matrix.cells, matrix.schedule, matrix.workers)
        self._console = Console(stderr=True, highlight=False, soft_wrap=True)
        self._quiet = quiet
        self._lines = not quiet and not self._console.is_terminal
        self._bar = Progress(
            BarColumn(20),
            MofNCompleteColumn(),
            TextColumn("{task.fields[left]}"),
            TextColumn(
                "{task.description}",
                markup=False,
                table_column=Column(no_wrap=True, overflow="ellipsis", ratio=1),
            ),
            console=self._console,
            transient=True,
            expand=True,
            disable=quiet or self._lines,
        )
        self._task = self._bar.add_task("starting", total=self._forecast.total, left="")

    def __enter__(self) -> RunProgress:
        self._bar.start()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._bar.stop()

    def line(self, text: str) -> None:
        """Print a line for the user."""
        if not self._quiet:
            self._print(text)

    def stage(self, labels: str, stage: str) -> None:
        """Show which part of the work on a scene, or on one of its cells, has begun."""
        self._bar.update(self._task, description=f"{labels}: {stage}")

    def record(self, cell: Cell, record: Record | None) -> None:
        """Count a cell that is finished, or kept if there is no record."""
        self._forecast.finish(cell, record.seconds if record and record.finished else None)
        self._bar.advance(self._task)
        left = self._left()
        if record is None:
            return
        text = f"{record.status}: {cell.seen} {cell.method}"
        if record.status in TROUBLED or record.status == "skipped":
            self._print(f"{text}: {record.reason}")
        elif self._lines:
            done = f"{self._forecast.done} of {self._forecast.total}"
            self._print(f"{text}: {duration(record.seconds)}; {done}{left and f', {left}'}")

    def timed(self, cells: Sequence[Cell], seconds: float) -> None:
        """Count a scene that was timed."""
        self._forecast.finish_timing(cells, seconds)
        left = self._left()
        if self._lines:
            count = f"{len(cells)} cells, {duration(seconds)}"
            self._print(f"timed: {cells[0].seen}: {count}{left and f'; {left}'}")

    def _left(self) -> str:
        """Return the time left in words, and show it."""
        seconds = self._forecast.left()
        text = f"{duration(seconds)} left" if seconds else ""
        # Each finished cell is drawn at once, also where cells are faster than the display.
        self._bar.update(self._task, left=text, refresh=True)
        return text

    def _print(self, text: str) -> None:
        self._console.print(text, markup=False)

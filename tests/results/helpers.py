"""Made-up runs of two cells, of which one changes."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any, cast

import msgspec

import oitbench
from oitbench.results.comparison import Comparison
from oitbench.results.schema import Record, Renderer
from tests.made_up import FACTS, changed, interval_of, record, write

ALPHA = "glass[count=4] mean 8x6 effects=requested ssaa=2"
BETA = "glass[count=4] peel[layers=8] 8x6 effects=requested ssaa=2"
"""The two cells."""
Change = Callable[[Record], Record]


def write_run(folder: Path) -> Path:
    """Write the results of both cells, and return the folder."""
    return write(folder, [record("mean"), record("peel[layers=8]")])


def write_changed(before: Path, change: Change, renderer: str = "softly") -> Path:
    """Write `now` beside the folder `before`; the first cell differs by `change`."""
    gl = Renderer(renderer)
    records = [change(record("mean", gl=gl)), record("peel[layers=8]", gl=gl)]
    facts = msgspec.structs.replace(FACTS, gl=gl)
    return write(before.parent / "now", records, facts)


def compared(before: Path, change: Change, renderer: str = "softly") -> Comparison:
    """Compare a run whose first cell was changed."""
    return oitbench.compare(write_changed(before, change, renderer), before)


def field(path: str, value: Any) -> Change:
    """Return the change of one field."""
    return lambda item: cast(Record, changed(item, path, value))


def exact(name: str, value: float | None) -> Change:
    """Return the change of one metric against the exact method."""
    return field(f"outcome.scores.exact.metrics.{name}", value)


slower = field("time.method_ms", interval_of([8.5, *[9.0] * 7, 9.5]))

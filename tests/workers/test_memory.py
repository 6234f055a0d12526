"""The memory that a process uses."""

from __future__ import annotations

import subprocess
import sys

SCRIPT = """
from oitbench.workers import memory
block = bytearray(b"1") * 2**28
print(memory.resident(), end=" ")
del block
print(memory.resident(), memory.peak())
"""


def test_memory_that_was_freed_counts_for_the_peak_alone() -> None:
    found = subprocess.run(
        [sys.executable, "-c", SCRIPT], capture_output=True, text=True, check=True
    )
    full, freed, peak = map(int, found.stdout.split())
    assert freed < full - 2**27
    assert peak >= full - 2**20

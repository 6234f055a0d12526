"""The guard: committed values of every method, every effect and every parameter value.

`tests/pictures.json` holds block means of the truth's and of all methods' pictures of tiny scenes,
so that a change which moves truth and method together is noticed too. `tests/baseline.json` holds
metrics and counts of a small matrix.

    python -m tests.guard                    print what changed, and rewrite both files
    python -m tests.guard check [CELLS]      stop at the first picture that changed

CELLS is a file with the names of cells, one a line; by default, all are checked.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path
from tempfile import TemporaryDirectory

from oitbench.errors import UsageError
from oitbench.gl.device import Device
from oitbench.matrix.plan import plan_matrix
from oitbench.matrix.run import run_matrix
from oitbench.plugins import Collection
from oitbench.results import baseline, comparison
from oitbench.results.baseline import Snapshot
from tests.pictures import committed
from tests.pictures.cells import Cell, cells
from tests.pictures.render import Pictures, means_of, pictures

BASELINE = Path(__file__).with_name("baseline.json")
SCENES = ("smoke_ball[detail=0.1]", "layer_stack")
_SHARED = ("exact.rmse_lin", "fragments", "memory.bytes", "traffic.bytes")
"""Fields that every cell of a baseline must have."""


def run(out: Path, scenes: Sequence[str] = SCENES, methods: Sequence[str] = ()) -> None:
    """Render small images of these scenes. Default: all methods with their default parameters."""
    run_matrix(plan_matrix(scenes, methods, "guard", ssaa=1, out=out, workers=2))


def sound(snapshot: Snapshot, path: Path) -> Snapshot:
    """Return a baseline if it can show a regression in each of its cells.

    Raises
    ------
    UsageError
        It has no cell, or one that failed or lacks a metric or a count.
    """
    if not snapshot.rows:
        raise UsageError(f"{path} has no cell; run python -m tests.guard")
    for cell, row in snapshot.rows.items():
        if row["status"] not in ("ok", "unstable"):
            raise UsageError(f"{path}: {cell} is {row['status']}; repair it before it is committed")
        for field in _SHARED:
            if row.get(field) is None:
                raise UsageError(f"{path}: {cell} has no {field}; run python -m tests.guard")
    return snapshot


def first_change(chosen: Sequence[Cell]) -> str | None:
    """Return the first of these cells whose picture differs from the committed one, or None."""
    before = committed.read()
    with Device() as device:
        for cell, means in means_of(device, chosen):
            name = str(cell)
            now = Pictures(device.renderer, {name: means})
            was = Pictures(before.renderer, {k: v for k, v in before.means.items() if k == name})
            for line in committed.differences(now, was).values():
                return f"{name} {line}"
    return None


def rewrite() -> None:
    """Print all differences from the committed values by cell, and rewrite both files."""
    found = pictures(cells(Collection.load()))
    try:
        changed = committed.differences(found, committed.read())
    except UsageError as error:
        print(error)  # the first time, or after a change of the format
    else:
        for name, line in changed.items():
            print(f"{name} {line}")
        print(f"{len(changed)} of {len(found.means)} pictures differ")
    committed.write(found)
    print(f"{committed.FILE}: {len(found.means)} cells")
    before = baseline.read(BASELINE) if BASELINE.is_file() else None
    with TemporaryDirectory() as folder:
        run(Path(folder))
        now = sound(baseline.read(folder), BASELINE)
        if before is not None:
            compared = comparison.compare_snapshots(now, before)
            for item in compared.differences:
                print(f"{item.verdict}: {item.cell} {item.field}", item.before, "->", item.now)
            print(compared)
        baseline.save(folder, BASELINE)
    print(f"{BASELINE}: {len(now.rows)} cells")


def check(names: Path | None) -> int:
    """Check pictures until the first one that changed; return the exit code."""
    chosen = cells(Collection.load())
    if names is not None:
        wanted = names.read_text(encoding="utf-8").splitlines()
        rank = {name: k for k, name in enumerate(wanted)}
        chosen = sorted((c for c in chosen if str(c) in rank), key=lambda c: rank[str(c)])
    change = first_change(chosen)
    print(change or f"{len(chosen)} pictures are as committed")
    return int(change is not None)


def main(arguments: Sequence[str]) -> int:
    """Run the command line; see above."""
    if not arguments:
        rewrite()
        return 0
    if arguments[0] != "check" or len(arguments) > 2:
        print(__doc__)
        return 2
    return check(Path(arguments[1]) if len(arguments) == 2 else None)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))

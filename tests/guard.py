"""A small matrix of all methods and its baseline. `python -m tests.guard` rewrites the baseline."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from tempfile import TemporaryDirectory

from oitbench.matrix.plan import plan_matrix
from oitbench.matrix.run import run_matrix
from oitbench.results import baseline, comparison

BASELINE = Path(__file__).with_name("baseline.json")
SCENES = (
    "fragment_lists[width=128,height=128]",
    "glass_bars",
    "smoke_ball[detail=0.1]",
    "layer_stack",
)


def run(out: Path, scenes: Sequence[str] = SCENES, methods: Sequence[str] = ()) -> None:
    """Render small images of these scenes. Default: all methods with their default parameters."""
    run_matrix(plan_matrix(scenes, methods, "guard", ssaa=1, out=out, workers=2))


def main() -> None:
    """Rewrite the baseline, and print its differences from the previous one."""
    before = baseline.read(BASELINE) if BASELINE.is_file() else None
    with TemporaryDirectory() as folder:
        run(Path(folder))
        now = baseline.save(folder, BASELINE)
    print(f"{BASELINE}: {len(now.rows)} cells")
    if before is not None:
        compared = comparison.compare_snapshots(now, before)
        for item in compared.differences:
            print(f"{item.verdict}: {item.cell} {item.field}", item.before, "->", item.now)
        print(compared)


if __name__ == "__main__":
    main()

"""Writes the file of a frozen suite from this checkout; a suite that has a name never changes.

python -m oitbench.suites.freezing oitbench-2
"""

from __future__ import annotations

import argparse
from collections.abc import Iterable, Sequence
from pathlib import Path

from oitbench.errors import UsageError
from oitbench.matrix import picture
from oitbench.matrix.plan import PRESETS
from oitbench.method.ablation import REQUESTED
from oitbench.places import Places, own_folder
from oitbench.shading import DEFAULT
from oitbench.suites.describing import Describer, opened
from oitbench.suites.description import Suite, SuiteScene, suite_file, write_suite
from oitbench.suites.digests import probe_metrics
from oitbench.truths import TRUTHS
from oitbench.views import MAIN

SIZE, SSAA = (256, 256), 2
"""The size of the stored references. Rendering others takes hours, and differs by machine."""
MOST_TRIANGLES = 1_000_000
"""Scenes with more have over fifteen triangles for each pixel: all of them alias."""
PERMUTATIONS = 16
"""Orders of the draws, as in the first suite."""
_TIMING = PRESETS["standard"]
_DIGITS = 6


def freeze(
    name: str,
    scenes: Iterable[str],
    size: tuple[int, int] = SIZE,
    ssaa: int = SSAA,
    truths: Sequence[str] = tuple(TRUTHS),
    collections: Sequence[Path] = (),
) -> Suite:
    """Return a suite of scenes as they are now.

    Parameters
    ----------
    name : str
    scenes : iterable of str
        Canonical labels. Those that are too heavy are left out.
    size, ssaa, truths
        As those of a cell.
    collections : sequence of path
        Folders of further collections.

    Raises
    ------
    UsageError
        A scene can be traced, but has no reference that fits it.
    OitbenchError
        A scene cannot be built or rendered.
    """
    with opened((own_folder(), *collections)) as describer:
        found = [
            _freeze_scene(describer, label, size, ssaa, truths, collections) for label in scenes
        ]
    return Suite(
        name, size, ssaa, REQUESTED, list(truths), 1, PERMUTATIONS, [MAIN],
        DEFAULT.values, _TIMING.rounds, _TIMING.budget, probe_metrics(),
        [scene for scene in found if scene is not None],
    )  # fmt: skip


def _freeze_scene(
    describer: Describer,
    label: str,
    size: tuple[int, int],
    ssaa: int,
    truths: Sequence[str],
    collections: Sequence[Path],
) -> SuiteScene | None:
    found = describer.describe(label, MAIN, size, ssaa, truths)
    if found.triangles > MOST_TRIANGLES:
        print(f"{label}: left out, {found.triangles} triangles", flush=True)
        return None
    # Fragment lists have no triangles, and cannot be traced.
    if found.missing and found.triangles:
        raise UsageError(f"{label}: {'; '.join(found.missing.values())}")
    image, _ = picture.render(label, found.truth, size, ssaa, collections=collections)
    print(label, flush=True)
    colors: list[float] = image.mean(axis=(0, 1), dtype="f8").tolist()
    mean = [float(f"{value:.{_DIGITS}g}") for value in colors]
    return SuiteScene(
        label, MAIN, found.fingerprint, found.effects, found.ranked_by, found.exposure, mean,
        found.references,
    )  # fmt: skip


def main() -> None:
    """Freeze all scenes of the suite's own collection under a new name."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("name")
    name = parser.parse_args().name
    path = suite_file(name)
    if path.exists():
        parser.error(f"{path} exists, and a suite never changes; give another name")
    suite = freeze(name, Places((own_folder(),)).scenes)
    write_suite(path, suite)
    print(f"{path}: {len(suite.scenes)} scenes")


if __name__ == "__main__":
    main()

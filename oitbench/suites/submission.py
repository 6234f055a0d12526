"""Whether a results folder is complete, unmodified and of a frozen suite."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from oitbench.errors import UsageError
from oitbench.image import metrics, stored
from oitbench.image.files import read_exr
from oitbench.parameters import natural
from oitbench.results.records import Results
from oitbench.results.schema import Outcome, Record
from oitbench.results.store import CELLS, RUN, damaged_lines, read_run
from oitbench.shading import read_shading
from oitbench.suites.description import Suite, SuiteScene
from oitbench.suites.digests import different_metrics, pixel_digest, probe_metrics, same_value
from oitbench.truths import EXACT

RADIANCE = 0.01
"""Relative difference of the mean of an exact picture that renderers may cause."""
_USABLE = ("ok", "unstable", "skipped")
"""A method may be unstable, and a machine may lack a capability: both are results."""
Watch = Callable[[Sequence[Record]], Iterable[Record]]


@dataclass(frozen=True)
class Fault:
    """What is missing or wrong; scene and method are empty if it is about the whole folder."""

    scene: str
    method: str
    reason: str


@dataclass(frozen=True)
class Verdict:
    """The result of a check.

    Parameters
    ----------
    cells : int
        Cells of the suite in the folder.
    methods : tuple of str
    faults : tuple of Fault
    """

    cells: int
    methods: tuple[str, ...]
    faults: tuple[Fault, ...]


def check(folder: Path, suite: Suite, watch: Watch = iter) -> Verdict:
    """Check a results folder against a suite.

    Parameters
    ----------
    folder : Path
    suite : Suite
    watch : callable
        Wraps the cells, to show progress.

    Raises
    ------
    UsageError
        The folder holds no results, those of several renderers, or of another version of the suite;
        or the metrics of this checkout are not those of the suite, so that they cannot be checked.
    """
    different = different_metrics(suite.metrics, probe_metrics())
    if different:
        raise UsageError(f"this checkout cannot check {suite.name}: {different[0]}")
    results = Results.load(folder)
    scenes = {(scene.scene, scene.view): scene for scene in suite.scenes}
    methods = tuple(sorted({record.method for record in results.records}, key=natural))
    faults = [Fault("", "", reason) for reason in (*_of_folder(folder), *_mixed(results.records))]
    known = {record.key for record in results.records}
    faults += [
        Fault(scene.seen, method, "missing")
        for method in methods
        for scene in suite.scenes
        if suite.key(scene, method) not in known
    ]
    truths: dict[str, str] = {}
    cells = 0
    for record in watch(results.records):
        scene = scenes.get((record.scene, record.view))
        reasons = [*_foreign(record, scene, suite)]
        cells += not reasons
        if not reasons and scene is not None:
            reasons = [*_wrong(record, scene, suite, folder, truths)]
        faults += [Fault(record.seen, record.method, reason) for reason in reasons]
    return Verdict(cells, methods, tuple(faults))


def _of_folder(folder: Path) -> Iterator[str]:
    lines = damaged_lines(folder / CELLS)
    if lines:
        yield f"{CELLS}: line {', '.join(map(str, lines))} changed or is damaged"
    if read_run(folder / RUN) is None:
        yield f"{RUN} is missing, changed or damaged"


def _mixed(records: Sequence[Record]) -> Iterator[str]:
    """Yield what is not the same in all cells, or in all cells of a method."""
    finished = [record for record in records if record.finished and record.fingerprints]
    for part in ("engine", "metrics"):
        if len({getattr(record.fingerprints, part) for record in finished}) > 1:
            yield f"cells of different versions of the {part}; run all with one version"
    if len({record.gl for record in finished}) > 1:
        yield "cells of different renderers; give the folder of one"
    found: dict[str, set[str]] = {}
    for record in finished:
        assert record.fingerprints is not None
        found.setdefault(record.method, set()).add(record.fingerprints.method)
    for method, prints in found.items():
        if len(prints) > 1:
            yield f"cells of different versions of {method}; run all with one version"


def _foreign(record: Record, scene: SuiteScene | None, suite: Suite) -> Iterator[str]:
    """Yield why a cell is none of the suite."""
    if scene is None:
        yield "the suite has no such scene"
        return
    wanted = suite.key(scene, record.method)
    for name in ("size", "ssaa", "effects", "shading"):
        found, needed = getattr(record, name), getattr(wanted, name)
        if found != needed:
            yield f"{name} {_text(found)}, not {_text(needed)}"


def _wrong(
    record: Record, scene: SuiteScene, suite: Suite, folder: Path, truths: dict[str, str]
) -> Iterator[str]:
    """Yield what is wrong with a cell of the suite.

    Parameters
    ----------
    truths : dict of str to str
        Why the pictures of truths are wrong, or "", by their files; methods share them.
    """
    if record.status not in _USABLE:
        yield f"{record.status}: {record.reason}"
        return
    if record.fingerprints is None or record.fingerprints.scene != scene.fingerprint:
        yield "the scene was another one"
        return
    for name in ("seed", "permutations", "truths"):
        found, needed = getattr(record, name), getattr(suite, name)
        if found != needed:
            yield f"{name} {_text(found)}, not {_text(needed)}"
    if record.outcome is None:
        return
    yield from _wrong_outcome(record.outcome, scene, suite)
    if record.time is None:
        yield "it has no time"
    elif (record.time.block.rounds, record.time.block.budget) != (suite.rounds, suite.budget):
        yield f"timed in other rounds, not {suite.rounds} in {suite.budget:g} s"
    damaged = [*_damaged(record.outcome, folder)]
    yield from damaged
    if not damaged:
        yield from _wrong_truths(record.outcome, scene, folder, truths)
        yield from _wrong_values(record.outcome, folder)


def _wrong_outcome(outcome: Outcome, scene: SuiteScene, suite: Suite) -> Iterator[str]:
    if outcome.effects.requested != scene.effects:
        yield "the scene requested other effects"
    if outcome.exposure != scene.exposure:
        yield f"exposure {outcome.exposure:g}, not {scene.exposure:g}"
    settings = read_shading(",".join(suite.shading_texts)).values
    shared = outcome.shading.settings
    if any(settings.get(name) != value for name, value in shared.items()):
        yield "other settings of shared shading"


def _damaged(outcome: Outcome, folder: Path) -> Iterator[str]:
    for image in outcome.images.values():
        try:
            stored.verify(folder, image)
        except UsageError as error:
            yield str(error)


def _wrong_truths(
    outcome: Outcome, scene: SuiteScene, folder: Path, truths: dict[str, str]
) -> Iterator[str]:
    for truth in (EXACT, *scene.references):
        image = outcome.images.get(truth)
        if image is None:
            yield f"no picture of the truth {truth}"
            continue
        if image.path not in truths:
            pixels = read_exr(folder / image.path)
            if truth == EXACT:
                mean = pixels.mean(axis=(0, 1), dtype=np.float64)
                same = bool(np.allclose(mean, scene.exact, rtol=RADIANCE, atol=1e-4))
                reason = "exact compositing has another mean radiance"
            else:
                same = pixel_digest(pixels) == scene.references[truth]
                reason = f"the {truth} reference was another one"
            truths[image.path] = "" if same else reason
        if truths[image.path]:
            yield truths[image.path]


def _wrong_values(outcome: Outcome, folder: Path) -> Iterator[str]:
    """Yield the metrics that are not those of the pictures."""
    test = read_exr(folder / outcome.images["color"].path)
    for truth, scores in outcome.scores.items():
        if truth not in outcome.images:
            continue
        reference = read_exr(folder / outcome.images[truth].path)
        found = metrics.compare(reference, test, outcome.exposure).values
        for name, value in found.items():
            if not same_value(scores.metrics.get(name), value):
                yield f"{name} against {truth} is not that of the pictures"


def _text(value: object) -> str:
    if isinstance(value, tuple):
        return "x".join(map(str, value))
    if isinstance(value, list):
        return ", ".join(map(str, value))
    return str(value) or "default"

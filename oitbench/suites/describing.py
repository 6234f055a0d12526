"""What this checkout has of a suite, and where it differs."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from oitbench.errors import OitbenchError
from oitbench.suites.description import Suite, SuiteScene
from oitbench.suites.digests import different_metrics, probe_metrics
from oitbench.suites.worker import DescribeScene, SceneDescribed, Settings
from oitbench.truths import EXACT
from oitbench.workers import memory
from oitbench.workers.process import Process

_SECONDS = 600.0


class Describer:
    """Describes scenes in a worker process; `opened` makes one.

    Parameters
    ----------
    process : Process
    """

    def __init__(self, process: Process) -> None:
        self._process = process

    def describe(
        self, scene: str, view: str, size: tuple[int, int], ssaa: int, truths: Sequence[str]
    ) -> SceneDescribed:
        """Return what there is of a view of a scene.

        Raises
        ------
        OitbenchError
            The scene is unknown, or cannot be built.
        """
        traced = [truth for truth in truths if truth != EXACT]
        request = DescribeScene(scene, view, size, ssaa, traced)
        return self._process.ask(request, SceneDescribed, _SECONDS, retry=True)


@contextmanager
def opened(collections: Sequence[Path]) -> Iterator[Describer]:
    """Yield a describer of the scenes in some collection folders."""
    settings = Settings(list(collections))
    limit = memory.share(1)
    with Process("oitbench.suites.worker", settings, SceneDescribed, limit) as process:
        yield Describer(process)


def differences(suite: Suite, collections: Sequence[Path]) -> Iterator[str]:
    """Yield a line for everything of a suite that is different in this checkout."""
    yield from different_metrics(suite.metrics, probe_metrics())
    with opened(collections) as describer:
        for scene in suite.scenes:
            try:
                found = describer.describe(
                    scene.scene, scene.view, suite.size, suite.ssaa, suite.truths
                )
            except OitbenchError as error:
                yield f"the scene {scene.seen}: {error}"
                continue
            yield from _different(scene, found)


def _different(frozen: SuiteScene, found: SceneDescribed) -> Iterator[str]:
    owner = f"the scene {frozen.seen}"
    if found.fingerprint != frozen.fingerprint:
        yield f"{owner} has changed"
        return  # Its references then are others, too.
    if found.effects != frozen.effects:
        yield f"{owner} requests other effects"
    if found.ranked_by != frozen.ranked_by:
        yield f"{owner} is ranked by {found.ranked_by}, not {frozen.ranked_by}"
    for truth, digest in frozen.references.items():
        if truth in found.missing:
            yield f"the {truth} reference of {frozen.seen} is missing: {found.missing[truth]}"
        elif found.references[truth] != digest:
            yield f"the {truth} reference of {frozen.seen} has changed"

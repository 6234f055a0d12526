"""Statistics of scenes, measured in a process of its own, as a table."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

from oitbench.catalog.catalog import Catalog, Choice
from oitbench.errors import OitbenchError
from oitbench.measure.worker import MeasureScene, Reply, SceneMeasured
from oitbench.results.statistics import SceneStatistics
from oitbench.workers.process import Process

SCENE_SECONDS = 600.0
"""Time in which a scene must be built, and each of its views counted, by default."""
_HEADING = (
    "scene", "view", "objects", "triangles", "transparent", "draws", "fragments", "covered",
    "mean", "median", "worst", "effects",
)  # fmt: skip


@dataclass(frozen=True)
class SceneView:
    """One view of a scene; a scene that could not be measured has only an `error`."""

    scene: str
    view: str = ""
    effects: tuple[str, ...] = ()
    statistics: SceneStatistics | None = None
    error: str = ""


def survey(
    catalog: Catalog,
    scenes: Iterable[Choice],
    size: tuple[int, int],
    memory_limit: int,
    timeout: float | None = SCENE_SECONDS,
) -> Iterator[SceneView]:
    """Measure the statistics of all views of scenes, one scene after another.

    A scene that cannot be measured, or ends the process, costs only its own row.

    Parameters
    ----------
    catalog : Catalog
    scenes : iterable of Choice
    size : (int, int)
        Width and height in pixels.
    memory_limit : int
        Bytes that the process may use.
    timeout : float, optional
        Seconds for building a scene, and for each view. None: no limit.
    """
    files = catalog.places.files()
    with Process("oitbench.measure.worker", files, Reply, memory_limit) as worker:
        for choice in scenes:
            if choice.error:
                yield SceneView(choice.label, error=choice.error)
                continue
            try:
                found = worker.ask(MeasureScene(choice.label, size), SceneMeasured, timeout)
            except OitbenchError as error:
                yield SceneView(choice.label, error=str(error))
                continue
            for view, statistics in found.views.items():
                yield SceneView(choice.label, view, tuple(found.effects), statistics)


def table(rows: Sequence[SceneView], size: tuple[int, int]) -> str:
    """Return the statistics as a Markdown table; `covered` is in percent of the pixels."""
    lines = [f"| {' | '.join(_HEADING)} |", f"|{' --- |' * len(_HEADING)}"]
    lines += [f"| {' | '.join(_cells(row, size))} |" for row in rows if row.statistics is not None]
    return "\n".join(lines) + "\n"


def _cells(row: SceneView, size: tuple[int, int]) -> list[str]:
    found = row.statistics
    assert found is not None
    complexity = found.complexity
    counts = (
        found.objects, found.triangles, found.transparent_triangles, found.draws, found.fragments,
    )  # fmt: skip
    none = "–"
    return [
        f"`{row.scene}`",
        row.view,
        *(f"{count:,}" for count in counts),
        f"{100 * found.covered_pixels / (size[0] * size[1]):.1f} %",
        none if complexity.mean is None else f"{complexity.mean:.1f}",
        none if complexity.median is None else f"{complexity.median:g}",
        f"{complexity.worst}",
        ", ".join(row.effects),
    ]


def facts(row: SceneView, size: tuple[int, int]) -> dict[str, Any]:
    """Return a row for programs."""
    import msgspec

    statistics = None if row.statistics is None else msgspec.to_builtins(row.statistics)
    return {
        "scene": row.scene,
        "view": row.view,
        "size": list(size),
        "effects": list(row.effects),
        "statistics": statistics,
        "error": row.error,
    }

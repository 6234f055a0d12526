"""The error that the noise of path tracing causes, over the time of tracing, for all scenes."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from oitbench.errors import OitbenchError
from oitbench.image import metrics
from oitbench.image.files import Image
from oitbench.image.ties import Metric
from oitbench.path_traced.references.storage import FOLDER, read, read_manifest
from oitbench.plugins import Collection
from oitbench.report import error_axis, figures, multiples
from oitbench.report.artifacts import Figure
from oitbench.report.context import ReportContext
from oitbench.results.ranking import largest_noise_floor
from oitbench.results.records import Panel
from oitbench.truths import TRACED, TRUTHS

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.lines import Line2D

_COUNTS = (1, 2, 4)
"""Numbers of parts whose error is measured."""
_LAW = 8
"""The expected line begins at this fraction of the time."""
_CAPTION = (
    "The error that the noise of a traced picture causes, over the seconds of tracing it. Matched "
    "tracing: after 1, 2, 4 and all 8 of its independent parts, as far as they are stored; full "
    "path tracing: as it is used. Dotted: an error that falls with the square root of the time, as "
    "RMSE does; FLIP falls more slowly. A truth without noise is one mark below the break. The "
    "seconds are those of the machine that traced the reference; another one may have measured the "
    "methods, which therefore have axes of their own."
)


@dataclass(frozen=True)
class Curve:
    """The error of a traced truth by its seconds.

    Parameters
    ----------
    truth : str
    random : bool
        Whether it has noise.
    points : tuple of (float, float)
        Seconds and FLIP, in ascending order; the last one is the truth as it is used.
    """

    truth: str
    random: bool
    points: tuple[tuple[float, float], ...]

    @property
    def expected(self) -> tuple[tuple[float, float], ...]:
        """The ends of the line on which the error falls with the square root of the time."""
        seconds, error = self.points[-1]
        first = seconds / _LAW, error * math.sqrt(_LAW)
        return (first, (seconds, error)) if self.random else ()


def draw(context: ReportContext, panels: Sequence[Panel]) -> Figure | None:
    """Draw a pane for each scene with a traced truth; return None if there is none."""
    places = _stored()
    found = {panel.title: list(curves(context, panel, places)) for panel in panels}
    shown = {title: known for title, known in found.items() if known}
    if not shown:
        return None
    points = [
        (x, error_axis.place(y))
        for known in shown.values()
        for curve in known
        for x, y in (*curve.points, *curve.expected)
    ]
    return multiples.small_multiples(
        [partial(_draw_pane, title=title, curves=known) for title, known in shown.items()],
        points,
        _handles(),
        context.out / "answer-tracing",
        x="time of tracing, s (logarithmic)",
        metric=context.flip_name,
        title="Error of path tracing over its time, all scenes",
        caption=_CAPTION,
    )


def curves(
    context: ReportContext, panel: Panel, places: Mapping[str, tuple[Path, str]]
) -> Iterator[Curve]:
    """Yield the curves of a panel.

    Parameters
    ----------
    context : ReportContext
    panel : Panel
    places : mapping of str to (Path, str)
        Folder and key of stored references in several parts, by the digest of their rendering.
    """
    for truth in TRACED:
        for cell in panel.finished:
            facts = cell.outcome.scores[truth].reference if cell.outcome else None
            floor = largest_noise_floor([cell], truth, context.flip)
            if facts is None or floor is None or cell.outcome is None:
                continue
            digest = cell.fingerprints.truths.get(truth, "") if cell.fingerprints else ""
            parts = _parts(places[digest]) if digest in places else ()
            measure = partial(_flip, context.hdr, cell.outcome.exposure)
            counts = [count for count in _COUNTS if 2 * count <= len(parts)]
            measured = [
                (facts.seconds * count / len(parts), error_of(count, parts, measure))
                for count in counts
            ]
            yield Curve(truth, facts.random, (*measured, (facts.seconds, floor)))
            break


def _stored() -> dict[str, tuple[Path, str]]:
    """Return the places of references in several parts in the suite's collections."""
    found = {}
    for folder in Collection.load().folders:
        try:
            manifest = read_manifest(folder / FOLDER)
        except OitbenchError:
            continue  # damaged; a run says so
        for key, info in manifest.items():
            if len(info.parts) > 1:
                found[info.rendering.digest] = folder / FOLDER, key
    return found


def _parts(place: tuple[Path, str]) -> Sequence[Image]:
    try:
        reference = read(*place)
    except OitbenchError:
        return ()
    return () if reference is None else reference.parts


def _flip(hdr: bool, exposure: float, image: Image, truth: Image) -> float:
    measure = metrics.flip_hdr if hdr else metrics.flip_ldr
    return measure(truth, image, exposure) or 0.0


def error_of(count: int, parts: Sequence[Image], metric: Metric) -> float:
    """Return the error that the mean of `count` parts has by its noise.

    With the means A and B of two disjoint sets of `count` parts, and the mean M of all parts,
    M + (A − B)/√2 varies around M as A does.

    Parameters
    ----------
    count : int
        At most half of the parts.
    parts : sequence of array, shape (h, w, 3)
        Independent pictures.
    metric : Metric
        Maps an image and the truth to an error.
    """
    stacked = np.stack(parts).astype(np.float64)
    one, other = stacked[:count].mean(axis=0), stacked[count : 2 * count].mean(axis=0)
    mean = stacked.mean(axis=0)
    moved = mean + (one - other) / math.sqrt(2)
    return metric(moved.astype(np.float32), mean.astype(np.float32))


def _draw_pane(axes: Axes, title: str, curves: Sequence[Curve]) -> None:
    for curve in curves:
        xs, ys = zip(*curve.points, strict=True)
        axes.plot(xs, [error_axis.place(y) for y in ys], **figures.truth_mark(curve.truth))
        if curve.expected:
            xs, ys = zip(*curve.expected, strict=True)
            places = [error_axis.place(y) for y in ys]
            axes.plot(xs, places, color=figures.QUIET, linewidth=0.8, linestyle=":", zorder=1.5)
    axes.set_title(title, fontsize=7, pad=3)


def _handles() -> list[Line2D]:
    from matplotlib.lines import Line2D

    marks = [Line2D([], [], **figures.truth_mark(truth), label=TRUTHS[truth]) for truth in TRACED]
    law = Line2D([], [], color=figures.QUIET, linewidth=0.8, linestyle=":", label="1 / √time")
    return [*marks, law]

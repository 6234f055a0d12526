"""Times of all methods, and of two A-buffers on a logarithmic axis of their own.

OSMT and FOMT build their maps from lists (V) or in fixed memory (F). The A-buffers compose
iteratively, searching for the next layer each time, or after sorting. In the power plant, AT and ST
also have four samples per pixel. Times are those of the method alone, without shared shading.
"""

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from oitbench.papers import Album, Finding, Picture, caption, needs_of, read_paper
from oitbench.report import Artifact, Note, ReportContext, decimal, figures, times
from oitbench.results.times import Time

if TYPE_CHECKING:
    from matplotlib.axes import Axes

title = "Times of methods"

PAPER = read_paper(Path(__file__).parent / "papers" / "at2011.toml")
BOUNDED = ("alpha blending", "AT", "ST", "OSMT", "FOMT", "OSMTF", "FOMTF")
BUFFERS = ("recursive", "iterative")
NAMES = {"OSMT": "OSMTV", "FOMT": "FOMTV"}
SCENES: Mapping[str, Sequence[str]] = {
    "HAIR": BOUNDED + BUFFERS,
    "FOREST": BOUNDED + BUFFERS,
    "SMOKE": BOUNDED + BUFFERS,
    "PWRPLANT": ("AT", "AT 4×", "ST", "ST 4×"),
}
PICTURES = {
    (scene, method): PAPER.picture(scene, method)
    for scene, methods in SCENES.items()
    for method in methods
}
needs = needs_of(PICTURES.values())


def build(context: ReportContext) -> list[Artifact]:
    """Draw the bars of all scenes beside those of the A-buffers."""
    album = Album(context, needs)
    found = {place: time for place, picture in PICTURES.items() if (time := _time(album, picture))}
    if not found:
        return [Note("No cell of this figure has been timed yet.")]
    with figures.canvas(figures.WIDTH, 4.4) as canvas:
        left, right = canvas.subplots(1, 2, width_ratios=(25, 7))
        _draw(context, left, found, [place for place in PICTURES if place[1] not in BUFFERS])
        _draw(context, right, found, [place for place in PICTURES if place[1] in BUFFERS])
        left.set(ylabel="method time, ms")
        right.set(yscale="log", ylabel="A-buffers, ms (logarithmic)", ylim=_decades(found))
        right.yaxis.set_major_formatter("{x:,g}")
        shown = f"Median times on {context.results.renderer}. {times.SHORT_EXPLANATION}."
        text = caption(album, shown, _findings(found))
        path = context.out / "at_figure07"
        return [figures.save(canvas, path, title=title, caption=text)]


def _time(album: Album, picture: Picture) -> Time | None:
    record = album.record(picture)
    return record.time if record else None


def _decades(found: Mapping[tuple[str, str], Time]) -> tuple[float, float]:
    """Return the powers of ten around the times of the A-buffers."""
    medians = [
        time.method_ms.median for (_, method), time in found.items() if method in BUFFERS
    ] or [1.0]
    return 10 ** _floor(min(medians)), 10 ** (_floor(max(medians)) + 1)


def _floor(value: float) -> int:
    return int(f"{value:e}".partition("e")[2])


def _draw(
    context: ReportContext,
    axes: "Axes",
    found: Mapping[tuple[str, str], Time],
    places: Sequence[tuple[str, str]],
) -> None:
    """Draw one bar for each place, with a gap between scenes."""
    x = 0.0
    ticks: dict[float, str] = {}
    scenes: dict[str, list[float]] = {}
    before = places[0][0]
    for place in places:
        x += 1 if place[0] == before else 2
        before = place[0]
        ticks[x] = NAMES.get(place[1], place[1])
        scenes.setdefault(before, []).append(x)
        time = found.get(place)
        if time is None:
            continue
        color = context.style(PICTURES[place].method).color
        median, ends = time.method_ms.median, time.method_ms.ends
        axes.bar(x, median, color=color, width=0.8)
        if ends:
            apart = [[median - ends[0]], [ends[1] - median]]
            axes.errorbar(x, median, apart, color=figures.INK, linewidth=0.8)
        axes.annotate(
            times.signed(decimal(median), time.block.disturbed), (x, ends[1] if ends else median),
            xytext=(0, 2), textcoords="offset points", fontsize=6, rotation=90,
            horizontalalignment="center", verticalalignment="bottom",
        )  # fmt: skip
    axes.set_xticks([*ticks], [*ticks.values()], rotation=90, fontsize=7)
    axes.margins(y=0.15)
    for scene, positions in scenes.items():
        middle = (positions[0] + positions[-1]) / 2
        axes.annotate(
            scene, (middle, 0), xycoords=("data", "axes fraction"), xytext=(0, -62),
            textcoords="offset points", fontsize=7.5, horizontalalignment="center",
            annotation_clip=False,
        )  # fmt: skip


def _findings(found: Mapping[tuple[str, str], Time]) -> Iterator[Finding]:
    for scene in ("HAIR", "FOREST", "SMOKE"):
        for slow, least, text in (
            ("recursive", 5, "at least 5 times as fast as the A-buffer"),
            ("ST", 1, "faster than ST"),
        ):
            pair = found.get((scene, "AT")), found.get((scene, slow))
            sentence = f"in {scene}, AT is {text}"
            if pair[0] is None or pair[1] is None:
                yield Finding(sentence, None)
                continue
            ratio = pair[1].method_ms.median / pair[0].method_ms.median
            yield Finding(f"{sentence} ({decimal(ratio)} times)", ratio >= least)

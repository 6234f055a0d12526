"""Bytes that a frame moves, against its transparent fragments, as at 1280 × 720 pixels.

VRB are lists of all fragments, which adaptive transparency and both kinds of maps share. ST16 has
16 samples, and AT8 keeps 8 nodes in fixed memory, which it reads and writes for each fragment.
Bytes are those of the declared formats, without caches and compression, as in the paper. Dots are
scenes here; a line is their best fit.
"""

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from oitbench.papers import Album, Finding, Picture, caption, needs_of, read_paper
from oitbench.report import Artifact, Note, ReportContext, decimal, figures

title = "Memory traffic and fragments"

PAPER = read_paper(Path(__file__).parent / "papers" / "at2011.toml")
TECHNIQUES = {
    "VRB": ("adaptive", "adaptive[msaa=4]"),
    "ST16": ("stochastic", "stochastic[msaa=4]"),
    "AT8": ("adaptive[memory=fixed]", "adaptive[memory=fixed,msaa=4]"),
}
COLORS = {"VRB": "#0072B2", "ST16": "#D55E00", "AT8": "#009E73"}
SCENES = [found.scene for found in PAPER.scenes.values()]
PICTURES = {
    (name, samples): [Picture(scene, label) for scene in SCENES]
    for name, labels in TECHNIQUES.items()
    for samples, label in zip((1, 4), labels, strict=True)
}
needs = needs_of(picture for pictures in PICTURES.values() for picture in pictures)
PIXELS, MANY = 1280 * 720, 10e6
"""Size of the paper's frame, and fragments in it at which techniques are compared."""
ABOUT = 0.2
"""Relative difference of numbers that are about the same."""


def build(context: ReportContext) -> list[Artifact]:
    """Draw a line for each technique, with one and four samples per pixel."""
    album = Album(context, needs)
    points = {key: _points(album, pictures) for key, pictures in PICTURES.items()}
    # A line needs two numbers of fragments.
    lines = {key: np.polyfit(*found, 1) for key, found in points.items() if len({*found[0]}) > 1}
    if not lines:
        return [Note("The results have fewer than two scenes of this figure.")]
    end = max(max(found[0]) for found in points.values() if found[0])
    with figures.canvas(6.0, 3.6) as canvas:
        axes = canvas.subplots()
        for (name, samples), line in lines.items():
            color, look = COLORS[name], "-" if samples == 1 else "--"
            x = np.array([0, end])
            axes.plot(
                x / 1e6, np.polyval(line, x) / 1e9, look, color=color, label=_label(name, samples)
            )
            xs, ys = points[name, samples]
            axes.plot(
                np.array(xs) / 1e6, np.array(ys) / 1e9, "o", color=color, markersize=4,
                markerfacecolor=color if samples == 1 else "white",
            )  # fmt: skip
        axes.set(
            xlabel="transparent fragments of a frame of 1280 × 720, millions",
            ylabel="GB per frame",
            xlim=(0, None),
            ylim=(0, None),
        )
        axes.grid(True)
        axes.legend(loc="upper left")
        text = caption(album, "Dots: SMOKE, HAIR, FOREST and PWRPLANT.", _findings(lines))
        path = context.out / "at_figure10"
        return [figures.save(canvas, path, title=title, caption=text)]


def _label(name: str, samples: int) -> str:
    return name if samples == 1 else f"{name}, 4 samples per pixel"


def _points(album: Album, pictures: list[Picture]) -> tuple[list[float], list[float]]:
    """Return fragments and bytes of each scene, as if its frame had the paper's size."""
    xs: list[float] = []
    ys: list[float] = []
    for picture in pictures:
        record, outcome = album.record(picture), album.outcome(picture)
        if record is not None and outcome is not None:
            factor = PIXELS / (record.size[0] * record.size[1])
            xs.append(outcome.statistics.fragments * factor)
            ys.append(outcome.traffic.bytes * factor)
    return xs, ys


def _findings(lines: Mapping[tuple[str, int], np.ndarray]) -> list[Finding]:
    """Compare the techniques with one sample, at as many fragments as the paper's scenes have."""
    moved = {
        name: float(np.polyval(lines[name, 1], MANY)) for name in TECHNIQUES if (name, 1) in lines
    }
    least = "lists move the fewest bytes"
    alike = "AT8 moves about as many bytes as ST16"
    if len(moved) < len(TECHNIQUES):
        return [Finding(least, None), Finding(alike, None)]
    numbers = ", ".join(f"{name} {decimal(value / 1e9)} GB" for name, value in moved.items())
    at = f"{decimal(MANY / 1e6)} million fragments"
    ratio = moved["AT8"] / moved["ST16"]
    return [
        Finding(f"{least} ({numbers} at {at})", min(moved, key=moved.__getitem__) == "VRB"),
        Finding(f"{alike} ({decimal(ratio)} times)", abs(ratio - 1) <= ABOUT),
    ]

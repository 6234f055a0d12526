"""Pictures of methods in motion: a strip of frames, and flicker, popping and error over time."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from oitbench.image import files, stored
from oitbench.image.files import Image
from oitbench.image.stored import StoredImage
from oitbench.motion.metrics import BLOCK
from oitbench.motion.record import JSON, PER_FRAME, MotionFile, Pop, Track, read
from oitbench.report import figures, palette, plates
from oitbench.report.artifacts import Column, Figure, Row, Table, fixed, write_table
from oitbench.report.error_maps import magma
from oitbench.report.palette import Style
from oitbench.report.plates import GAP, MARGIN, display, draw_picture

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure as Canvas

STRIP, PLOT = "motion-strip", "motion-plot"
CHANGE = 0.25
"""Change of displayed values that is the lightest color of a map."""
_EVEN = 4
"""Frames of a strip that are evenly spaced."""
_WIDE, _ROOM, _HEADING = 0.05, 0.2, 0.34
"""Inches: gaps between frames, before the pair of frames, and the height of a heading."""
_EXACT_COLOR = "#444444"
_HIGHLIGHT = "#ff2d2d"
_COLUMNS = (
    # The run of this page may not know the method, which then has no color.
    Column("method", "Method", kind="text"),
    Column("seeds", "Seeds", kind="text", help="of random numbers: the same in all frames or not"),
    Column("verdict", "Verdict", kind="text"),
    Column("flip", "FLIP", decimals=4, help="mean over the frames, against exact compositing"),
    Column("flicker", "Flicker", decimals=4, help="mean excess change of transparent pixels"),
    Column("flicker_worst", "Worst", decimals=3, help="99.9th percentile of a transition"),
    Column("flicker_largest", "Largest", decimals=3, help="of any pixel"),
    Column("ratio", "Flicker / exact", decimals=2, help="to the mean change of exact compositing"),
    Column("rest", "At rest", decimals=4, help="mean change when only the seed changes"),
    Column("jump", "Jump", decimals=4, help="largest excess jump of a block between two frames"),
    Column("popping", "Popping", decimals=4, help="what is left of it in a 64th of the step"),
    Column("popping_exact", "Exact", decimals=4, help="change of exact compositing there"),
)


@dataclass(frozen=True)
class Footage:
    """The pictures of a folder of `oitbench motion`.

    Parameters
    ----------
    folder : Path
    found : MotionFile
    """

    folder: Path
    found: MotionFile

    @classmethod
    def load(cls, folder: Path) -> Footage:
        """Read a folder; raise `UsageError` if it holds no results of `oitbench motion`."""
        return cls(folder, read(folder / JSON))

    def shown(self, image: StoredImage) -> Image:
        """Return a displayed frame; raise `UsageError` if its file is damaged."""
        linear = files.read_exr(stored.verify(self.folder, image))
        return display(linear, self.found.exposure)

    @cached_property
    def exact(self) -> list[Image]:
        """The displayed frames of exact compositing."""
        return [self.shown(image) for image in self.found.exact]

    def frame(self, track: Track | None, number: int) -> Image:
        """Return a displayed frame of a method, or of exact compositing."""
        return self.exact[number] if track is None else self.shown(track.frames[number])

    def change(self, place: int, own: Sequence[Image] = ()) -> Image:
        """Return the absolute change of each pixel in a transition, (h, w).

        Parameters
        ----------
        place : int
        own : sequence of two arrays, optional
            Both displayed frames of a method, for its excess change. Default: the change is that
            of exact compositing.
        """
        change = self.exact[place + 1] - self.exact[place]
        if own:
            change = own[1] - own[0] - change
        spread: Image = np.abs(change).mean(axis=-1)
        return spread


def write(footage: Footage, out: Path) -> tuple[Figure, Figure, Table]:
    """Write the strip, the plot and the table of a folder.

    Parameters
    ----------
    footage : Footage
    out : Path
        Existing folder.
    """
    found = footage.found
    looks = palette.styles(
        {track.method: track.name for track in found.tracks},
        {track.name: track.family for track in found.tracks},
    )
    return (
        _strip(footage, out / STRIP),
        _plot(found, looks, out / PLOT),
        write_table(
            out / "motion-summary.csv",
            _COLUMNS,
            [_row(found, track) for track in found.tracks],
            title=f"{found.title} in motion",
            caption=_caption(found),
        ),
    )


def _caption(found: MotionFile) -> str:
    lost = "".join(f" {label}: {reason}." for label, reason in found.failed.items())
    return (
        f"{len(found.path)} frames of {found.size[0]} × {found.size[1]}, ssaa {found.ssaa}. Changes"
        " are of displayed values, less the changes of exact compositing, whose mean change is"
        f" {fixed(found.mean_change, 4)}. A method pops if a block of {BLOCK} × {BLOCK} pixels"
        " jumps by more than 1/255 in a 64th of the step, and farther than exact compositing there."
        " It flickers if its mean excess change exceeds 1/255 and the mean change of exact"
        " compositing, or if pixels change by more than 1/255 in the mean when only the seed"
        f" does.{lost}"
    )


def _row(found: MotionFile, track: Track) -> Row:
    flips = [value for value in track.flip if value is not None]
    pop = track.worst_pop
    return (
        track.method,
        track.seeds,
        ", ".join(found.verdicts(track)),
        sum(flips) / len(flips) if flips else None,
        track.mean_flicker,
        track.worst_flicker,
        max(track.largest, default=0.0),
        track.mean_flicker / found.mean_change if found.mean_change else None,
        track.rest,
        max(track.jumps, default=0.0),
        pop.popping if pop else None,
        pop.exact if pop else None,
    )


def _strip(footage: Footage, path: Path) -> Figure:
    found = footage.found
    rows: list[Track | None] = [None, *found.tracks]
    count = _EVEN + 3
    across = (figures.WIDTH - 2 * MARGIN - (count - 3) * _WIDE - 2 * _ROOM) / count
    down = across * found.size[1] / found.size[0]
    height = 2 * MARGIN + len(rows) * (_HEADING + down + GAP)
    even = np.linspace(0, len(found.path) - 1, min(_EVEN, len(found.path))).round().astype(int)
    with figures.canvas(figures.WIDTH, height, by_hand=True) as canvas:
        for number, track in enumerate(rows):
            top = MARGIN + number * (_HEADING + down + GAP) + _HEADING
            place = _transition(found, track)
            lefts = _lefts(across)
            frames = [*even.tolist(), place, place + 1]
            pictures = [footage.frame(track, frame) for frame in frames]
            places = [*lefts[: len(even)], *lefts[-3:-1]]
            for frame, picture, left in zip(frames, pictures, places, strict=True):
                draw_picture(canvas, picture, left, top, across)
                plates.write(canvas, f"{frame}", left, top - 0.03, 6.5, color=figures.QUIET)
            changed = footage.change(place, pictures[-2:] if track else ())
            draw_picture(canvas, magma(changed / CHANGE), lefts[-1], top, across)
            change = "change" if track is None else "excess change"
            plates.write(canvas, change, lefts[-1], top - 0.03, 6.5, color=figures.QUIET)
            pop = track.worst_pop if track else None
            if pop is not None and pop.pops and pop.transition == place:
                for left in lefts[-3:]:
                    _frame(canvas, left, top, across / found.size[0], pop)
            plates.write(canvas, _heading(found, track), MARGIN, top - 0.155, 8, bold=True)
        caption = (
            "Each row: evenly spaced frames, then the two frames between which the method pops, or"
            " changes most in excess of exact compositing, and that change of each pixel, from 0"
            f" (black) to {CHANGE:g} (pale yellow) of displayed values. Red: the block that pops."
        )
        return figures.save(canvas, path, title=f"{found.title} in motion", caption=caption)


def _lefts(across: float) -> list[float]:
    """Return the left edges of the pictures of a row, in inches."""
    lefts = [MARGIN + k * (across + _WIDE) for k in range(_EVEN)]
    pair = lefts[-1] + across + _ROOM
    return [*lefts, pair, pair + across + _WIDE, pair + 2 * across + _WIDE + _ROOM]


def _transition(found: MotionFile, track: Track | None) -> int:
    """Return the transition that a row shows closely."""
    if track is None:
        return int(np.argmax(found.change))
    pop = track.worst_pop
    if pop is not None and pop.pops:
        return pop.transition
    return int(np.argmax(track.flicker))


def _heading(found: MotionFile, track: Track | None) -> str:
    if track is None:
        return f"exact compositing · mean change {fixed(found.mean_change, 4)}"
    parts = [track.label, ", ".join(found.verdicts(track))]
    parts.append(f"flicker {fixed(track.mean_flicker, 4)}")
    pop = track.worst_pop
    if pop is not None and pop.pops:
        parts.append(f"a block jumps by {fixed(pop.popping, 3)}")
    return " · ".join(parts)


def _frame(canvas: Canvas, left: float, top: float, pixel: float, pop: Pop) -> None:
    """Draw the outline of the block that pops; `pixel` is the side of one in inches."""
    from matplotlib.patches import Rectangle

    whole, tall = canvas.get_size_inches()
    row, column = pop.block
    side = BLOCK * pixel
    corner = ((left + column * side) / whole, 1 - (top + (row + 1) * side) / tall)
    outline = Rectangle(
        corner, side / whole, side / tall, fill=False, edgecolor=_HIGHLIGHT, linewidth=1.0
    )
    outline.set_transform(canvas.transFigure)
    canvas.add_artist(outline)


def _plot(found: MotionFile, looks: Mapping[str, Style], path: Path) -> Figure:
    with figures.canvas(figures.WIDTH, 5.6) as canvas:
        panels: Sequence[Axes] = canvas.subplots(3, 1, sharex=True)
        between = np.arange(len(found.change)) + 0.5
        panels[0].fill_between(between, found.change, color=_EXACT_COLOR, alpha=0.15, linewidth=0)
        panels[0].plot(between, found.change, color=_EXACT_COLOR, linewidth=1.2, label="exact")
        for track in found.tracks:
            look = looks[track.method]
            flips = [np.nan if value is None else value for value in track.flip]
            series = (
                (between, track.flicker),
                (between, track.jumps),
                (np.arange(len(flips)), flips),
            )
            for axes, (x, y) in zip(panels, series, strict=True):
                axes.plot(
                    x,
                    y,
                    label=track.label if axes is panels[0] else None,
                    color=look.color,
                    linestyle=":" if track.seeds == PER_FRAME else look.line,
                    linewidth=1.2,
                )
            popping = [pop for pop in track.pops if pop.pops]
            panels[1].plot(
                [pop.transition + 0.5 for pop in popping],
                [track.jumps[pop.transition] for pop in popping],
                linestyle="none",
                marker="o",
                markersize=6,
                markerfacecolor="none",
                markeredgecolor=_HIGHLIGHT,
            )
        titles = ("mean excess change", "largest jump of a block", "FLIP to exact")
        for axes, text in zip(panels, titles, strict=True):
            axes.set_ylabel(text, fontsize=7.5)
            axes.set_ylim(bottom=0)
            axes.grid(True)
        panels[-1].set_xlabel("frame")
        panels[-1].set_xlim(0, len(found.path) - 1)
        canvas.legend(loc="outside right upper", fontsize=7)
        caption = (
            "Gray: the change of exact compositing itself. Circles: jumps that are left in a 64th"
            " of the step, which are pops. Dotted: other random numbers in each frame."
        )
        return figures.save(canvas, path, title=f"{found.title} over time", caption=caption)

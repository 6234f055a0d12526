"""What each effect costs and gains: every picture against the same without one of its effects.

Cost is what leaving the effect out saves: in frame time, in memory, in traffic, shading such as
shadow maps included. Gain is by how much the effect brings the picture nearer to the path-traced
one; within the noise floor of that one it is a tie.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from oitbench.effects import Effect, names
from oitbench.report import Artifact, Column, Figure, Note, figures, labels, palette, write_table
from oitbench.report.artifacts import Value
from oitbench.results import records as read
from oitbench.results.records import MEBIBYTE, MEGABYTE, PATH_TRACED, Ablation, Panel, Results
from oitbench.results.store import Record

if TYPE_CHECKING:
    from matplotlib.axes import Axes

title = "What each effect costs and gains"
order = 35

_RESAMPLES = 1000
_COLUMNS_OF_AXES = 3
# Inches of one scene's axes with their labels.
_WIDTH, _HEIGHT = 3.13, 2.9
# Room beside the outermost marks for their labels, as a share of what they span.
_ROOM = 0.35

Span = tuple[float, float, float]
"""A value and the two ends of its 95 % interval."""


@dataclass(frozen=True)
class Effected:
    """What one effect costs and gains with one method in one scene; None is not known.

    Parameters
    ----------
    ablation : Ablation
    label : str
        The effect's name, or several.
    milliseconds : (float, float, float), optional
        Frame time that leaving it out saves, with its 95 % interval.
    memory, traffic : float, optional
        Bytes that leaving it out saves.
    gain, floor : float, optional
        In error against the path-traced picture, and the noise floor of that one.
    """

    ablation: Ablation
    label: str
    milliseconds: Span | None
    memory: float | None
    traffic: float | None
    gain: float | None
    floor: float | None

    @property
    def verdict(self) -> str:
        """Whether the picture is nearer to the path-traced one with the effect."""
        if self.gain is None:
            return ""
        if abs(self.gain) <= (self.floor or 0.0):
            return "tie"
        return "better" if self.gain > 0 else "worse"


def build(results: Results, out: Path) -> list[Artifact]:
    """Draw gain against cost, and list both."""
    found = [(panel, effects_of(panel, results.flip)) for panel in results.panels()]
    rows = [row for panel, effects in found for row in _rows(panel, effects, results.flip)]
    if not rows:
        return [Note("No effect was left out of a picture; 'oitbench run --effects each' does it.")]
    drawn: list[Artifact] = []
    shown = [(p, kept) for p, effects in found if (kept := [e for e in effects if _point(e)])]
    if shown:
        drawn.append(_figure(results, shown, out))
    else:
        drawn.append(Note("No effect has both a cost in time and a gain yet."))
    return [*drawn, _table(rows, results.flip, out)]


def effects_of(panel: Panel, flip: str) -> list[Effected]:
    """Return what is known of every effect that was left out of a finished cell."""
    return [
        _effected(ablation, flip)
        for ablation in panel.ablations
        if {ablation.complete["status"], ablation.without["status"]} <= read.FINISHED
    ]


def _effected(ablation: Ablation, flip: str) -> Effected:
    complete, without = ablation.complete, ablation.without
    memory, traffic = (
        _difference(*(read.shaded_total(cell, account) for cell in (complete, without)))
        for account in ("memory", "traffic")
    )
    gain = _difference(*(read.metric(cell, PATH_TRACED, flip) for cell in (without, complete)))
    label, floor = ", ".join(ablation.named), read.noise_floor(complete, flip)
    return Effected(ablation, label, saved_time(complete, without), memory, traffic, gain, floor)


def _difference(minuend: float | None, subtrahend: float | None) -> float | None:
    return None if minuend is None or subtrahend is None else minuend - subtrahend


def saved_time(complete: Record, without: Record, seed: int = 1) -> Span | None:
    """Return the difference of both median frame times in milliseconds, with its interval.

    The interval is the bootstrap's from all samples. Where a record tells no samples, the
    medians' own intervals are added in quadrature, as those of independent errors are.
    """
    one, other = read.frame_time(complete), read.frame_time(without)
    if one is None or other is None:
        return None
    saved = one[0] - other[0]
    samples = [
        np.asarray(cell["time"]["frame_ms"].get("samples") or ()) for cell in (complete, without)
    ]
    if all(len(values) for values in samples):
        generator = np.random.default_rng(seed)
        chosen = [generator.choice(values, (_RESAMPLES, len(values))) for values in samples]
        medians = [np.median(values, axis=1) for values in chosen]
        low, high = np.percentile(medians[0] - medians[1], [2.5, 97.5])
        return saved, min(float(low), saved), max(float(high), saved)
    below = math.hypot(one[0] - one[1], other[2] - other[0])
    above = math.hypot(one[2] - one[0], other[0] - other[1])
    return saved, saved - below, saved + above


def _point(effect: Effected) -> tuple[float, float] | None:
    """Return (cost in milliseconds, gain), or None."""
    if effect.milliseconds is None or effect.gain is None:
        return None
    return effect.milliseconds[0], effect.gain


# -- figure ------------------------------------------------------------------------------------


def _figure(results: Results, shown: Sequence[tuple[Panel, list[Effected]]], out: Path) -> Figure:
    columns = min(_COLUMNS_OF_AXES, len(shown))
    lines = math.ceil(len(shown) / columns)
    chosen = {panel.slug: _labelled(effects, results.flip) for panel, effects in shown}
    with figures.canvas(_WIDTH * columns, _HEIGHT * lines) as figure:
        grid = figure.subplots(lines, columns, squeeze=False)
        places = list(grid.flat)
        for axes in places[len(shown) :]:
            axes.remove()
        for axes, (panel, effects) in zip(places, shown, strict=False):
            _draw(axes, panel, effects, chosen[panel.slug])
            axes.set_xlabel("cost, ms a frame")
            axes.set_ylabel(f"gain in {results.flip}")
        for axes, (panel, effects) in zip(places, shown, strict=False):
            _write_labels(axes, effects, chosen[panel.slug])
        methods = ", ".join(dict.fromkeys(chosen.values()))
        caption = (
            "Each mark is one effect: right, it costs frame time (bars: 95 % interval); up, it "
            "brings the picture nearer to the path-traced one. Shaded: ties, within its noise. "
            f"Filled and named: the method that misses the fewest of a scene's effects "
            f"({methods}); hollow: other methods."
        )
        return figures.save(
            figure, out / "ablation", title="Gain in accuracy against cost", caption=caption
        )


def _labelled(effects: Sequence[Effected], flip: str) -> str:
    """Return the method whose marks are named."""
    chosen = read.fullest((effect.ablation.complete for effect in effects), flip)
    return "" if chosen is None else str(chosen["method"])


def _method(effect: Effected) -> str:
    return str(effect.ablation.complete["method"])


def _colors() -> dict[str, str]:
    """Return the color of every effect, the same whichever a run leaves out."""
    known = [read.effect_label(name) for name in names(~Effect.NONE)]
    return {
        name: style.color
        for name, style in palette.styles(dict(zip(known, known, strict=True))).items()
    }


def _draw(axes: Axes, panel: Panel, effects: Sequence[Effected], chosen: str) -> None:
    axes.set_title(panel.title)
    axes.grid(True, axis="both")
    colors = _colors()
    for effect in effects:
        point, span = _point(effect), effect.milliseconds
        if point is None or span is None:
            continue
        color, filled = colors.get(effect.label, figures.QUIET), _method(effect) == chosen
        axes.errorbar(
            *point,
            xerr=[[span[0] - span[1]], [span[2] - span[0]]] if filled else None,
            marker="o",
            markersize=7 if filled else 5,
            color=color,
            markerfacecolor=color if filled else "none",
            markeredgecolor="white" if filled else color,
            markeredgewidth=0.6 if filled else 0.9,
            elinewidth=1,
            capsize=2,
            zorder=4 if filled else 3,
        )
    _draw_ties(axes, max((effect.floor or 0.0 for effect in effects), default=0.0))
    _limit(axes, effects)


def _draw_ties(axes: Axes, floor: float) -> None:
    axes.axhline(0, color=figures.QUIET, linewidth=0.8, zorder=1.5)
    axes.axvline(0, color=figures.QUIET, linewidth=0.8, zorder=1.5)
    if floor:
        axes.axhspan(-floor, floor, color="#000000", alpha=0.07, linewidth=0)
        axes.annotate(
            f"shaded: ties, within {floor:.2g}",
            (1, 0),
            xycoords="axes fraction",
            xytext=(-3, 3),
            textcoords="offset points",
            fontsize=7,
            color=figures.QUIET,
            horizontalalignment="right",
        )


def _limit(axes: Axes, effects: Sequence[Effected]) -> None:
    """Show all marks and zero, with room for labels."""
    gains = [point[1] for effect in effects if (point := _point(effect))]
    ends = [end for effect in effects if effect.milliseconds for end in effect.milliseconds]
    left, right = min(0.0, *ends), max(0.0, *ends)
    bottom, top = min(0.0, *gains), max(0.0, *gains)
    wide, tall = right - left or 1.0, top - bottom or 1.0
    axes.set_xlim(left - _ROOM / 2 * wide, right + _ROOM * wide)
    axes.set_ylim(bottom - _ROOM * tall, top + _ROOM / 2 * tall)


def _write_labels(axes: Axes, effects: Sequence[Effected], chosen: str) -> None:
    colors = _colors()
    written = [
        labels.Label(
            *point,
            effect.label,
            palette.ink(colors.get(effect.label, figures.QUIET)),
            *effect.milliseconds[1:],
            bold=effect.verdict != "tie",
        )
        for effect in effects
        if _method(effect) == chosen and effect.milliseconds and (point := _point(effect))
    ]
    others = [
        point for effect in effects if _method(effect) != chosen and (point := _point(effect))
    ]
    labels.place(axes, written, lines=[((x, x), (y, y)) for x, y in others])


# -- table -------------------------------------------------------------------------------------


def _rows(panel: Panel, effects: Sequence[Effected], flip: str) -> Iterator[tuple[Value, ...]]:
    for effect in effects:
        complete, without = effect.ablation.complete, effect.ablation.without
        yield (
            panel.title,
            complete["method"],
            effect.label,
            ", ".join(effect.ablation.implied),
            *(effect.milliseconds or (None, None, None)),
            None if effect.memory is None else effect.memory / MEBIBYTE,
            None if effect.traffic is None else effect.traffic / MEGABYTE,
            read.metric(complete, PATH_TRACED, flip),
            read.metric(without, PATH_TRACED, flip),
            effect.gain,
            effect.floor,
            effect.verdict,
        )


def _table(rows: Sequence[tuple[Value, ...]], flip: str, out: Path) -> Artifact:
    columns = (
        Column("scene", "Scene", kind="text"),
        Column("method", "Method", kind="method"),
        Column("left_out", "Left out", kind="text"),
        Column("with_it", "with it", kind="text", help="means nothing without it, so it goes too"),
        Column("saved_ms", "Saves", "ms", help="difference of the median frame times"),
        Column("saved_ms_low", "low", "ms", help="lower end of its 95 % interval"),
        Column("saved_ms_high", "high", "ms", help="upper end of its 95 % interval"),
        Column("saved_mib", "Memory", "MiB", help="that it saves, shading included"),
        Column("saved_mb", "Traffic", "MB", help="that it saves, shading included; 10^6 bytes"),
        Column(f"with.{flip}", "FLIP with", decimals=4, help=f"{flip} to path traced"),
        Column(f"without.{flip}", "without", decimals=4, help=f"{flip} to path traced"),
        Column(f"gain.{flip}", "Gain", decimals=4, help="above zero: better with the effect"),
        Column(f"noise_floor.{flip}", "noise floor", decimals=4, help="gains below it are ties"),
        Column("verdict", "With it", kind="text"),
    )
    caption = (
        "What leaving one effect out saves, and what the effect gains in error against the "
        "path-traced picture. A saving below zero is a cost; small ones are the timer's noise, as "
        "their intervals tell."
    )
    return write_table(
        out / "ablation.csv", columns, rows, title="Costs and gains by effect", caption=caption
    )

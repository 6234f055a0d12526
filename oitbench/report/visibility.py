"""Visibility curves as data and as a figure: one panel per method, over the exact curve."""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from oitbench.method.families import SORTING
from oitbench.report import palette
from oitbench.report.artifacts import Figure, decimal, write_csv, writing_to
from oitbench.report.figures import QUIET, canvas, save

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from oitbench.measure.visibility import Curves

Floats = npt.NDArray[np.float64]

NAME = "visibility"
_COLUMNS = 4
_PANEL = (2.45, 1.8)
_HIGHEST = 1.6
_CHANGE = 1e-3
"""A smaller step of visibility is not seen in the figure."""
_SORTED = "each fragment is sorted here;\na picture sorts its draws"
_EXACT_COLOR = "#444444"
_HEADING = (
    "method",
    "fragment",
    "z_m",
    "coverage",
    *(f"{name}_{c}" for name in ("transmission", "visibility", "error") for c in "rgb"),
)


def write(curves: Curves, folder: Path, name: str = NAME) -> Figure:
    """Write `NAME.csv`, `.json`, `.png` and `.pdf` into `folder`.

    Parameters
    ----------
    curves : Curves
    folder : Path
    name : str
        Of the files.

    Raises
    ------
    UsageError
        If the folder cannot be written to.
    """
    with writing_to(folder):
        write_csv(folder / f"{name}.csv", _HEADING, _rows(curves))
        text = json.dumps(_facts(curves), indent=1, allow_nan=False)
        (folder / f"{name}.json").write_text(text + "\n", encoding="utf-8")
        return _draw(curves, folder / name)


def _all(curves: Curves) -> dict[str, Floats]:
    return {"exact": curves.exact, **curves.methods}


def _rows(curves: Curves) -> Iterator[list[object]]:
    """Yield the rows of the CSV file: all fragments of each curve, then the light behind them."""
    fragments = curves.fragments
    for label, values in _all(curves).items():
        numbers = np.concatenate([values, values - curves.exact], axis=1)
        for place, row in enumerate(_finite(numbers[:-1])):
            yield [
                label,
                place,
                fragments.z[place, 0, 0],
                fragments.coverage[place, 0, 0],
                *fragments.transmission[place, 0, 0],
                *row,
            ]
        yield [label, "behind", "", "", "", "", "", *_finite(numbers[-1:])[0]]


def _facts(curves: Curves) -> dict[str, object]:
    fragments = curves.fragments
    return {
        "scene": curves.scene,
        "pixel": list(curves.pixel),
        "size": list(curves.size),
        "fragments": {
            "z": fragments.z[:, 0, 0].tolist(),
            "coverage": fragments.coverage[:, 0, 0].tolist(),
            "radiance": fragments.radiance[:, 0, 0].tolist(),
            "transmission": fragments.transmission[:, 0, 0].tolist(),
        },
        "visibility": {label: _finite(values) for label, values in _all(curves).items()},
        "standard_error": {label: _finite(values) for label, values in curves.noise.items()},
        "not_measured": curves.reasons,
    }


def _finite(values: Floats) -> list[list[float | None]]:
    """Return the rows of an array, with None for values that are not finite."""
    return [[value if math.isfinite(value) else None for value in row] for row in values.tolist()]


def _draw(curves: Curves, path: Path) -> Figure:
    panels: dict[str, list[str]] = {}
    for label in curves.methods:
        panels.setdefault(curves.names[label], []).append(label)
    columns = min(_COLUMNS, max(1, len(panels)))
    rows = max(1, math.ceil(len(panels) / columns))
    with canvas(max(4.0, _PANEL[0] * columns), _PANEL[1] * rows + 0.6) as figure:
        grid = figure.subplots(rows, columns, sharex=True, sharey=True, squeeze=False).ravel()
        styles = palette.styles(curves.names, curves.families)
        for axes, (name, labels) in zip(grid, panels.items(), strict=False):
            _draw_panel(axes, curves, labels, styles)
            axes.set_title(name, fontsize=8, color=palette.ink(styles[labels[0]].color))
        for axes in grid[len(panels) :]:
            axes.set_visible(False)
        grid[0].set_ylim(0, _top(curves.methods.values()))
        grid[0].set_xlim(*extent(curves))
        figure.supxlabel("view distance, m", fontsize=8)
        figure.supylabel("visibility, mean of the channels", fontsize=8)
        where = f"pixel {curves.pixel[0]}, {curves.pixel[1]} of {curves.size[0]} × {curves.size[1]}"
        count = len(curves.fragments.z)
        last = f"{decimal(float(curves.fragments.z[-1, 0, 0]))} m"
        title = f"{curves.scene}, {where}, {count} fragments up to {last}; gray: exact compositing"
        figure.suptitle(title, fontsize=8, color=QUIET)
        return save(figure, path, title="Visibility", caption=title)


def _draw_panel(
    axes: Axes, curves: Curves, labels: Sequence[str], styles: Mapping[str, palette.Style]
) -> None:
    """Draw the curves of methods that differ only in parameters, over the exact curve."""
    z = curves.fragments.z[:, 0, 0].astype(np.float64)
    axes.step(
        *steps(z, curves.exact),
        where="pre",
        color=_EXACT_COLOR,
        linewidth=2.6,
        alpha=0.35,
        label="exact",
    )
    for label in labels:
        style, drawn = styles[label], steps(z, curves.methods[label])
        axes.step(
            *drawn, where="pre", color=style.color, linestyle=style.line, linewidth=1.2, label=label
        )
    if curves.families.get(curves.names[labels[0]]) == SORTING:
        axes.text(
            0.03, 0.04, _SORTED, transform=axes.transAxes, fontsize=5.5, color=QUIET,
            verticalalignment="bottom",
        )  # fmt: skip
    if len(labels) > 1:
        axes.legend(fontsize=5.5, frameon=False, loc="upper right")


def extent(curves: Curves) -> tuple[float, float]:
    """Return the view distances between which a curve changes, with a margin.

    A last fragment far behind would squeeze all that is to be seen.
    """
    z = curves.fragments.z[:, 0, 0].astype(np.float64)
    changed = np.zeros(len(z), dtype=np.bool_)
    for values in _all(curves).values():
        mean = values.mean(axis=1)
        # A fragment that covers nothing has no value; its light is that behind it.
        last = len(mean) - 1
        places = np.where(np.isfinite(mean), np.arange(len(mean)), last)
        known = np.minimum.accumulate(places[::-1])[::-1]
        changed |= np.abs(np.diff(mean[known])) > _CHANGE
    changes = np.flatnonzero(changed)
    end = z[changes[-1]] if len(changes) else z[-1]
    margin = max(0.06 * (end - z[0]), 1e-3 * end)
    return float(z[0] - margin), float(end + margin)


def steps(z: Floats, values: Floats) -> tuple[Floats, Floats]:
    """Return a curve's view distances and its visibility, averaged over the channels.

    The visibility between two layers is that of the farther one, so each step is at the nearer one.
    """
    margin = max(0.04 * (z[-1] - z[0]), 1e-3 * z[-1])
    mean = values.mean(axis=1)
    x = np.concatenate([[z[0] - margin], z, [z[-1] + margin]])
    y = np.concatenate([mean[:1], mean])
    kept = np.isfinite(y)
    return x[kept], y[kept]


def _top(values: Iterable[Floats]) -> float:
    """Return the upper end of the axis: 1, or more for methods that exceed 1, up to a limit."""
    peaks = [float(np.nanmax(item.mean(axis=1))) for item in values]
    return min(_HIGHEST, max([1.0, *peaks])) * 1.05

"""Visibility curves as data and as a figure: one panel a method, over the exact curve."""

from __future__ import annotations

import csv
import json
import math
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from oitbench.errors import UsageError
from oitbench.report import palette
from oitbench.report.artifacts import Figure
from oitbench.report.figures import QUIET, canvas, save

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from oitbench.measure.visibility import Curves

NAME = "visibility"
_COLUMNS = 4
_PANEL = (2.45, 1.8)
_HIGHEST = 1.6
_CHANNELS = "rgb"


def write(curves: Curves, folder: Path, known: Iterable[str] = ()) -> Figure:
    """Write `visibility.csv`, `.json`, `.png` and `.pdf` into `folder`.

    Parameters
    ----------
    curves : Curves
    folder : Path
    known : iterable of str
        Names of all methods that there are, from which each one's color follows.

    Raises
    ------
    UsageError
        If the folder cannot be written to.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        _write_csv(curves, folder / f"{NAME}.csv")
        text = json.dumps(_facts(curves), indent=1, allow_nan=False)
        (folder / f"{NAME}.json").write_text(text + "\n", encoding="utf-8")
        return _draw(curves, folder, known)
    except OSError as error:
        raise UsageError(
            f"{folder} cannot be written to ({error.strerror}); give -o DIR"
        ) from error


def _all(curves: Curves) -> dict[str, npt.NDArray[np.float64]]:
    return {"exact": curves.exact, **curves.methods}


def _write_csv(curves: Curves, path: Path) -> None:
    fragments = curves.fragments
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(
            ["method", "fragment", "z_m", "coverage"]
            + [f"{name}_{c}" for name in ("transmission", "visibility", "error") for c in _CHANNELS]
        )
        for label, values in _all(curves).items():
            for place, (z, coverage, transmission) in enumerate(
                zip(
                    fragments.z[:, 0, 0],
                    fragments.coverage[:, 0, 0],
                    fragments.transmission[:, 0, 0],
                    strict=True,
                )
            ):
                error = values[place] - curves.exact[place]
                head = [label, place, z, coverage, *transmission]
                writer.writerow(head + [_cell(value) for value in (*values[place], *error)])
            behind = [*values[-1], *(values[-1] - curves.exact[-1])]
            writer.writerow([label, "behind", "", "", "", "", "", *map(_cell, behind)])


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
        "visibility": {label: _rows(values) for label, values in _all(curves).items()},
        "standard_error": {label: _rows(values) for label, values in curves.noise.items()},
        "not_measured": curves.reasons,
    }


def _rows(values: npt.NDArray[np.float64]) -> list[list[float | None]]:
    return [[_cell(value) for value in row] for row in values]


def _cell(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None


def _draw(curves: Curves, folder: Path, known: Iterable[str]) -> Figure:
    styles = palette.styles(curves.names, known)
    panels: dict[str, list[str]] = {}
    for label in curves.methods:
        panels.setdefault(curves.names[label], []).append(label)
    columns = min(_COLUMNS, max(1, len(panels)))
    rows = max(1, math.ceil(len(panels) / columns))
    z = curves.fragments.z[:, 0, 0].astype(np.float64)
    with canvas(max(4.0, _PANEL[0] * columns), _PANEL[1] * rows + 0.6) as figure:
        grid = figure.subplots(rows, columns, sharex=True, sharey=True, squeeze=False).ravel()
        for axes, name in zip(grid, panels, strict=False):
            _step(axes, z, curves.exact, palette.TRUTH_COLOR, "-", 2.6, 0.35, "exact")
            for label in panels[name]:
                style = styles[label]
                _step(axes, z, curves.methods[label], style.color, style.line, 1.2, 1.0, label)
            axes.set_title(name, fontsize=8, color=palette.ink(styles[panels[name][0]].color))
            if len(panels[name]) > 1:
                axes.legend(fontsize=5.5, frameon=False, loc="upper right")
        for axes in grid[len(panels) :]:
            axes.set_visible(False)
        grid[0].set_ylim(0, _top(curves.methods.values()))
        figure.supxlabel("view distance (m)", fontsize=8)
        figure.supylabel("visibility", fontsize=8)
        where = f"pixel {curves.pixel[0]}, {curves.pixel[1]} of {curves.size[0]} × {curves.size[1]}"
        title = f"{curves.scene}, {where}: {len(z)} fragments; grey is exact"
        figure.suptitle(title, fontsize=8, color=QUIET)
        return save(figure, folder / NAME, title="Visibility", caption=title)


def _step(
    axes: Axes,
    z: npt.NDArray[np.float64],
    values: npt.NDArray[np.float64],
    color: str,
    line: str,
    width: float,
    opacity: float,
    label: str,
) -> None:
    """Draw the mean over channels: what reaches the eye from each depth, up to the next layer."""
    margin = max(0.04 * (z[-1] - z[0]), 1e-3 * z[-1])
    mean = values.mean(axis=1)
    # Between two layers visibility is that of the farther one: the step lies at the nearer.
    x = np.concatenate([[z[0] - margin], z, [z[-1] + margin]])
    y = np.concatenate([mean[:1], mean])
    kept = np.isfinite(y)
    axes.step(
        x[kept], y[kept], where="pre", color=color, linestyle=line, linewidth=width,
        alpha=opacity, label=label,
    )  # fmt: skip


def _top(values: Iterable[npt.NDArray[np.float64]]) -> float:
    """Return the upper end of the axis: one, or more where methods go beyond, within reason."""
    peaks: Sequence[float] = [float(np.nanmax(item.mean(axis=1))) for item in values]
    return min(_HIGHEST, max([1.0, *peaks])) * 1.05

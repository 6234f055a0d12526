"""What each method moves per frame: bytes by pass, resource and kind of access.

The bytes are algorithmic (no caches, no compression): bytes per item of the declared formats times
items that were measured, not guessed.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from oitbench.report import Artifact, Column, Figure, Note, decimal, figures, palette, write_table
from oitbench.report.artifacts import Value
from oitbench.results import records as read
from oitbench.results.records import MEGABYTE, Panel, Results
from oitbench.results.store import Record

if TYPE_CHECKING:
    from matplotlib.axes import Axes

title = "Memory traffic"
order = 50

_COLUMNS = (
    Column("scene", "Scene", kind="text"),
    Column("method", "Method", kind="method"),
    Column("pass", "Pass", kind="text"),
    Column("resource", "Resource", kind="text"),
    Column("kind", "Access", kind="text"),
    Column("items", "Items"),
    Column("bytes_per_item", "per item", "B"),
    Column("bytes", "Bytes"),
)
_KIND_COLORS = ("#56B4E9", "#D55E00", "#0072B2", "#E69F00", "#009E73", "#CC79A7")
_LETTER_SHARE = 0.0092
_ROW_HEIGHT = 0.235


def build(results: Results, out: Path) -> list[Artifact]:
    """Draw a figure per scene and list all terms."""
    drawn: list[Artifact] = []
    rows: list[tuple[Value, ...]] = []
    colors = _kind_colors(results)
    for panel in results.panels():
        cells = [cell for cell in panel.finished if read.total(cell, "traffic") is not None]
        if not cells:
            drawn.append(Note(f"{panel.title}: no cell has told its traffic yet."))
            continue
        drawn.append(_figure(panel, cells, colors, out))
        rows += [row for cell in cells for row in _rows(panel, cell)]
    if rows:
        drawn.append(
            write_table(
                out / "traffic.csv",
                _COLUMNS,
                rows,
                title="All terms",
                caption="Every total above is the sum of its terms: items × bytes per item.",
                collapsed=True,
            )
        )
    return drawn or [Note("There is no cell yet.")]


def _kind_colors(results: Results) -> dict[str, str]:
    """Give each kind of access one color in all figures."""
    kinds = {term["kind"] for cell in results.records for term in read.terms(cell, "traffic")}
    return {
        kind: _KIND_COLORS[place % len(_KIND_COLORS)] for place, kind in enumerate(sorted(kinds))
    }


def _rows(panel: Panel, cell: Record) -> list[tuple[Value, ...]]:
    return [
        (
            panel.title,
            cell["method"],
            term["pass"],
            term["resource"],
            term["kind"],
            term.get("items"),
            term.get("bytes_per_item"),
            term["bytes"],
        )
        for term in read.terms(cell, "traffic")
    ]


def _figure(panel: Panel, cells: list[Record], colors: dict[str, str], out: Path) -> Figure:
    from matplotlib.patches import Patch

    largest = max(read.total(cell, "traffic", MEGABYTE) or 0.0 for cell in cells) or 1.0
    kinds = {term["kind"] for cell in cells for term in read.terms(cell, "traffic")}
    with figures.canvas(9.4, 1.0 + _ROW_HEIGHT * len(cells)) as figure:
        axes = figure.subplots()
        axes.grid(True, axis="x")
        for row, cell in enumerate(cells):
            _draw_bar(axes, cell, row, largest, colors)
        axes.set_yticks(range(len(cells)), [cell["method"] for cell in cells])
        axes.set_ylim(len(cells) - 0.4, -0.6)
        axes.set_xlim(0, 1.16 * largest)
        axes.set_xlabel("traffic per frame, MB (10⁶ bytes)")
        figures.quiet_axis(axes)
        figure.legend(
            handles=[Patch(color=colors[kind], label=kind) for kind in sorted(kinds)],
            loc="outside upper left",
            ncols=max(1, len(kinds)),
            handlelength=1,
            columnspacing=1.6,
        )
        caption = (
            "Bytes read and written per frame, without caches or compression. Each block is one "
            "pass, divided by kind of access; the number is the total."
        )
        path = out / f"traffic-{panel.slug}"
        return figures.save(figure, path, title=panel.title, caption=caption)


def _draw_bar(axes: Axes, cell: Record, row: int, largest: float, colors: dict[str, str]) -> None:
    """Draw one bar: passes in order, each divided by kind and separated by a white line."""
    passes: dict[str, dict[str, float]] = {}
    for term in read.terms(cell, "traffic"):
        kinds = passes.setdefault(str(term["pass"]), {})
        kinds[term["kind"]] = kinds.get(term["kind"], 0.0) + term["bytes"] / MEGABYTE
    start = 0.0
    for name, kinds in passes.items():
        widest = max(kinds, key=lambda kind: kinds[kind])
        for kind, amount in kinds.items():
            axes.barh(row, amount, left=start, height=0.72, color=colors[kind])
            room = _LETTER_SHARE * 1.16 * largest * (len(name) + 2)
            if kind == widest and amount > room:
                axes.text(
                    start + amount / 2,
                    row,
                    name,
                    fontsize=6.5,
                    color="white" if palette.is_dark(colors[kind]) else figures.INK,
                    horizontalalignment="center",
                    verticalalignment="center_baseline",
                )
            start += amount
        axes.plot([start, start], [row - 0.36, row + 0.36], color="white", linewidth=1.5)
    axes.annotate(
        f"{decimal(read.total(cell, 'traffic', MEGABYTE) or 0.0)} MB",
        (start, row),
        xytext=(4, 0),
        textcoords="offset points",
        fontsize=7.5,
        verticalalignment="center_baseline",
    )

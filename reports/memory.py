"""What each method keeps in memory: its declared targets and buffers, stacked by resource."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from oitbench.report import Artifact, Column, Figure, Note, decimal, figures, palette, write_table
from oitbench.report.artifacts import Value
from oitbench.results import records as read
from oitbench.results.records import MEBIBYTE, Panel, Results
from oitbench.results.store import Record

if TYPE_CHECKING:
    from matplotlib.axes import Axes

title = "Memory"
order = 40

_COLUMNS = (
    Column("scene", "Scene", kind="text"),
    Column("method", "Method", kind="method"),
    Column("resource", "Resource", kind="text"),
    Column("bytes", "Bytes"),
    Column("mib", "Memory", "MiB"),
    Column("bits_per_pixel", "per pixel", "bit"),
)
# A segment carries its name if it is at least this share of the axis per letter.
_LETTER_SHARE = 0.0092
_ROW_HEIGHT = 0.235


def build(results: Results, out: Path) -> list[Artifact]:
    """Draw a figure per scene and list all resources."""
    drawn: list[Artifact] = []
    rows: list[tuple[Value, ...]] = []
    for panel in results.panels():
        cells = [cell for cell in panel.finished if read.total(cell, "memory") is not None]
        if not cells:
            drawn.append(Note(f"{panel.title}: no cell has told its memory yet."))
            continue
        drawn.append(_figure(results, panel, cells, out))
        rows += [row for cell in cells for row in _rows(panel, cell)]
    if rows:
        drawn.append(
            write_table(
                out / "memory.csv",
                _COLUMNS,
                rows,
                title="All resources",
                caption="From the methods' declarations; bits per pixel of the picture.",
                collapsed=True,
            )
        )
    return drawn or [Note("There is no cell yet.")]


def _bits_per_pixel(panel: Panel, count: float) -> float:
    return 8 * count / (panel.size[0] * panel.size[1])


def _rows(panel: Panel, cell: Record) -> list[tuple[Value, ...]]:
    return [
        (
            panel.title,
            cell["method"],
            term["resource"],
            int(term["bytes"]),
            term["bytes"] / MEBIBYTE,
            _bits_per_pixel(panel, term["bytes"]),
        )
        for term in read.terms(cell, "memory")
    ]


def _figure(results: Results, panel: Panel, cells: list[Record], out: Path) -> Figure:
    largest = max(read.total(cell, "memory", MEBIBYTE) or 0.0 for cell in cells) or 1.0
    with figures.canvas(9.4, 0.75 + _ROW_HEIGHT * len(cells)) as figure:
        axes = figure.subplots()
        axes.grid(True, axis="x")
        for row, cell in enumerate(cells):
            _draw_bar(axes, results, panel, cell, row, largest)
        axes.set_yticks(range(len(cells)), [cell["method"] for cell in cells])
        axes.set_ylim(len(cells) - 0.4, -0.6)
        # Room at the right for the total of the longest bar.
        axes.set_xlim(0, 1.3 * largest)
        axes.set_xlabel("memory, MiB")
        figures.quiet_axis(axes)
        caption = (
            "Declared targets and buffers of each method, in the order of declaration; at the end "
            "of each bar the total and its bits per pixel of the picture."
        )
        return figures.save(
            figure, out / f"memory-{panel.slug}", title=panel.title, caption=caption
        )


def _draw_bar(
    axes: Axes, results: Results, panel: Panel, cell: Record, row: int, largest: float
) -> None:
    """Draw one stacked bar in tints of the method's color."""
    color = results.style(cell["method"]).color
    terms = read.terms(cell, "memory")
    start = 0.0
    for place, term in enumerate(terms):
        width = term["bytes"] / MEBIBYTE
        tint = palette.mix(color, "#ffffff", 0.62 * place / max(1, len(terms) - 1))
        axes.barh(row, width, left=start, height=0.72, color=tint, edgecolor="white", linewidth=0.8)
        if width > _LETTER_SHARE * 1.3 * largest * (len(term["resource"]) + 2):
            axes.text(
                start + width / 2,
                row,
                term["resource"],
                fontsize=6.5,
                color="white" if palette.is_dark(tint) else figures.INK,
                horizontalalignment="center",
                verticalalignment="center_baseline",
            )
        start += width
    count = read.total(cell, "memory") or 0.0
    text = f"{decimal(count / MEBIBYTE)} MiB   {_bits_per_pixel(panel, count):,.0f} bit/px"
    axes.annotate(
        text if count else "nothing beyond the picture",
        (start, row),
        xytext=(4, 0),
        textcoords="offset points",
        fontsize=7.5,
        verticalalignment="center_baseline",
    )

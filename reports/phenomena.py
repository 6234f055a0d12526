"""Phenomena of transparency: what methods make of them, beside the path-traced picture.

The maps show FLIP against the path-traced picture on the magma scale from 0 (black) to 1.
"""

from __future__ import annotations

from pathlib import Path

from oitbench.image.files import Image
from oitbench.report import Artifact, Figure, Note, Tile, figures, fixed, plates
from oitbench.report.plates import Shown
from oitbench.results import records as read
from oitbench.results.records import PATH_TRACED, TRUTHS, Panel, Results
from oitbench.results.store import Record

title = "Phenomena"
order = 32

_COVERAGE, _DIFFUSION = "COVERAGE", "DIFFUSION"
# Inches: a picture as wide as the page, and the room for its label.
_WIDTH = 9.24
_LABEL = 0.24


def build(results: Results, out: Path) -> list[Artifact]:
    """Draw the plates of every scene that calls for more than coverage."""
    drawn: list[Artifact] = []
    for panel in results.panels():
        if _called(panel) - {_COVERAGE}:
            drawn += _plates(results, panel, out)
    return drawn or [Note("No scene of this run calls for more than coverage.")]


def _called(panel: Panel) -> set[str]:
    return {effect for cell in panel.finished for effect in read.called_effects(cell)}


def _plates(results: Results, panel: Panel, out: Path) -> list[Artifact]:
    truth = plates.first_image(results, panel.finished, PATH_TRACED)
    drawn: list[Artifact] = [_methods(results, panel, truth, out)]
    diffusing = [
        cell
        for cell in panel.finished
        if _DIFFUSION in read.called_effects(cell) and _DIFFUSION not in read.missing_effects(cell)
    ]
    chosen = read.fullest(diffusing, results.flip)
    if chosen is not None and truth is not None:
        drawn += _pair(results, panel, truth, chosen, out)
    varied = [ablation.complete for ablation in panel.ablations]
    chosen = read.fullest((c for c in varied if c["status"] in read.FINISHED), results.flip)
    if chosen is not None:
        drawn.append(_variants(results, panel, chosen, truth, out))
    return drawn


def _methods(results: Results, panel: Panel, truth: Image | None, out: Path) -> Artifact:
    """Return the plate of all methods, under all effects that the scene calls for."""
    folder = out / "phenomena" / panel.slug
    shown = [_truth(results, panel, truth, folder)]
    for cell in panel.finished:
        called, missing = read.called_effects(cell), read.missing_effects(cell)
        told = f"misses {len(missing)} of {len(called)} effects" if missing else "all effects"
        shown.append(_cell(results, cell, cell["method"], (told,), truth, folder))
    effects = ", ".join(
        read.effect_label(effect) for effect in read.called_effects(panel.finished[0])
    )
    caption = (
        f"The scene calls for {effects}. Beneath each picture its {results.flip} against the "
        "path-traced one, from 0 (black) to 1 (pale yellow), and the mean."
    )
    path = out / f"phenomena-{panel.slug}"
    return plates.grid(results, panel, shown, path, title=panel.title, caption=caption)


def _variants(
    results: Results, panel: Panel, complete: Record, truth: Image | None, out: Path
) -> Artifact:
    """Return the plate of one method with effects left out."""
    folder = out / "phenomena" / f"{panel.slug}-variants"
    shown = [
        _truth(results, panel, truth, folder),
        _cell(results, complete, "all effects", (), truth, folder),
    ]
    gone = []
    for ablation in panel.ablations:
        if ablation.complete is complete:
            label = f"without {', '.join(ablation.named)}"
            shown.append(_cell(results, ablation.without, label, (), truth, folder))
            if ablation.implied:
                implied = " and ".join(ablation.implied)
                gone.append(f"{label.capitalize()}, {implied} would mean nothing: left out too.")
    caption = " ".join(
        [
            f"{complete['method']} with effects left out. Beneath each picture its {results.flip}"
            " against the path-traced one, and the mean.",
            *gone,
        ]
    )
    return plates.grid(
        results,
        panel,
        shown,
        out / f"phenomena-{panel.slug}-variants",
        title=f"{panel.title}: one effect less",
        caption=caption,
    )


def _truth(results: Results, panel: Panel, truth: Image | None, folder: Path) -> Shown:
    note = "" if truth is not None else plates.why_no_truth(panel.cells)
    values = plates.noise(results, panel.finished)
    tile = Tile(TRUTHS[PATH_TRACED], None, None, values, note, truth=True)
    return plates.show(results, tile, truth, None, plates.exposure(panel.finished), folder)


def _cell(
    results: Results,
    cell: Record,
    label: str,
    told: tuple[str, ...],
    truth: Image | None,
    folder: Path,
) -> Shown:
    value = read.metric(cell, PATH_TRACED, results.flip)
    values = () if value is None else (f"{fixed(value, 4)} to path traced",)
    tile = Tile(label, None, None, (*values, *told), plates.note(cell))
    image = results.image(cell, "color") if cell["status"] in read.FINISHED else None
    return plates.show(results, tile, image, truth, plates.exposure([cell]), folder)


def _pair(results: Results, panel: Panel, truth: Image, cell: Record, out: Path) -> list[Figure]:
    """Return the path-traced picture above that of a method that shows diffusion, both large."""
    image = results.image(cell, "color")
    if image is None:
        return []
    stops = plates.exposure([cell])
    value = read.metric(cell, PATH_TRACED, results.flip)
    error = "" if value is None else f", {results.flip} {fixed(value, 4)}"
    rows = ((TRUTHS[PATH_TRACED], truth), (f"{cell['method']}{error}", image))
    height = _WIDTH * panel.size[1] / panel.size[0]
    whole = 2 * plates.MARGIN + _WIDTH, 2 * (plates.MARGIN + _LABEL + height)
    with figures.canvas(*whole, by_hand=True) as canvas:
        top = plates.MARGIN
        for label, picture in rows:
            canvas.text(
                plates.MARGIN / whole[0],
                1 - (top + _LABEL - 0.07) / whole[1],
                label,
                fontsize=10,
                fontweight="bold",
            )
            shown = plates.display(picture, stops)
            plates.draw_picture(canvas, shown, plates.MARGIN, top + _LABEL, _WIDTH)
            top += _LABEL + height + plates.MARGIN
        figure = figures.save(
            canvas,
            out / f"phenomena-{panel.slug}-diffusion",
            title=f"{panel.title}: diffusion",
            caption=f"Above: path traced. Below: {cell['method']}, of the methods that spread "
            "light the one that misses the fewest effects.",
        )
    return [figure]

"""The cells that figures of a paper need: all of them as a matrix, or those that results lack."""

from __future__ import annotations

import shlex
from collections.abc import Iterable, Sequence
from pathlib import Path

import msgspec

from oitbench.catalog.catalog import Catalog, Choice
from oitbench.catalog.needs import Need, merged
from oitbench.errors import DeclarationError, UsageError, unknown
from oitbench.executors.places import Place
from oitbench.matrix.cell import Cell
from oitbench.matrix.plan import CELL_SECONDS, PRESETS, Matrix
from oitbench.method.ablation import REQUESTED
from oitbench.papers.album import Album
from oitbench.papers.listing import Paper
from oitbench.report.context import ReportContext
from oitbench.results.records import Results
from oitbench.truths import EXACT, TRUTHS
from oitbench.views import seen

_SHOWN = 3
"""Cells that an error names."""


def needs_of_reports(
    catalog: Catalog, reports: Iterable[str], variants: dict[str, str]
) -> list[Need]:
    """Return the cells that reports need, each once.

    Raises
    ------
    DeclarationError
        A report cannot be loaded.
    """
    found: list[Need] = []
    for name in reports:
        entry = catalog.entry("report", name, check=True)
        if entry.error:
            raise DeclarationError(entry.error)
        found += entry.needs
    shown = (
        msgspec.structs.replace(need, method=variants.get(need.method, need.method))
        for need in found
    )
    return merged(shown)


def plan_figures(
    paper: Paper,
    reports: Sequence[str] = (),
    preset: str = "standard",
    size: tuple[int, int] | None = None,
    out: Path | str = "results",
    collections: Iterable[Path | str] = (),
    seed: int = 1,
    force: bool = False,
    timeout: float | None = CELL_SECONDS,
    workers: int = 1,
    memory_gib: float | None = None,
    dask: str | None = None,
) -> Matrix:
    """Return the matrix of exactly the cells that figures of a paper need.

    Parameters
    ----------
    paper : Paper
    reports : sequence of str
        Names of its reports. Default: all.
    preset : str
        A key of `PRESETS`, for the size and the timing.
    size : (int, int), optional
        Width and height in pixels. Default: that of the preset.
    out, collections, seed, force, timeout, workers, memory_gib, dask
        As for `oitbench.matrix.plan.plan_matrix`.

    Raises
    ------
    UsageError
        The paper has no such report, or an option is wrong.
    DeclarationError
        A report cannot be loaded, or needs a cell by a name that is not its label.
    """
    for name in reports:
        if name not in paper.drawn.values():
            raise unknown("figure", name, paper.drawn.values())
    chosen = PRESETS[preset]
    size, (grid,) = size or chosen.size, chosen.grids
    place = Place(workers, dask or "", memory_gib)
    with Catalog(collections, place.memory_limit) as catalog:
        names = reports or list(dict.fromkeys(paper.drawn.values()))
        needs = _grouped(needs_of_reports(catalog, names, paper.variants))
        unusable: dict[Cell, str] = {}
        cells: list[Cell] = []
        for need in needs:
            scene = _labeled(catalog.expand_scenes([need.scene]), need.scene)
            method = _labeled(catalog.expand_methods([need.method]), need.method)
            truths = tuple(truth for truth in TRUTHS if truth in (EXACT, *need.truths))
            cell = Cell(
                need.scene, need.method, size, grid, need.effects, seed, chosen.permutations,
                truths, need.shading, need.view, truths != (EXACT,) and chosen.reduces(size, grid),
            )  # fmt: skip
            cells.append(cell)
            if scene.error or method.error:
                unusable[cell] = scene.error or method.error
        methods = tuple(catalog.names("method"))
        files = catalog.places.files({cell.method.partition("[")[0] for cell in cells})
    return Matrix(
        tuple(cells), chosen, Path(out), seed, files, methods, unusable, force, timeout, place
    )


def check_results(catalog: Catalog, results: Results, report: str, paper: str, out: Path) -> None:
    """Raise `UsageError` with the command that helps if results lack cells of a figure.

    Parameters
    ----------
    catalog : Catalog
    results : Results
    report, paper : str
        Names of the figure and of a paper that has it.
    out : Path
        The results folder.
    """
    needs = needs_of_reports(catalog, [report], {})
    lacking = Album(ReportContext(results, out), needs).lacking
    if not lacking:
        return
    named = ", ".join(map(_words, lacking[:_SHOWN]))
    more = f" and {len(lacking) - _SHOWN} more" if len(lacking) > _SHOWN else ""
    sizes = {record.size for record in results.records}
    size = "{}x{}".format(*max(sizes)) if sizes else ""
    command = ["oitbench", "reproduce", paper, "--figure", report, "--out", str(out)]
    command += ["--size", size] if size else []
    count, it = ("1 cell", "it") if len(lacking) == 1 else (f"{len(lacking)} cells", "them")
    raise UsageError(
        f"{report} needs {count} that {out} lacks: {named}{more}; make {it} with:"
        f" {shlex.join(command)}"
    )


def _words(need: Need) -> str:
    """Return a cell in words, as in "hair@side alpha_blend"."""
    settings = [need.effects] if need.effects != REQUESTED else []
    settings += [need.shading] if need.shading else []
    return " ".join([seen(need.scene, need.view), need.method, *settings])


def _grouped(needs: Sequence[Need]) -> list[Need]:
    """Return cells with those of one scene, shading and view together, which share an upload."""
    scenes = list(dict.fromkeys(need.scene for need in needs))
    return sorted(needs, key=lambda need: (scenes.index(need.scene), need.shading, need.view))


def _labeled(choices: Sequence[Choice], label: str) -> Choice:
    """Return the only choice; raise `DeclarationError` unless it has that label."""
    labels = [choice.label for choice in choices]
    if labels != [label] and not any(choice.error for choice in choices):
        raise DeclarationError(f"a figure needs '{label}'; write it as {' or '.join(labels)}")
    return choices[0]

"""`oitbench reference`: render the references of scenes, matched or full, or check them."""

from __future__ import annotations

import sys
import tempfile
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

import click
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TaskID, TextColumn

from oitbench.catalog.catalog import Catalog
from oitbench.cli import options
from oitbench.effects import Effect, names
from oitbench.errors import (
    CapabilityError,
    DeclarationError,
    OitbenchError,
    UsageError,
)
from oitbench.executors.executor import Executor
from oitbench.executors.places import Place
from oitbench.matrix.cell import choose_effects
from oitbench.matrix.plan import CELL_SECONDS
from oitbench.path_traced.references import making, storage
from oitbench.path_traced.references.check import CHECK_SPP
from oitbench.path_traced.references.storage import Reference
from oitbench.path_traced.references.worker import (
    CheckReference,
    Job,
    ReferenceChecked,
    far_end,
)
from oitbench.places import Names, Places
from oitbench.truths import MATCHED, TRACED
from oitbench.views import MAIN, seen

_SIZE = (256, 256)
_SSAA = 2
_CHECKED = Path("results") / "reference_check"


@click.command("reference", short_help="Render or check the references of scenes.")
@click.argument("scenes", nargs=-1, metavar="[SCENE]...")
@click.option(
    "--truth",
    "truths",
    type=click.Choice(TRACED),
    multiple=True,
    help="matched: the light transport that the effects stand for; full: all of it. Repeatable."
    "  [default: as stored, else both]",
)
@click.option(
    "--effects",
    metavar="-NAME,...",
    help="Effects that are left out of a matched reference, as in -refraction."
    "  [default: as stored, else none]",
)
@click.option(
    "--spp",
    type=click.IntRange(1),
    help="Samples for each sub-pixel, of each part. Pictures without random numbers always get one."
    "  [default: by the scene; 4 with --check]",
)
@options.views_or(f"as stored, else {MAIN}")
@options.size(None, "Size of the image in pixels.  [default: as stored, else 256x256]")
@click.option(
    "--ssaa",
    type=click.IntRange(1, 16),
    help="Side of the sub-pixel grid; matched refraction takes at least 8, or 4 for each part of a"
    " random one."
    "  [default: as stored, else 2]",
)
@click.option(
    "--seed",
    type=click.IntRange(0),
    default=1,
    show_default=True,
    help="Seed of the random numbers; with --check, a seed other than the reference's is used.",
)
@click.option(
    "--check",
    "checks",
    is_flag=True,
    help="Render again, full references with few samples, and test the stored ones against it.",
)
@click.option(
    "--adopt",
    "adopts",
    is_flag=True,
    help="With --check: keep stale references that pass, for example after a change of a scene's"
    " file that does not change its picture.",
)
@options.timeout(
    CELL_SECONDS,
    "Seconds that each step may take: building a scene, or tracing one part, or one sample of all"
    " pixels.",
)
@options.memory
@options.workers("trace at once")
@options.dask
@options.collections
@click.option(
    "-o",
    "--output",
    metavar="DIR",
    type=click.Path(path_type=Path, file_okay=False),
    help="Folder for the references, or with --check for the images of failed checks."
    "  [default: the collection; results/reference_check with --check]",
)
def command(
    scenes: tuple[str, ...],
    truths: tuple[str, ...],
    effects: str | None,
    spp: int | None,
    views: tuple[str, ...],
    size: tuple[int, int] | None,
    ssaa: int | None,
    seed: int,
    checks: bool,
    adopts: bool,
    timeout: float | None,
    memory_gib: float | None,
    workers: int,
    dask: str | None,
    collections: tuple[Path, ...],
    output: Path | None,
) -> None:
    """Render the references of each SCENE. Default: all that are stored.

    A reference is written to the folder `reference` of the collection that has the scene's file. A
    matched one that needs random numbers is stored as eight independent parts.

    With --check, no stored image is changed. Each full reference is compared, pixel by pixel, with
    a new rendering of few samples and another seed, and the first part of each matched one with the
    same part, rendered again. The exit code is 1 if a reference fails or is stale.

    A scene that crashes, takes too long or needs too much memory costs its own references only; the
    exit code is then 1, or 2 if nothing could be rendered or checked.
    """
    if adopts and not checks:
        raise UsageError("--adopt needs --check; give both")
    if effects is not None and truths != (MATCHED,):
        raise UsageError("--effects needs --truth matched; full path tracing leaves nothing out")
    chosen = None if effects is None else choose_effects(effects, ~Effect.NONE)
    if checks and dask:
        raise UsageError("--check uses files of this machine; leave out --dask")
    place = Place(workers, dask or "", memory_gib)
    console = Console(highlight=False, soft_wrap=True)
    with Catalog(collections) as catalog:
        jobs = list(_jobs(catalog, scenes, truths, chosen, views, size, ssaa))
    places = catalog.places
    well, failed = True, 0

    def take(job: Job, found: Reference | ReferenceChecked | OitbenchError) -> None:
        nonlocal well, failed
        if isinstance(found, ReferenceChecked):
            well = _print_check(console, found) and well
        elif isinstance(found, Reference):
            stored = folders[job] / found.rendering.key
            console.print(f"rendered {stored}  {_facts(found)}", markup=False)
        elif isinstance(found, CapabilityError):
            # A check that is skipped is no success.
            well = well and not checks
            console.print(f"skipped  {found}", style="yellow", markup=False)
        else:
            failed += 1
            reason = str(found).removeprefix(f"scene {job.scene}: ")
            click.echo(f"failed   {seen(job.scene, job.view)}: {reason}", err=True)

    folders: dict[Job, Path] = {}
    for job, fault in jobs:
        try:
            if fault:
                raise DeclarationError(fault)
            folders[job] = output or (
                _CHECKED if checks else _reference_folder(places.scenes, job.scene)
            )
        except OitbenchError as error:
            take(job, error)
    with _workers(place, places) as (executor, scratch, on_piece):
        if checks:
            requests = [
                CheckReference(job, spp or CHECK_SPP, folder, adopts)
                for job, folder in folders.items()
            ]
            for job, checked in making.check(executor, requests, timeout):
                take(job, checked)
        else:
            orders = [making.Order(job, folder) for job, folder in folders.items()]
            for job, made in making.render(executor, orders, spp, seed, timeout, scratch, on_piece):
                take(job, made)
    sys.exit(2 if failed == len(jobs) else 1 if failed or not well else 0)


@contextmanager
def _workers(place: Place, places: Places) -> Iterator[tuple[Executor, Path, making.OnPiece]]:
    """Yield an executor, the folder of its files, and a function that shows progress."""
    errors = Console(stderr=True, highlight=False, soft_wrap=True)
    columns = (TextColumn("tracing {task.description}"), BarColumn(), MofNCompleteColumn())
    tasks: dict[Job, TaskID] = {}

    def note(line: str) -> None:
        errors.print(line, markup=False)

    def show(job: Job, done: int, count: int) -> None:
        if job not in tasks:
            label = f"{seen(job.scene, job.view)} ({job.truth})"
            tasks[job] = bar.add_task(label, total=count)
        bar.update(tasks[job], completed=done, visible=done < count)

    # In a file or a pipe, the bar would end in an empty line.
    hidden = not errors.is_terminal
    with (
        tempfile.TemporaryDirectory(prefix="oitbench-") as scratch,
        Progress(*columns, console=errors, transient=True, disable=hidden) as bar,
        place.open(far_end(places.files(), Path(scratch)), note) as executor,
    ):
        yield executor, Path(scratch), show


def _stored(folders: Iterable[Path]) -> list[storage.Rendering]:
    """Return how all references were rendered that the collections have."""
    return [
        info.rendering
        for folder in folders
        for info in storage.read_manifest(folder / storage.FOLDER).values()
    ]


def _jobs(
    catalog: Catalog,
    scenes: tuple[str, ...],
    truths: tuple[str, ...],
    chosen: Effect | None,
    views: tuple[str, ...],
    size: tuple[int, int] | None,
    ssaa: int | None,
) -> Iterator[tuple[Job, str]]:
    """Yield a job for each scene, view, truth, size and set of effects.

    By default, these are the stored ones. The text with each job tells why the scene cannot be
    loaded, or is empty.
    """
    known = [info for info in _stored(catalog.places.folders) if info.truth in (truths or TRACED)]
    found = catalog.expand_scenes(scenes or dict.fromkeys(info.scene for info in known))
    if not found:
        raise UsageError("no reference is stored yet; name a scene to render")
    for choice in found:
        of_scene = [info for info in known if info.scene == choice.label]
        for view in views or dict.fromkeys([info.view for info in of_scene] or [MAIN]):
            stored = [info for info in of_scene if info.view == view]
            for job in _jobs_of(choice.label, view, stored, truths, chosen, size, ssaa):
                yield job, choice.error


def _jobs_of(
    label: str,
    view: str,
    stored: Sequence[storage.Rendering],
    truths: tuple[str, ...],
    chosen: Effect | None,
    size: tuple[int, int] | None,
    ssaa: int | None,
) -> Iterator[Job]:
    """Yield the jobs of one view of a scene, whose `stored` references are known."""
    places: dict[tuple[tuple[int, int], str, tuple[str, ...]], None] = {
        (size or info.size, info.truth, tuple(info.left_out)): None for info in stored
    }
    missing = truths or (() if stored else TRACED)
    for truth in missing:
        if all(place[1] != truth for place in places):
            places[size or _SIZE, truth, ()] = None
    if chosen is not None:
        gone = tuple(names(~chosen))
        places = dict.fromkeys((pixels, truth, gone) for pixels, truth, _ in places)
    for pixels, truth, left_out in places:
        same = [
            info.ssaa
            for info in stored
            if (info.size, info.truth, tuple(info.left_out)) == (pixels, truth, left_out)
        ]
        grid = ssaa or (same[0] if same else _SSAA)
        yield Job(label, pixels, grid, truth, left_out, view)


def _print_check(console: Console, checked: ReferenceChecked) -> bool:
    """Print the result of a check, and return whether all is well."""
    if checked.unusable:
        console.print(f"unusable {checked.unusable}", style="red", markup=False)
    if checked.fraction is None:
        return False
    text = f"{checked.key}  {100 * checked.fraction:.2f} % of the pixels pass"
    if checked.failures is not None:
        console.print(
            f"failed   {text}; see the images in {checked.failures}", style="red", markup=False
        )
    else:
        console.print(f"{'adopted ' if checked.adopted else 'passed  '} {text}", markup=False)
    return checked.well


def _reference_folder(scenes: Names, label: str) -> Path:
    """Return where the collection that has the scene's file keeps its references."""
    path = scenes[label.partition("[")[0]]
    if path.suffix != ".py":
        raise UsageError(
            f"{path} is in no collection; give a folder with -o, or keep it by: oitbench import"
        )
    return path.parent.parent / storage.FOLDER


def _facts(rendered: Reference) -> str:
    """Return the samples, the seconds and the noise floor of a reference."""
    how = rendered.rendering
    parts = f"{how.parts} × " if how.parts > 1 else ""
    floors = (
        f"{name} {value:.5f}" for name, value in rendered.noise_floor.items() if value is not None
    )
    return (
        f"ssaa {how.ssaa}, {parts}{how.spp} spp, {rendered.seconds:.1f} s, noise floor "
        + ", ".join(floors)
    )

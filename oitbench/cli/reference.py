"""`oitbench reference`: render the path-traced references, or check them."""

from __future__ import annotations

import sys
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

import click
from rich.console import Console

from oitbench.catalog.checked import load_checked
from oitbench.cli import options
from oitbench.errors import CapabilityError, UsageError
from oitbench.path_traced.references import lookup, storage
from oitbench.path_traced.references.check import CHECK_SPP, check, failure_folder
from oitbench.path_traced.references.rendering import plan_rendering, render_reference
from oitbench.path_traced.references.storage import Reference
from oitbench.plugins import Collection

_SIZE = (256, 256)
_SSAA = 2


@dataclass(frozen=True)
class Job:
    """One reference to render or to check."""

    scene: str
    size: tuple[int, int]
    ssaa: int


@click.command("reference", short_help="Render or check the path-traced references.")
@click.argument("scenes", nargs=-1, metavar="[SCENE]...")
@click.option(
    "--spp",
    type=click.IntRange(2),
    help="Samples for each sub-pixel. Scenes that need no random numbers always get one."
    "  [default: by the scene; 4 with --check]",
)
@options.size(None, "Size of the image in pixels.  [default: as stored, else 256x256]")
@click.option(
    "--ssaa",
    type=click.IntRange(1, 16),
    help="Side of the sub-pixel grid.  [default: as stored, else 2]",
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
    help="Render again with few samples, and test the stored references against it.",
)
@click.option(
    "--adopt",
    "adopts",
    is_flag=True,
    help="With --check: keep stale references that pass, for example after a change of a scene's"
    " file that does not change its picture.",
)
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
    spp: int | None,
    size: tuple[int, int] | None,
    ssaa: int | None,
    seed: int,
    checks: bool,
    adopts: bool,
    collections: tuple[Path, ...],
    output: Path | None,
) -> None:
    """Render the path-traced reference of each SCENE. Default: all scenes that have one.

    A reference is written to the folder `reference` of the collection that has the scene's file.
    With --check, no stored image is changed. Each reference is compared, pixel by pixel, with a new
    rendering of few samples and another seed. The exit code is 1 if a reference fails or is stale.
    """
    if adopts and not checks:
        raise UsageError("--adopt needs --check; give both")
    console = Console(highlight=False, soft_wrap=True)
    collection = load_checked(
        collections,
        lambda catalog: catalog.expand_scenes(
            scenes or {info.scene for info in _stored(catalog.places.folders)}
        ),
    )
    jobs = list(_jobs(collection, scenes, size, ssaa))
    if checks:
        results = [_check(console, collection, job, spp, output, adopts) for job in jobs]
        sys.exit(0 if all(results) else 1)
    for job in jobs:
        _render(console, collection, job, spp, seed, output)


def _stored(folders: Iterable[Path]) -> list[storage.Rendering]:
    """Return how all references were rendered that the collections have."""
    return [
        info.rendering
        for folder in folders
        for info in storage.read_manifest(folder / storage.FOLDER).values()
    ]


def _jobs(
    collection: Collection,
    scenes: tuple[str, ...],
    size: tuple[int, int] | None,
    ssaa: int | None,
) -> Iterator[Job]:
    """Yield a job for each scene and size; without a size, for each size that is stored."""
    known = _stored(collection.folders)
    labels = collection.expand_scenes(scenes) or list(dict.fromkeys(info.scene for info in known))
    if not labels:
        raise UsageError("no reference is stored yet; name a scene to render")
    for label in labels:
        stored = [info for info in known if info.scene == label]
        for pixels in [size] if size else [info.size for info in stored] or [_SIZE]:
            same = [info.ssaa for info in stored if info.size == pixels]
            yield Job(label, pixels, ssaa or (same[0] if same else _SSAA))


def _render(
    console: Console,
    collection: Collection,
    job: Job,
    spp: int | None,
    seed: int,
    output: Path | None,
) -> None:
    scene = collection.build_scene(job.scene)
    rendering = plan_rendering(scene, job.scene, job.size, job.ssaa, spp, seed)
    try:
        reference = render_reference(scene, rendering)
    except CapabilityError as error:
        console.print(f"skipped  {error}", style="yellow", markup=False)
        return
    folder = output or _reference_folder(collection, job.scene)
    storage.save(folder, reference)
    console.print(f"rendered {folder / rendering.key}  {_noise_floor(reference)}", markup=False)


def _check(
    console: Console,
    collection: Collection,
    job: Job,
    spp: int | None,
    output: Path | None,
    adopts: bool,
) -> bool:
    scene = collection.build_scene(job.scene)
    found = lookup.find(scene, job.scene, job.size, job.ssaa, collection.folders)
    key = storage.reference_key(job.scene, job.size)
    if found.message:
        console.print(f"unusable {found.message}", style="red", markup=False)
    reference = found.reference
    if reference is None and adopts and found.stale is not None:
        reference = found.stale[1]
    if reference is None:
        if not found.message:
            raise UsageError(
                f"{key}: no such reference is stored; run without --check to render it"
            )
        return False
    failures = output or Path("results") / "reference_check"
    result = check(scene, reference, failures, spp or CHECK_SPP)
    text = f"{key}  {100 * result.fraction:.2f} % of the pixels pass"
    if not result.passed:
        folder = failure_folder(failures, reference)
        console.print(f"failed   {text}; see the images in {folder}", style="red", markup=False)
        return False
    if found.reference is None and found.stale is not None:
        lookup.adopt(scene, *found.stale)
        console.print(f"adopted  {text}", markup=False)
        return True
    console.print(f"passed   {text}", markup=False)
    return not found.message


def _reference_folder(collection: Collection, label: str) -> Path:
    """Return where the collection that has the scene's file keeps its references."""
    path = collection.scenes.path(label.partition("[")[0])
    return path.parent.parent / storage.FOLDER


def _noise_floor(reference: Reference) -> str:
    floors = (
        f"{name} {value:.5f}" for name, value in reference.noise_floor.items() if value is not None
    )
    return "noise floor " + ", ".join(floors)

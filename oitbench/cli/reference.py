"""`oitbench reference`: render the path-traced references, or check them."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import click
from rich.console import Console

from oitbench.cli import options
from oitbench.errors import CapabilityError, UsageError
from oitbench.path_traced.references import obtain as references
from oitbench.path_traced.references import stored
from oitbench.path_traced.references.stored import Reference
from oitbench.plugins import Collection, own_folder

_CHECK_SPP = 4
_CHECK_SEED = 2


@dataclass(frozen=True)
class Job:
    """One reference to render or to check."""

    scene: str
    size: tuple[int, int]
    ssaa: int


@click.command("reference", short_help="Render or check the path-traced references.")
@click.argument("scenes", nargs=-1, metavar="[SCENE]...")
@click.option("--spp", type=click.IntRange(2), help="Samples per sub-pixel, where any are drawn.")
@options.size(None, "Pixels.  [default: as stored, else 256x256]")
@click.option("--ssaa", type=click.IntRange(1, 16), help="Sub-pixel grid.  [default: 2]")
@click.option("--seed", type=click.IntRange(0), default=1, show_default=True)
@click.option("--check", is_flag=True, help="Render again and test against what is stored.")
@options.collections
@click.option(
    "-o",
    "--output",
    metavar="DIR",
    type=click.Path(path_type=Path, file_okay=False),
    help="Where references, or with --check the images of a failure, are written.",
)
def command(
    scenes: tuple[str, ...],
    spp: int | None,
    size: tuple[int, int] | None,
    ssaa: int | None,
    seed: int,
    check: bool,
    collections: tuple[Path, ...],
    output: Path | None,
) -> None:
    """Render the path-traced reference of each SCENE, or of all that are stored.

    References go to the folder `reference` of the collection that has the scene's file.
    With --check nothing stored is changed: each is rendered anew with few samples and another
    seed, and tested pixel by pixel; the exit code is 1 if one fails or is out of date.
    """
    console = Console(highlight=False, soft_wrap=True)
    collection = Collection.load(collections)
    jobs = list(_jobs(collection, scenes, size, ssaa))
    if check:
        results = [_check(console, collection, job, spp, output) for job in jobs]
        sys.exit(0 if all(results) else 1)
    for job in jobs:
        _render(console, collection, job, spp, seed, output)


def _jobs(
    collection: Collection,
    scenes: tuple[str, ...],
    wanted: tuple[int, int] | None,
    ssaa: int | None,
) -> Iterator[Job]:
    """Yield what was named; without a size, what is stored of it, else 256x256."""
    known = [
        entry
        for folder in collection.folders
        for entry in stored.read_manifest(folder / references.FOLDER).values()
    ]
    labels = collection.expand_scenes(scenes) or list(dict.fromkeys(e["scene"] for e in known))
    if not labels:
        raise UsageError("no reference is stored yet; name a scene to render")
    for label in labels:
        entries = [entry for entry in known if entry["scene"] == label]
        sizes = [(entry["size"][0], entry["size"][1]) for entry in entries]
        for pixels in [wanted] if wanted else sizes or [(256, 256)]:
            same = [entry["ssaa"] for entry in entries if tuple(entry["size"]) == pixels]
            yield Job(label, pixels, ssaa or (same[0] if same else 2))


def _render(
    console: Console,
    collection: Collection,
    job: Job,
    spp: int | None,
    seed: int,
    output: Path | None,
) -> None:
    scene = collection.build_scene(job.scene)
    try:
        reference = references.render_reference(scene, job.scene, job.size, job.ssaa, spp, seed)
    except CapabilityError as error:
        console.print(f"skipped  {error}", style="yellow", markup=False)
        return
    folder = output or _home(collection, job.scene) / references.FOLDER
    stored.save(folder, reference)
    console.print(f"rendered {folder / reference.key}  {_floor(reference)}", markup=False)


def _check(
    console: Console, collection: Collection, job: Job, spp: int | None, output: Path | None
) -> bool:
    scene = collection.build_scene(job.scene)
    reference = references.load_reference(scene, job.scene, job.size, job.ssaa, collection.folders)
    if reference is None:
        key = stored.entry_key(job.scene, job.size)
        raise UsageError(f"{key}: no such reference is stored; run without --check to render it")
    if reference.stale:
        console.print(f"stale    {reference.message}", style="red", markup=False)
        return False
    failures = output or Path("results") / "reference_check"
    result = references.check(scene, reference, spp or _CHECK_SPP, _CHECK_SEED, failures)
    told = f"{reference.key}  {100 * result.fraction:.2f} % of the pixels pass"
    if result.passed:
        console.print(f"passed   {told}", markup=False)
    else:
        told += f"; images are in {failures / reference.key}"
        console.print(f"failed   {told}", style="red", markup=False)
    return result.passed


def _home(collection: Collection, label: str) -> Path:
    """Return the last collection folder that has the scene's file, as the registry does."""
    name = label.partition("[")[0]
    owners = [f for f in collection.folders if (f / "scenes" / f"{name}.py").is_file()]
    return owners[-1] if owners else own_folder()


def _floor(reference: Reference) -> str:
    floors = (
        f"{name} {value:.5f}" for name, value in reference.noise_floor.items() if value is not None
    )
    return "noise floor " + ", ".join(floors)

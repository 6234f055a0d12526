"""Path-traced references: shipped, cached or rendered on demand, and never silently out of date."""

from __future__ import annotations

import os
from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path

import numpy as np

from oitbench.errors import UsageError
from oitbench.image import files as images
from oitbench.image import metrics
from oitbench.image.files import Image
from oitbench.path_traced import llvm
from oitbench.path_traced.references.fingerprint import fingerprint
from oitbench.path_traced.references.stored import Reference, read, save
from oitbench.path_traced.references.z_test import ZTest, z_test
from oitbench.path_traced.trace.render import Estimate, Progress, render
from oitbench.scene import Scene

FOLDER = "reference"
"""Where a collection keeps its references."""
DEFAULT_SPP = 64
"""Samples for each sub-pixel, where the scene needs random walks at all; …"""
FOGGY_SPP = 128
"""… where a medium scatters it, of which a path sees one place; …"""
BENT_SPP = 32
"""… where solids bend light, as paths are long and photons are traced too; …"""
CLOUDED_SPP = 4
"""… where there are particles, as a ray crosses a hundred of them."""


def load_reference(
    scene: Scene,
    label: str,
    size: tuple[int, int],
    ssaa: int,
    folders: Iterable[Path],
    cache: Path | None = None,
) -> Reference | None:
    """Return the stored reference of `scene`, from the collections' folders or the cache.

    Parameters
    ----------
    scene : Scene
    label : str
        Its canonical label.
    size : (int, int)
        Width and height in pixels.
    ssaa : int
        A reference of another sub-pixel grid is none.
    folders : iterable of Path
        Collection folders; the last one that has a reference wins.
    cache : Path, optional

    Returns
    -------
    Reference or None
        One that fits, else a stale one with its message, else None.

    Raises
    ------
    UsageError
        If a manifest or an image is damaged.
    """
    current = fingerprint(scene)
    places = [folder / FOLDER for folder in folders][::-1]
    if cache is not None:
        places.append(_cached_place(cache, current, size, ssaa))
    outdated: Reference | None = None
    for place in places:
        found = read(place, label, size)
        if found is None or found.ssaa != ssaa:
            continue
        if found.fingerprint == current:
            return found if outdated is None else replace(found, message=outdated.message)
        message = (
            f"{place / found.key}: the scene has changed since this reference was rendered; "
            f"run 'oitbench reference {label}'"
        )
        outdated = outdated or replace(found, stale=True, message=message)
    return outdated


def obtain_reference(
    scene: Scene,
    label: str,
    size: tuple[int, int],
    ssaa: int,
    folders: Iterable[Path],
    cache: Path | None = None,
    spp: int | None = None,
    seed: int = 1,
    progress: Progress | None = None,
) -> Reference:
    """Return a reference that fits: shipped, else cached, else rendered now and cached.

    Parameters
    ----------
    scene, label, size, ssaa, folders
        As in `load_reference`.
    cache : Path, optional
        `cache_folder()` without.
    spp : int, optional
        `default_spp` without.
    seed : int
        For a reference that has to be rendered.
    progress : callable, optional
        Told about the rendering; a bar is shown on the terminal without.

    Returns
    -------
    Reference
        Never stale; its message tells if a stale one was passed over or the cache is read-only.

    Raises
    ------
    CapabilityError
        If the scene cannot be path-traced here.
    UsageError
        If a manifest or an image is damaged.
    """
    cache = cache_folder() if cache is None else cache
    found = load_reference(scene, label, size, ssaa, folders, cache)
    if found is not None and not found.stale:
        return found
    reference = render_reference(scene, label, size, ssaa, spp, seed, progress)
    message = found.message if found is not None else ""
    try:
        save(_cached_place(cache, reference.fingerprint, size, ssaa), reference)
    except UsageError as error:
        message = f"{message}; not cached: {error}".removeprefix("; ")
    return replace(reference, message=message)


def render_reference(
    scene: Scene,
    label: str,
    size: tuple[int, int],
    ssaa: int = 2,
    spp: int | None = None,
    seed: int = 1,
    progress: Progress | None = None,
) -> Reference:
    """Render a reference; a progress bar is shown unless `progress` is given.

    Without `spp`, `default_spp` samples are taken for each sub-pixel.

    Raises
    ------
    CapabilityError
        If the scene cannot be path-traced here.
    """
    spp = default_spp(scene) if spp is None else spp
    if progress is None:
        estimate = _with_bar(scene, label, size, ssaa, spp, seed)
    else:
        estimate = render(scene, size, ssaa, spp, seed, progress)
    return Reference(
        scene=label,
        size=size,
        ssaa=ssaa,
        spp=estimate.spp,
        seed=seed,
        mitsuba=str(llvm.backend().mitsuba),
        fingerprint=fingerprint(scene),
        noise_floor=noise_floor(estimate, scene.exposure),
        mean=estimate.mean,
        variance=estimate.variance,
    )


def default_spp(scene: Scene) -> int:
    """Return how many samples a sub-pixel gets, so that a picture takes some minutes."""
    if any(item.particles for item in scene.objects):
        return CLOUDED_SPP
    if scene.medium is not None:
        return FOGGY_SPP
    return BENT_SPP if any(item.material.refracts for item in scene.objects) else DEFAULT_SPP


def noise_floor(estimate: Estimate, exposure: float) -> dict[str, float | None]:
    """Return how much the two halves of the samples differ, by metric."""
    first, second = estimate.halves
    return {
        metrics.FLIP_LDR: metrics.flip_ldr(first, second, exposure),
        metrics.RMSE: metrics.rmse(first, second),
    }


def check(
    scene: Scene, reference: Reference, spp: int = 4, seed: int = 2, output: Path | None = None
) -> ZTest:
    """Render `scene` again with few samples and another seed, and test it against `reference`.

    Parameters
    ----------
    scene : Scene
    reference : Reference
    spp, seed : int
    output : Path, optional
        A folder; where the test fails, the image, the reference, their difference and the p-values
        are written there as EXR and PNG.

    Returns
    -------
    ZTest
    """
    estimate = render(scene, reference.size, reference.ssaa, spp, seed, lambda done, count: None)
    # The stored variance is known far better than that of a few samples.
    variance = reference.variance * (1 + reference.spp / estimate.spp)
    result = z_test(estimate.mean, reference.mean, variance)
    if not result.passed and output is not None:
        _write_failure(output / reference.key, scene.exposure, estimate.mean, reference, result)
    return result


def cache_folder() -> Path:
    """Return the user's cache of references."""
    base = os.environ.get("XDG_CACHE_HOME")
    return (Path(base) if base else Path.home() / ".cache") / "oitbench" / "references"


def _cached_place(cache: Path, digest: str, size: tuple[int, int], ssaa: int) -> Path:
    """Return one folder for one rendering: two processes then never share a manifest."""
    return cache / f"{digest[:16]}-{size[0]}x{size[1]}-{ssaa}"


def _with_bar(
    scene: Scene, label: str, size: tuple[int, int], ssaa: int, spp: int, seed: int
) -> Estimate:
    from rich.console import Console
    from rich.progress import Progress as Bar

    with Bar(console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task(f"path tracing {label}", total=None)
        return render(
            scene,
            size,
            ssaa,
            spp,
            seed,
            lambda done, count: bar.update(task, completed=done, total=count),
        )


def _write_failure(
    folder: Path, exposure: float, mean: Image, reference: Reference, result: ZTest
) -> None:
    p_value = np.repeat(result.p_value[..., None], 3, axis=2)
    error = np.abs(mean - reference.mean)
    linear = {"image": mean, "reference": reference.mean, "error": error}
    for name, picture in linear.items():
        images.write_exr(folder / f"{name}.exr", picture)
        images.write_png(folder / f"{name}.png", images.to_srgb(picture, exposure))
    images.write_exr(folder / "p_value.exr", p_value)
    images.write_png(folder / "p_value.png", p_value)

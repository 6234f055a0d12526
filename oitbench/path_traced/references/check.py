"""Checking a stored reference against a new rendering.

A full one is compared with few samples of another seed. Matched pictures are repeatable, so the
first part is rendered again, and must be equal but for rounding.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from oitbench.filenames import file_name
from oitbench.image import files as images
from oitbench.image.files import Image
from oitbench.path_traced.references.pieces import render_part
from oitbench.path_traced.references.storage import Reference
from oitbench.path_traced.references.z_test import ZTest, z_test
from oitbench.path_traced.trace.render import Progress, render
from oitbench.scene import Scene

CHECK_SPP = 4
"""Samples of the new rendering for each sub-pixel, of a full reference."""


def check(
    scene: Scene,
    reference: Reference,
    output: Path,
    spp: int = CHECK_SPP,
    progress: Progress | None = None,
) -> ZTest:
    """Render a scene again, and test the picture against `reference`.

    Parameters
    ----------
    scene : Scene
    reference : Reference
    output : Path
        If the test fails, the new image, the reference, their difference and the p-values are
        written to a folder below it, as EXR and PNG files.
    spp : int
        Samples for each sub-pixel, of a full reference.
    progress : callable, optional
        See `trace.render.Progress`.

    Returns
    -------
    ZTest

    Raises
    ------
    UsageError, CapabilityError, SceneError
        As `trace.render.render` does.
    """
    known = reference.rendering
    if reference.variance is None:
        image, truth = render_part(scene, known, 0), reference.parts[0]
        result = z_test(image, truth, np.zeros(truth.shape))
    else:
        estimate = render(scene, known.size, known.ssaa, spp, known.seed + 1, progress)
        image, truth = estimate.mean, reference.mean
        # The variance of the new mean follows from the stored one, which is known far better.
        result = z_test(image, truth, reference.variance * (1 + known.spp / estimate.spp))
    if not result.passed:
        folder = failure_folder(output, reference)
        _write_failure(folder, scene.exposure, image, truth, result)
    return result


def failure_folder(output: Path, reference: Reference) -> Path:
    """Return the folder below `output` for the images of a failed check."""
    return output / file_name(reference.rendering.key)


def _write_failure(
    folder: Path, exposure: float, mean: Image, reference: Image, result: ZTest
) -> None:
    p_value = np.repeat(result.p_value[..., None], 3, axis=2)
    linear = {"image": mean, "reference": reference, "error": np.abs(mean - reference)}
    for name, picture in linear.items():
        images.write_exr(folder / f"{name}.exr", picture)
        images.write_png(folder / f"{name}.png", images.to_srgb(picture, exposure))
    images.write_exr(folder / "p_value.exr", p_value)
    images.write_png(folder / "p_value.png", p_value)

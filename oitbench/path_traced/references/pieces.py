"""References in independent pieces: the parts of a matched one, the sections of a full one."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from oitbench.effects import effects_of
from oitbench.image import metrics, ties
from oitbench.image.files import Image
from oitbench.path_traced.matched.render import matched
from oitbench.path_traced.references.storage import Reference, Rendering
from oitbench.path_traced.trace.render import Progress, Tracer, Tracing
from oitbench.path_traced.trace.sections import Section, estimate
from oitbench.scene import Scene
from oitbench.truths import MATCHED

Piece = Image | Section


class Pieces:
    """Renders the pieces of one reference, in any order.

    Parameters
    ----------
    scene : Scene
        As seen from the view.
    rendering : Rendering
    """

    def __init__(self, scene: Scene, rendering: Rendering) -> None:
        self._scene, self._rendering = scene, rendering
        self._tracer: Tracer | None = None

    @property
    def count(self) -> int:
        """Their number."""
        if self._rendering.truth == MATCHED:
            return self._rendering.parts
        return _tracing(self._rendering).sections(self._scene)

    def render(self, number: int, progress: Progress = lambda done, count: None) -> Piece:
        """Return a piece, the same in every call.

        Parameters
        ----------
        number : int
        progress : callable
            See `trace.render.Progress`; of a matched reference, it counts parts.

        Raises
        ------
        UsageError, CapabilityError, SceneError
            As `trace.render.render` does.
        """
        if self._rendering.truth == MATCHED:
            part = render_part(self._scene, self._rendering, number)
            progress(number + 1, self._rendering.parts)
            return part
        if self._tracer is None:
            self._tracer = Tracer(self._scene, _tracing(self._rendering))
        return self._tracer.section(number, progress)


def render_part(scene: Scene, rendering: Rendering, number: int) -> Image:
    """Return a part of a matched reference, the same in every call."""
    return matched(
        scene,
        rendering.size,
        rendering.ssaa,
        effects_of(rendering.effects),
        samples=rendering.spp,
        part=rendering.seed * ties.PARTS + number,
        jitter=rendering.jitter,
    )


def assemble(
    rendering: Rendering, pieces: Sequence[Any], exposure: float, seconds: float
) -> Reference:
    """Return the reference of all pieces, which are in order.

    Parameters
    ----------
    rendering : Rendering
    pieces : sequence of Piece
    exposure : float
        Of the scene.
    seconds : float
        Time of the rendering.
    """
    if rendering.truth == MATCHED:
        parts = tuple(pieces)
        return Reference(rendering, noise_floor(parts, exposure), seconds, parts)
    found = estimate(pieces)
    floor = noise_floor(found.halves, exposure)
    return Reference(rendering, floor, seconds, (found.mean,), found.variance)


def noise_floor(parts: tuple[Image, ...], exposure: float) -> dict[str, float | None]:
    """Return the error that the noise of a reference causes, by metric.

    Parameters
    ----------
    parts : tuple of array, shape (h, w, 3)
        Independent means of equally many samples.
    exposure : float
        Of the scene.
    """

    def ldr(image: Image, truth: Image) -> float:
        return metrics.flip_ldr(truth, image, exposure) or 0.0

    def hdr(image: Image, truth: Image) -> float:
        return metrics.flip_hdr(truth, image, exposure) or 0.0

    def rmse(image: Image, truth: Image) -> float:
        return metrics.rmse(truth, image) or 0.0

    measures = {metrics.FLIP_LDR: ldr, metrics.FLIP_HDR: hdr, metrics.RMSE: rmse}
    return {name: ties.noise_floor(parts, metric) for name, metric in measures.items()}


def write(path: Path, piece: Piece) -> None:
    """Write a piece as an archive of numpy."""
    if isinstance(piece, Section):
        arrays: dict[str, Any] = {
            field.name: getattr(piece, field.name) for field in dataclasses.fields(piece)
        }
    else:
        arrays = {"image": piece}
    with path.open("wb") as file:
        np.savez(file, **arrays)


def read(path: Path) -> Piece:
    """Read what `write` has written."""
    with np.load(path) as archive:
        arrays = dict(archive)
    if "image" in arrays:
        image: Image = arrays["image"]
        return image
    return Section(**arrays | {"samples": int(arrays["samples"])})


def _tracing(rendering: Rendering) -> Tracing:
    return Tracing(rendering.size, rendering.ssaa, max(2, rendering.spp), rendering.seed)

"""Scores of a picture against the truths of its scene."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import numpy.typing as npt

from oitbench.effects import SHADING, Effect
from oitbench.gl.frame import Image
from oitbench.image import files, metrics
from oitbench.image.stored import StoredImage
from oitbench.matrix.stage import Exact, Stage, Store, Truth
from oitbench.results.pictures import PICTURE
from oitbench.results.schema import Scores, flip_image
from oitbench.truths import EXACT, ranking_truth

_OPEN, _SHADOWED, _OCCLUDED = 0.01, 0.06, 0.1
_SHADOWS = SHADING & ~(Effect.AMBIENT_OCCLUSION | Effect.INFERRED_AO)


def largest_disagreement(effects: Effect) -> float:
    """Return the largest FLIP between exact compositing and matched tracing that is plausible.

    Both show the same transport if all effects are compositing or shared shading. Then they differ
    by the noise floor, which comes on top, by rounding and aliasing (0.01), and by the
    approximations of shared shading: shadow maps (0.06) and ambient occlusion (0.1).

    Parameters
    ----------
    effects : Effect
        Effects that run.
    """
    if effects & Effect.AMBIENT_OCCLUSION:
        return _OCCLUDED
    return _SHADOWED if effects & _SHADOWS else _OPEN


def disagreement(effects: Effect, exact: Truth, matched: Truth, exposure: float) -> str:
    """Return why exact compositing and matched tracing contradict each other; empty if not.

    They may differ if an effect runs that compositing does not express.
    """
    if ranking_truth(effects) != EXACT:
        return ""
    found = metrics.flip_ldr(matched.image, exact.image, exposure)
    floor = matched.noise_floor.get(metrics.FLIP_LDR) or 0.0
    allowed = largest_disagreement(effects) + floor
    if found is None or found <= allowed:
        return ""
    return (
        f"exact compositing and matched tracing differ by {metrics.FLIP_LDR} {found:.3f}, but every"
        f" effect is expressed; at most {allowed:.3f} is plausible"
    )


class Scorer:
    """Scores one picture, and stores the maps of its errors.

    Parameters
    ----------
    stage : Stage
    exact : Exact
        It says which pixels have transparent fragments.
    image : array, shape (h, w, 3), float32
    store : Store
    kind : str
        Kind of the picture among the images of a cell.

    Attributes
    ----------
    exact : Exact
    images : dict of str to StoredImage
        The picture, the truths that it was scored against, and its maps of FLIP.
    """

    def __init__(
        self, stage: Stage, exact: Exact, image: Image, store: Store, kind: str = PICTURE
    ) -> None:
        self.exact, self._exposure = exact, stage.scene.exposure
        self._image, self._store = image, store
        self.images: dict[str, StoredImage] = {kind: store(kind, files.image_channels(image))}

    def score(self, kind: str, truth: Truth) -> Scores:
        """Return all metrics against a truth, whose images are stored under `kind`."""
        self.images[kind] = truth.stored
        evaluation = metrics.compare(truth.image, self._image, self._exposure)
        if evaluation.maps:
            maps = (evaluation.maps[metrics.FLIP_LDR], evaluation.maps[metrics.FLIP_HDR])
            self.images[flip_image(kind)] = self._store(
                flip_image(kind), files.flip_channels(*maps)
            )
        return Scores(
            evaluation.values,
            dict(truth.noise_floor),
            self._jackknife(truth) if evaluation.maps else {},
            means_where(evaluation.maps, self.exact.transparent),
            means_where(evaluation.maps, ~self.exact.transparent),
            truth.facts,
            message=truth.message,
        )

    def _jackknife(self, truth: Truth) -> dict[str, list[float]]:
        """Return FLIP of the displayed image against the mean of all parts but each one.

        HDR-FLIP takes four times as long and is not needed to rank methods.
        """
        values = [metrics.flip_ldr(mean, self._image, self._exposure) for mean in truth.without]
        known = [value for value in values if value is not None]
        return {metrics.FLIP_LDR: known} if known else {}


def means_where(
    maps: Mapping[str, Image], pixels: npt.NDArray[np.bool_]
) -> dict[str, float | None]:
    """Return the mean of each map over some pixels; None if there are none."""
    return {
        name: float(errors[pixels].mean(dtype=np.float64)) if pixels.any() else None
        for name, errors in maps.items()
    }

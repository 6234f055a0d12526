"""Alpha to coverage in double precision, with the masks of llvmpipe: nested, and rounded up."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from oitbench.scene import Floats, FragmentLists
from tests.models.commutative import layers_of


def composite(lists: FragmentLists, background: npt.ArrayLike, samples: int) -> Floats:
    """Return the mean of samples that each show their nearest layer, shape (h, w, 3).

    A layer of opacity o takes the samples 0 to ⌈o S⌉ − 1.
    """
    color, opacity = layers_of(lists)
    shown = color / np.maximum(opacity, 1e-20)[..., None]
    picture = np.zeros((*opacity.shape[1:], 3))
    for sample in range(samples):
        taken = np.asarray(opacity.astype(np.float32) * samples > sample)
        nearest = np.asarray(np.where(taken, lists.z, np.inf).argmin(axis=0))[None, ..., None]
        chosen = np.take_along_axis(shown, nearest, axis=0)[0]
        covered = np.asarray(taken.any(axis=0))[..., None]
        picture += np.where(covered, chosen, np.asarray(background)) / samples
    return picture

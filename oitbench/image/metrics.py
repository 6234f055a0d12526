"""Image metrics, which refuse to score invalid images.

The name of a metric contains its parameters. `flip_ldr@67ppd`, `ssim_gauss11_srgb` and `psnr_srgb`
compare the displayed images (one exposure, clipped, sRGB). `flip_hdr@67ppd`, `rmse_lin` and
`relmse_lin(eps=1e-2)` compare linear radiance.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from oitbench.image import files as images
from oitbench.image.files import Image

FLIP_LDR = "flip_ldr@67ppd"
FLIP_HDR = "flip_hdr@67ppd"
SSIM = "ssim_gauss11_srgb"
PSNR = "psnr_srgb"
RMSE = "rmse_lin"
RELMSE = "relmse_lin(eps=1e-2)"
TRANSMITTANCE = "rmse_transmittance"
"""RMSE of the total transmittance, for methods that have one."""
ORDER_SPREAD_MAX = "order_spread_max_lin"
"""Largest difference in any channel of any pixel between images of permuted draws."""
ORDER_SPREAD_MEAN = "order_spread_mean_lin"
"""The same difference, averaged over channels and pixels."""

NAMES = (FLIP_LDR, FLIP_HDR, SSIM, PSNR, RMSE, RELMSE)
"""The metrics of `compare`."""

_PIXELS_PER_DEGREE = 3840 * math.pi / 180
"""The viewing conditions of the FLIP papers: 0.7 m from a screen 0.7 m and 3840 pixels wide."""
_REACH = math.ceil(3 * math.sqrt(0.04 / (2 * math.pi**2)) * _PIXELS_PER_DEGREE)
"""Radius in pixels of the widest filter of FLIP: three standard deviations."""
_HDR_STOPS = 2.0
"""HDR-FLIP uses three exposures: the scene's own, and this many stops below and above it."""
_HDR_IMAGES = 3

_RELATIVE_EPSILON = 1e-2
_SSIM_WINDOW = 11


@dataclass(frozen=True, eq=False)
class Evaluation:
    """The metrics of one image against a reference.

    Parameters
    ----------
    values : dict of str to float or None
        All metrics of `NAMES`. None where a metric has no finite value, and for all of them if a
        pixel of either image is not finite.
    maps : dict of str to array, shape (h, w), float32
        For `FLIP_LDR` and `FLIP_HDR`, the error of each pixel; the value is its mean. Empty if a
        pixel of either image is not finite.
    """

    values: dict[str, float | None]
    maps: dict[str, Image]


def compare(reference: npt.ArrayLike, test: npt.ArrayLike, exposure: float) -> Evaluation:
    """Return all metrics of `test` against `reference`.

    HDR-FLIP is computed for a fixed range of exposures. The evaluator's automatic exposures are
    never used: they follow from the median of the reference, fail if that is zero, and end the
    process for a black reference.

    Parameters
    ----------
    reference, test : array, shape (h, w, 3), floating point
        Linear Rec.709 radiance. HDR-FLIP takes negative values as zero.
    exposure : float
        The scene's exposure in stops.

    Raises
    ------
    TypeError, ValueError
        If an image is not (h, w, 3) of floats, or the sizes differ.

    References
    ----------
    FLIP: Andersson et al., "FLIP: A Difference Evaluator for Alternating Images", HPG 2020.
    HDR-FLIP: Andersson et al., "Visualizing Errors in Rendered High Dynamic Range Images", EG 2021.
    SSIM: Wang et al., "Image Quality Assessment", IEEE TIP 2004; Gaussian window, σ = 1.5.
    """
    pair = _pair(reference, test)
    if pair is None:
        return Evaluation(dict.fromkeys(NAMES), {})
    displayed = _displayed(pair, exposure)
    maps = {FLIP_LDR: _ldr_map(displayed), FLIP_HDR: _hdr_map(pair, exposure)}
    values = {
        FLIP_LDR: _mean(maps[FLIP_LDR]),
        FLIP_HDR: _mean(maps[FLIP_HDR]),
        SSIM: _ssim(displayed),
        PSNR: _psnr(displayed),
        RMSE: _rmse(pair),
        RELMSE: _relmse(pair),
    }
    return Evaluation(values, maps)


def flip_ldr(reference: npt.ArrayLike, test: npt.ArrayLike, exposure: float) -> float | None:
    """Return the metric `FLIP_LDR` of `compare` alone."""
    pair = _pair(reference, test)
    return None if pair is None else _mean(_ldr_map(_displayed(pair, exposure)))


def flip_hdr(reference: npt.ArrayLike, test: npt.ArrayLike, exposure: float) -> float | None:
    """Return the metric `FLIP_HDR` of `compare` alone."""
    pair = _pair(reference, test)
    return None if pair is None else _mean(_hdr_map(pair, exposure))


def rmse(reference: npt.ArrayLike, test: npt.ArrayLike) -> float | None:
    """Return the metric `RMSE` of `compare` alone."""
    pair = _pair(reference, test)
    return None if pair is None else _rmse(pair)


def count_nonfinite(image: npt.ArrayLike) -> dict[str, int]:
    """Count the invalid pixels of an image.

    Parameters
    ----------
    image : array, shape (h, w, 3), floating point

    Returns
    -------
    dict of str to int
        `nan`, `inf` and `negative`: the number of pixels with at least one such channel. −∞ counts
        as `inf`.
    """
    pixels = images.check(image)
    infinite = np.isinf(pixels)
    return {
        "nan": int(np.isnan(pixels).any(axis=-1).sum()),
        "inf": int(infinite.any(axis=-1).sum()),
        "negative": int(((pixels < 0) & ~infinite).any(axis=-1).sum()),
    }


def rmse_transmittance(reference: npt.ArrayLike, test: npt.ArrayLike) -> float | None:
    """Return the root mean square error between two images of total transmittance.

    Parameters
    ----------
    reference, test : array, shape (h, w) or (h, w, 3), floating point
        A gray `test` is compared with the mean of the reference's channels.

    Returns
    -------
    float or None
        None if a value is not finite.

    Raises
    ------
    ValueError
        If the shapes differ.
    """
    truth, guess = (np.asarray(array, dtype=np.float64) for array in (reference, test))
    if truth.ndim == 3 and guess.ndim == 2:
        truth = truth.mean(axis=-1)
    if truth.shape != guess.shape:
        raise ValueError(f"transmittances have shapes {truth.shape} and {guess.shape}")
    if not (np.isfinite(truth).all() and np.isfinite(guess).all()):
        return None
    return float(np.sqrt(((guess - truth) ** 2).mean()))


def order_spread(permuted: Iterable[npt.ArrayLike]) -> dict[str, float | None]:
    """Return how much the image of a scene depends on the order of the draws.

    Parameters
    ----------
    permuted : iterable of array, shape (h, w, 3)
        Images of permuted draws. They are consumed one at a time, so that a generator saves memory.

    Returns
    -------
    dict of str to float or None
        `ORDER_SPREAD_MAX` and `ORDER_SPREAD_MEAN` of the range of each channel. None with fewer
        than two images, or if a pixel is not finite.
    """
    low: Image | None = None
    high: Image | None = None
    count = 0
    for other in permuted:
        image = images.check(other)
        count += 1
        low = image if low is None else np.minimum(low, image)
        high = image if high is None else np.maximum(high, image)
    if count < 2 or low is None or high is None:
        return {ORDER_SPREAD_MAX: None, ORDER_SPREAD_MEAN: None}
    # NaN propagates through minimum and maximum. Equal infinities must not count as no spread.
    known = bool(np.isfinite(low).all() and np.isfinite(high).all())
    spread = high.astype(np.float64) - low if known else None
    return {
        ORDER_SPREAD_MAX: None if spread is None else float(spread.max()),
        ORDER_SPREAD_MEAN: None if spread is None else float(spread.mean()),
    }


def _pair(reference: npt.ArrayLike, test: npt.ArrayLike) -> tuple[Image, Image] | None:
    """Return both images, checked, or None if a pixel is not finite."""
    truth = images.check(reference, "reference")
    guess = images.check(test, "test image")
    if truth.shape != guess.shape:
        raise ValueError(f"reference is {truth.shape} but the test image is {guess.shape}")
    return (truth, guess) if np.isfinite(truth).all() and np.isfinite(guess).all() else None


def _displayed(pair: tuple[Image, Image], exposure: float) -> tuple[Image, Image]:
    reference, test = (images.to_srgb(image, exposure) for image in pair)
    return reference, test


def _mean(errors: Image) -> float | None:
    mean = float(errors.mean(dtype=np.float64))
    return mean if math.isfinite(mean) else None


def _ldr_map(displayed: tuple[Image, Image]) -> Image:
    return _evaluate_flip(*displayed, "LDR", {})


def _hdr_map(pair: tuple[Image, Image], exposure: float) -> Image:
    fixed = {
        "startExposure": float(exposure - _HDR_STOPS),
        "stopExposure": float(exposure + _HDR_STOPS),
        "numExposures": _HDR_IMAGES,
    }
    truth, guess = (np.maximum(image, np.float32(0)) for image in pair)
    return _evaluate_flip(truth, guess, "HDR", fixed)


def _evaluate_flip(reference: Image, test: Image, kind: str, fixed: Mapping[str, float]) -> Image:
    """Return the map of FLIP. Only the surroundings of pixels that differ are evaluated."""
    import flip_evaluator

    found = np.zeros(reference.shape[:2], np.float32)
    differs = (reference != test).any(axis=-1)
    if not differs.any():
        return found
    box = tuple(_around(differs.any(axis=other)) for other in (1, 0))
    errors, _, _ = flip_evaluator.evaluate(
        np.ascontiguousarray(reference[box]),
        np.ascontiguousarray(test[box]),
        kind,
        inputsRGB=True,  # The evaluator's name for "sRGB-encoded"; it ignores this for HDR.
        applyMagma=False,
        computeMeanError=False,
        parameters={"ppd": _PIXELS_PER_DEGREE, **fixed},
    )
    found[box] = errors[..., 0]
    return found


def _around(differs: npt.NDArray[np.bool_]) -> slice:
    """Return the range of places whose error, or whose neighbor's, may not be zero."""
    places = np.flatnonzero(differs)
    # An error reaches as far as a filter, and so does what the filter reads there.
    return slice(max(0, int(places[0]) - 2 * _REACH), int(places[-1]) + 1 + 2 * _REACH)


def _ssim(displayed: tuple[Image, Image]) -> float | None:
    """Return the structural similarity; None if a side is smaller than the window of 11 pixels."""
    import skimage.metrics

    if min(displayed[0].shape[:2]) < _SSIM_WINDOW:
        return None
    truth, guess = (image.astype(np.float64) for image in displayed)
    structural_similarity: Any = skimage.metrics.structural_similarity
    value = structural_similarity(
        truth,
        guess,
        gaussian_weights=True,
        sigma=1.5,
        use_sample_covariance=False,
        data_range=1.0,
        channel_axis=2,
    )
    return float(value)


def _psnr(displayed: tuple[Image, Image]) -> float | None:
    """Return the peak signal-to-noise ratio in decibels; None if the displayed images are equal."""
    error = _rmse(displayed)
    return None if error == 0 else -20 * math.log10(error)


def _rmse(pair: tuple[Image, Image]) -> float:
    """Return the root mean square error over all pixels and channels."""
    reference, test = pair
    difference = test.astype(np.float64) - reference.astype(np.float64)
    return float(np.sqrt((difference**2).mean()))


def _relmse(pair: tuple[Image, Image]) -> float:
    """Return mean((a − b)² / (b² + 1e-2)), with b the reference."""
    truth, guess = (array.astype(np.float64) for array in pair)
    return float(((guess - truth) ** 2 / (truth**2 + _RELATIVE_EPSILON)).mean())

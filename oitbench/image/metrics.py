"""Image metrics behind one guard: what a metric would mis-score in silence never reaches it.

Names carry their parameters. `flip_ldr@67ppd` and `ssim_gauss11_srgb` see the displayed image (one
exposure, clip, sRGB); `flip_hdr@67ppd`, `rmse_lin` and `relmse_lin(eps=1e-2)` see linear radiance.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
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
"""RMSE of a method's total transmittance, for those that have one."""
ORDER_SPREAD_MAX = "order_spread_max_lin"
"""Largest difference that permuting the draws makes to any channel of any pixel."""
ORDER_SPREAD_MEAN = "order_spread_mean_lin"
"""The same, in the mean over channels and pixels."""

HIGHER_IS_BETTER = frozenset({SSIM, PSNR})
NAMES = (FLIP_LDR, FLIP_HDR, SSIM, PSNR, RMSE, RELMSE)

# The viewing conditions of the FLIP papers: 0.7 m from a screen 0.7 m and 3840 pixels wide.
PIXELS_PER_DEGREE = 3840 * math.pi / 180
HDR_STOPS = 2.0
"""HDR-FLIP looks this many stops below and above the scene's exposure, and at it."""
_HDR_IMAGES = 3

_RELATIVE_EPSILON = 1e-2
_SSIM_WINDOW = 11


def count_nonfinite(image: npt.ArrayLike) -> dict[str, int]:
    """Count the pixels that no correct method returns.

    Parameters
    ----------
    image : array, shape (h, w, 3), floating point

    Returns
    -------
    dict
        `nan`, `inf` and `negative`: pixels with at least one such channel; −∞ counts as `inf`.
    """
    pixels = images.check(image)
    infinite = np.isinf(pixels)
    return {
        "nan": int(np.isnan(pixels).any(axis=-1).sum()),
        "inf": int(infinite.any(axis=-1).sum()),
        "negative": int(((pixels < 0) & ~infinite).any(axis=-1).sum()),
    }


def flip_ldr(reference: npt.ArrayLike, test: npt.ArrayLike, exposure: float) -> float | None:
    """Return the mean FLIP error of the displayed images, in [0, 1].

    Parameters
    ----------
    reference, test : array, shape (h, w, 3)
        Linear Rec.709 radiance.
    exposure : float
        Stops.

    Returns
    -------
    float or None
        None if a pixel of either image is not finite.

    References
    ----------
    Andersson et al., "FLIP: A Difference Evaluator for Alternating Images", HPG 2020.
    """
    pair = _pair(reference, test)
    return None if pair is None else _mean(_ldr_map(*pair, exposure))


def flip_hdr(
    reference: npt.ArrayLike, test: npt.ArrayLike, start: float, stop: float
) -> float | None:
    """Return the mean HDR-FLIP error over the exposures `start` … `stop`, in [0, 1].

    Parameters
    ----------
    reference, test : array, shape (h, w, 3)
        Linear Rec.709 radiance; negative values are taken as zero, which the metric asks for.
    start, stop : float
        Stops, pinned by the caller. Automatic exposures are never used: they follow from the
        reference's median, break where that is zero, and end the process where all is black.

    Returns
    -------
    float or None
        None if a pixel of either image is not finite.

    References
    ----------
    Andersson et al., "Visualizing Errors in Rendered High Dynamic Range Images", EG 2021.
    """
    pair = _pair(reference, test)
    return None if pair is None else _mean(_hdr_map(*pair, start, stop))


def flip_map(
    reference: npt.ArrayLike, test: npt.ArrayLike, exposure: float, *, hdr: bool = False
) -> Image | None:
    """Return the FLIP error of each pixel, shape (h, w), or None if a pixel is not finite.

    Parameters
    ----------
    reference, test : array, shape (h, w, 3)
        Linear Rec.709 radiance.
    exposure : float
        Stops; for `hdr` the middle of the pinned range.
    hdr : bool
        HDR-FLIP instead of FLIP of the displayed images.
    """
    pair = _pair(reference, test)
    if pair is None:
        return None
    return _hdr_map(*pair, *hdr_range(exposure)) if hdr else _ldr_map(*pair, exposure)


def hdr_range(exposure: float) -> tuple[float, float]:
    """Return the first and last exposure of HDR-FLIP for a scene of that exposure, in stops."""
    return exposure - HDR_STOPS, exposure + HDR_STOPS


def rmse(reference: npt.ArrayLike, test: npt.ArrayLike) -> float | None:
    """Return the root mean square error over all pixels and channels, or None if not finite."""
    pair = _pair(reference, test)
    return None if pair is None else _rmse(*pair)


def relmse(reference: npt.ArrayLike, test: npt.ArrayLike) -> float | None:
    """Return mean((a − b)² / (b² + 1e-2)) with b the reference, or None if not finite."""
    pair = _pair(reference, test)
    if pair is None:
        return None
    truth, guess = (array.astype(np.float64) for array in pair)
    return float(((guess - truth) ** 2 / (truth**2 + _RELATIVE_EPSILON)).mean())


def ssim(reference: npt.ArrayLike, test: npt.ArrayLike, exposure: float) -> float | None:
    """Return the structural similarity of the displayed images; 1 for equal ones.

    Returns
    -------
    float or None
        None if a pixel is not finite, or a side is below the window's 11 pixels.

    References
    ----------
    Wang et al., "Image Quality Assessment", IEEE TIP 2004: Gaussian window, σ = 1.5.
    """
    import skimage.metrics

    pair = _pair(reference, test)
    if pair is None or min(pair[0].shape[:2]) < _SSIM_WINDOW:
        return None
    truth, guess = (images.to_srgb(array, exposure).astype(np.float64) for array in pair)
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


def psnr(reference: npt.ArrayLike, test: npt.ArrayLike, exposure: float) -> float | None:
    """Return the peak signal-to-noise ratio of the displayed images, in decibels.

    Returns
    -------
    float or None
        None if a pixel is not finite, or if the displayed images are equal (no finite ratio).
    """
    pair = _pair(reference, test)
    if pair is None:
        return None
    error = _rmse(*(images.to_srgb(array, exposure) for array in pair))
    return None if error == 0 else -20 * math.log10(error)


def rmse_transmittance(reference: npt.ArrayLike, test: npt.ArrayLike) -> float | None:
    """Return the root mean square error between two images of total transmittance.

    Parameters
    ----------
    reference, test : array, shape (h, w) or (h, w, 3), floating point
        A grey `test` is held against the mean of the reference's channels.

    Returns
    -------
    float or None
        None if a value is not finite.
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
    """Return how far images of one scene are apart whose draws were submitted in other orders.

    Parameters
    ----------
    permuted : iterable of array, shape (h, w, 3)
        Looked at one after another, so that a generator needs no memory for all.

    Returns
    -------
    dict
        `ORDER_SPREAD_MAX` and `ORDER_SPREAD_MEAN` of each channel's greatest less its least value;
        None with fewer than two images, or if a pixel is not finite.
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
    # NaN survives minimum and maximum; equal infinities must not pass for no spread.
    known = bool(np.isfinite(low).all() and np.isfinite(high).all())
    spread = high.astype(np.float64) - low if known else None
    return {
        ORDER_SPREAD_MAX: None if spread is None else float(spread.max()),
        ORDER_SPREAD_MEAN: None if spread is None else float(spread.mean()),
    }


def compare(
    reference: npt.ArrayLike,
    test: npt.ArrayLike,
    exposure: float,
    hdr_exposures: tuple[float, float] | None = None,
) -> dict[str, float | None]:
    """Return every metric of `test` against `reference` by name.

    Parameters
    ----------
    reference, test : array, shape (h, w, 3), floating point
        Linear Rec.709 radiance of one size.
    exposure : float
        The scene's exposure in stops.
    hdr_exposures : (float, float), optional
        First and last exposure of HDR-FLIP; `hdr_range(exposure)` without.

    Returns
    -------
    dict of str to float or None
        None where a metric has no finite value: for all of them if any pixel is not finite.

    Raises
    ------
    TypeError, ValueError
        If an image is not [h, w, 3] of floats, or the sizes differ.
    """
    start, stop = hdr_range(exposure) if hdr_exposures is None else hdr_exposures
    return {
        FLIP_LDR: flip_ldr(reference, test, exposure),
        FLIP_HDR: flip_hdr(reference, test, start, stop),
        SSIM: ssim(reference, test, exposure),
        PSNR: psnr(reference, test, exposure),
        RMSE: rmse(reference, test),
        RELMSE: relmse(reference, test),
    }


def _pair(reference: npt.ArrayLike, test: npt.ArrayLike) -> tuple[Image, Image] | None:
    """Return both images checked, or None if they hold what no metric can score."""
    truth = images.check(reference, "reference")
    guess = images.check(test, "test image")
    if truth.shape != guess.shape:
        raise ValueError(f"reference is {truth.shape} but the test image is {guess.shape}")
    return (truth, guess) if np.isfinite(truth).all() and np.isfinite(guess).all() else None


def _mean(errors: Image) -> float | None:
    mean = float(errors.mean(dtype=np.float64))
    return mean if math.isfinite(mean) else None


def _rmse(reference: Image, test: Image) -> float:
    difference = test.astype(np.float64) - reference.astype(np.float64)
    return float(np.sqrt((difference**2).mean()))


def _ldr_map(reference: Image, test: Image, exposure: float) -> Image:
    truth, guess = (images.to_srgb(image, exposure) for image in (reference, test))
    return _evaluate(truth, guess, "LDR", {})


def _hdr_map(reference: Image, test: Image, start: float, stop: float) -> Image:
    if not start < stop:
        raise ValueError(f"HDR-FLIP needs start < stop, not {start} and {stop}")
    pinned = {
        "startExposure": float(start),
        "stopExposure": float(stop),
        "numExposures": _HDR_IMAGES,
    }
    truth, guess = (np.maximum(image, np.float32(0)) for image in (reference, test))
    return _evaluate(truth, guess, "HDR", pinned)


def _evaluate(reference: Image, test: Image, kind: str, pinned: Mapping[str, float]) -> Image:
    import flip_evaluator

    errors, _, _ = flip_evaluator.evaluate(
        np.ascontiguousarray(reference),
        np.ascontiguousarray(test),
        kind,
        inputsRGB=True,  # The evaluator's name for "sRGB-encoded"; it ignores this for HDR.
        applyMagma=False,
        computeMeanError=False,
        parameters={"ppd": PIXELS_PER_DEGREE, **pinned},
    )
    return np.array(errors[..., 0], dtype=np.float32)

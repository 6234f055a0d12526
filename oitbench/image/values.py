"""Pictures of values that need not be light: how they are displayed, and their files.

The `Show` of values is the rule by which they become a picture; the picture's text states the
range. In all of them, values beyond the range are clipped, and NaN is magenta.
"""

from __future__ import annotations

import enum
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from oitbench.atomic import replacing
from oitbench.image.files import Image, mark_nonfinite, to_srgb, write_channels

Values = npt.NDArray[Any]
"""float32 or uint32, shape (h, w, components), top row first, one to four components."""
_PART = 99.5
"""Percent of the nonzero values that lie in the range of a picture, since few may be huge."""
_NEAREST, _FARTHEST = 1.0, 0.2
_CHANNEL_NAMES = {2: ("R", "G"), 3: ("RGB",), 4: ("RGBA",)}


class Show(enum.Enum):
    """The rule by which values become a picture; see `picture`."""

    LIGHT = "light"
    """Radiance: at the scene's exposure, sRGB-encoded."""
    SUM = "sum"
    """Sums of radiance of any scale: from black to white, sRGB-encoded."""
    FRACTION = "fraction"
    """Numbers in [0, 1]: sRGB-encoded."""
    AMOUNT = "amount"
    """Numbers that are not negative: from black for 0 to white, linear; others as `SIGNED`."""
    SIGNED = "signed"
    """Numbers of both signs: around middle gray, linear."""
    DEPTH = "depth"
    """Reversed depth: from dark gray for the farthest to white for the nearest; none is black."""
    MOMENTS = "moments"
    """The first component as an amount; the others are powers of it, or its weight."""


@dataclass(frozen=True)
class Picture:
    """A picture of values for display.

    Parameters
    ----------
    srgb : array, shape (h, w, 3), float32 in [0, 1]
    text : str
        The range, such as "black 0, white 31.2 px".
    """

    srgb: Image
    text: str


def picture(values: Values, show: Show, exposure: float = 0.0, unit: str = "") -> Picture:
    """Return the picture of values.

    One component gives gray; of two, the first is red and the second green; a fourth is left out.

    Parameters
    ----------
    values : array, shape (h, w, components)
    show : Show
    exposure : float
        Stops, for `Show.LIGHT`.
    unit : str
        Of the values, for the text.
    """
    shown = np.asarray(values, dtype=np.float32)[..., : 1 if show is Show.MOMENTS else 3]
    unit = f" {unit}" if unit else ""
    if show is Show.LIGHT:
        return Picture(_colors(to_srgb(shown, exposure)), f"exposure {exposure:+g} stops")
    if show is Show.FRACTION:
        return Picture(_colors(to_srgb(shown, 0.0)), "black 0, white 1, sRGB")
    if show is Show.DEPTH:
        return _depths(shown)
    largest = _largest(shown)
    if show is Show.SUM:
        encoded = to_srgb(shown / largest, 0.0)
        return Picture(_colors(encoded), f"black 0, white {largest:.4g}{unit}, sRGB")
    if show is Show.SIGNED or (shown < 0).any():
        text = f"gray 0, black −{largest:.4g}{unit}, white +{largest:.4g}{unit}"
        return Picture(_colors(0.5 + 0.5 * shown / largest, empty=0.5), text)
    return Picture(_colors(shown / largest), f"black 0, white {largest:.4g}{unit}")


def _depths(inverse: Image) -> Picture:
    covered = inverse[np.isfinite(inverse) & (inverse > 0)]
    if not covered.size:
        return Picture(_colors(inverse * 0), "black: nothing is there")
    low, high = float(covered.min()), float(covered.max())
    part = (inverse - low) / (high - low) if high > low else np.ones_like(inverse)
    gray = np.where(inverse > 0, _FARTHEST + (_NEAREST - _FARTHEST) * part, inverse)
    text = f"black: nothing; dark gray {low:.4g} to white {high:.4g} (reversed depth)"
    return Picture(_colors(gray), text)


def _largest(values: Image) -> float:
    """Return the magnitude below which nearly all values that are not zero lie; 1 if all are."""
    sizes = np.abs(values[np.isfinite(values) & (values != 0)])
    return float(np.percentile(sizes, _PART, method="higher")) if sizes.size else 1.0


def _colors(levels: npt.ArrayLike, empty: float = 0.0) -> Image:
    """Return display values as (h, w, 3); `empty` is the level of a component that is absent."""
    array = np.asarray(levels, dtype=np.float32)
    if array.shape[-1] == 1:
        array = np.repeat(array, 3, axis=-1)
    elif array.shape[-1] == 2:
        array = np.concatenate([array, np.full_like(array[..., :1], empty)], axis=-1)
    return mark_nonfinite(np.clip(array, 0, 1))


def write_values(path: Path | str, values: Values, *, depth: bool = False) -> None:
    """Write values as they are to an OpenEXR file: 32-bit floats or unsigned integers.

    The channels are Z for depths, else Y for one component, R and G for two, RGB or RGBA.

    Parameters
    ----------
    path : path
        Missing folders are created.
    values : array, shape (h, w, components)
    depth : bool

    Raises
    ------
    StorageError
        If the file cannot be written.
    """
    count = values.shape[-1]
    if count == 1:
        channels = {"Z" if depth else "Y": values[..., 0]}
    elif count == 2:
        channels = {name: values[..., k] for k, name in enumerate(_CHANNEL_NAMES[2])}
    else:
        channels = {_CHANNEL_NAMES[count][0]: values}
    with replacing(Path(path)) as partial:
        write_channels(partial, channels)

"""The texture filter that both renderers share: premultiplied mip pyramids and a lookup rule.

A textured property P of a surface is filtered together with the texture of its coverage, and
premultiplied: (α·P, α). Filtered separately, the color of uncovered texels would bleed into covered
ones. A constant value of a material is a factor on the filtered one.

From one level to the next, a side of n texels becomes one of ⌊n/2⌋, at least 1. A new texel is the
mean of the old ones over the same area: of 2 × 2 texels if n is even. If n is odd, it is as wide as
2 + 1/⌊n/2⌋ of them, which count by the part of them that it covers.

Where a material has a cutoff, both α·P and α of a level are scaled so that the fraction of the
texture whose α reaches the cutoff is that of the finest level: by means alone, leaves would become
thinner or thicker at a distance.

The lookup rule: let `dx` and `dy` be the derivatives of uv × size per sub-pixel, in texels. Then
`lod = clamp(½·log2(max(dx·dx, dy·dy)), 0, levels − 1)`. The lookup is bilinear in the levels ⌊lod⌋
and ⌊lod⌋ + 1, with texel centers at + ½, and linear between the two levels. Beyond [0, 1] a
coordinate is clamped to the edge, or first folded back (`Wrap.MIRROR`), or wraps around
(`Wrap.REPEAT`: the first texel is the neighbor of the last one).
"""

from __future__ import annotations

from collections.abc import Hashable, Iterable
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from oitbench.scene.material import Material, Texture, Wrap
from oitbench.scene.vectors import RGB, WHITE, Array, Floats


class Images(NamedTuple):
    """Textures that are filtered together; None where the value is a constant.

    Parameters
    ----------
    color : Texture or None
        Of a property of the surface.
    coverage : Texture or None
    cutoff : float, optional
        Of the coverage.
    """

    color: Texture | None
    coverage: Texture | None
    cutoff: float | None = None

    @property
    def present(self) -> list[Texture]:
        """Those that are not None."""
        return [one for one in (self.color, self.coverage) if one is not None]

    @property
    def wrap(self) -> tuple[Wrap, Wrap]:
        """How they continue beyond their edges; `Material` sees to it that they agree."""
        return self.present[0].wrap


_MANY = 128
"""Sides of more texels have the middles of enough of them."""
SLOTS = ("emission", "albedo", "transmission", "roughness")
"""Properties that are filtered together with coverage, each in a pyramid of its own. That of
emission is there if only coverage has a texture, too."""


def images_of(material: Material) -> dict[str, Images]:
    """Return the textures of a material by slot."""
    coverage = material.coverage if isinstance(material.coverage, Texture) else None
    cutoff = None if coverage is None else material.cutoff
    found = {}
    for slot in SLOTS:
        value = getattr(material, slot)
        color = value if isinstance(value, Texture) else None
        if color is not None or (slot == "emission" and coverage is not None):
            found[slot] = Images(color, coverage, cutoff)
    return found


def constant(value: RGB | Texture) -> RGB:
    """Return the factor of a material on a texture, or its value if it has none."""
    return WHITE if isinstance(value, Texture) else value


def constants_of(material: Material) -> tuple[RGB, float]:
    """Return the factors of a material on the emission and the coverage of its textures.

    A material of constant emission and coverage has no textures, and its factors are its values.
    Where there is a cutoff, the second one is 1; see `threshold_of`.
    """
    plain = material.cutoff is None and not isinstance(material.coverage, Texture)
    coverage = material.coverage if plain else 1.0
    assert not isinstance(coverage, Texture)
    return constant(material.emission), coverage


def threshold_of(material: Material) -> float:
    """Return the least factor on a material's coverage at which it is drawn; 0 for no cutoff."""
    if material.cutoff is None:
        return 0.0
    whole = 1.0 if isinstance(material.coverage, Texture) else material.coverage
    return material.cutoff / whole if whole > 0 else np.inf


def distinct_images(materials: Iterable[Material]) -> dict[Hashable, Images]:
    """Return the distinct textures of materials by `image_key`, in order of their first use."""
    found = [images for material in materials for images in images_of(material).values()]
    return {image_key(images): images for images in found}


def image_key(images: Images) -> Hashable:
    """Return a key under which equal textures compare equal: by identity."""
    return id(images.color), id(images.coverage), images.cutoff


def premultiplied_pyramid(images: Images) -> list[Array]:
    """Combine the textures of a property and of coverage into one mip pyramid.

    Constants of a material are not in it, so that materials of other constants share it. A texture
    with fewer texels along a side than the other one is first enlarged, by linear interpolation.

    Parameters
    ----------
    images : Images
        At least one is a texture.

    Returns
    -------
    list of array, shape (h, w, 4), float32
        α·P (linear Rec.709) and α. The levels run from the finest down to 1 × 1; the first row of
        each is the top (v = 1). With a cutoff, α may exceed 1.
    """
    color, coverage, cutoff = images
    wrap = images.wrap
    height, width = (max(one.texels.shape[axis] for one in images.present) for axis in (0, 1))
    image = np.ones((height, width, 4), dtype=np.float32)
    if coverage is not None:
        image[..., 3] = _enlarged(coverage.texels, (height, width), wrap)
    if color is not None:
        texels = _enlarged(color.texels, (height, width), wrap)
        image[..., :3] = texels[..., None] if texels.ndim == 2 else texels
    image[..., :3] *= image[..., 3:]
    levels = [image]
    while levels[-1].shape[:2] != (1, 1):
        levels.append(_halved(levels[-1]))
    if cutoff is not None:
        shown = _fraction_above(levels[0][..., 3], cutoff, wrap)
        levels[1:] = [_with_fraction(level, shown, cutoff, wrap) for level in levels[1:]]
    return levels


def _fraction_above(coverage: Array, cutoff: float, wrap: tuple[Wrap, Wrap]) -> float:
    return float((_sampled(coverage, wrap) >= cutoff).mean())


def _with_fraction(image: Array, shown: float, cutoff: float, wrap: tuple[Wrap, Wrap]) -> Array:
    """Scale a level so that about the fraction `shown` of its coverage reaches the cutoff."""
    values, counts = np.unique(_sampled(image[..., 3], wrap), return_counts=True)
    # The fraction that is left if values from the first, second, … on reach the cutoff, or none.
    left = 1 - np.concatenate([[0], np.cumsum(counts)]) / counts.sum()
    best = int(np.abs(left - shown).argmin())
    limits = np.concatenate([values[:1] / 2, values, 2 * values[-1:]]).astype(np.float64)
    border = (limits[best] + limits[best + 1]) / 2
    return image if border <= 0 else (image * (cutoff / border)).astype(np.float32)


def _sampled(coverage: Array, wrap: tuple[Wrap, Wrap]) -> Array:
    """Return coverage as it is interpolated; the middles of many texels are enough."""
    size = [side if side > _MANY else 4 * side for side in coverage.shape]
    return _enlarged(coverage, (size[0], size[1]), wrap)


def _enlarged(texels: Array, size: tuple[int, int], wrap: tuple[Wrap, Wrap]) -> Array:
    """Return texels at the centers of those of a larger size, by linear interpolation."""
    for axis, count in enumerate(size):
        if texels.shape[axis] != count:
            centers = (np.arange(count) + 0.5) / count
            low, high, part = _neighbors(centers, texels.shape[axis], wrap[1 - axis])
            one, other = (np.take(texels, index, axis=axis) for index in (low, high))
            part = part.reshape([-1 if axis == k else 1 for k in range(texels.ndim)])
            texels = (one + part * (other - one)).astype(np.float32)
    return texels


def _halved(image: Array) -> Array:
    """Return the next mip level: means over blocks of texels, which are wider for odd sides."""
    halved: Floats | Array = image
    for axis in (0, 1):
        count = halved.shape[axis]
        half = max(1, count // 2)
        texels = np.moveaxis(halved, axis, 0)
        if count % 2 == 0:
            mean = np.add(texels[0::2], texels[1::2], dtype=np.float64) / 2
        elif count == 1:
            mean = texels.astype(np.float64)
        else:
            place = np.arange(half).reshape(-1, 1, 1)
            parts = (half - place) / count, half / count, (place + 1) / count
            three = texels[0:-1:2], texels[1::2], texels[2::2]
            mean = sum(part * one for part, one in zip(parts, three, strict=True))
        halved = np.moveaxis(mean, 0, axis)
    return halved.astype(np.float32)


def level_of_detail(dx: npt.ArrayLike, dy: npt.ArrayLike, levels: int) -> Floats:
    """Return the fractional mip level for a pixel's footprint.

    Parameters
    ----------
    dx, dy : array, shape (..., 2)
        Derivatives of uv × size, in texels, per sub-pixel to the right and down.
    levels : int
        Number of levels of the pyramid.

    Returns
    -------
    array, shape (...), float64
        In [0, levels − 1].
    """
    squares = [(np.asarray(side, dtype=np.float64) ** 2).sum(axis=-1) for side in (dx, dy)]
    widest = np.maximum(np.maximum(*squares), np.finfo(np.float64).tiny)
    return np.asarray(np.clip(0.5 * np.log2(widest), 0, levels - 1))


def lookup(
    pyramid: list[Array],
    uv: npt.ArrayLike,
    lod: npt.ArrayLike,
    wrap: tuple[Wrap, Wrap] = (Wrap.CLAMP, Wrap.CLAMP),
) -> Floats:
    """Look up a pyramid by the rule of this module; the reference for both renderers.

    Parameters
    ----------
    pyramid : list of array, shape (h, w, 4)
    uv : array, shape (n, 2)
        v = 1 is the top row.
    lod : array, shape (n,)
        From `level_of_detail`.
    wrap : (Wrap, Wrap)

    Returns
    -------
    array, shape (n, 4), float64
        α·P and α.
    """
    coordinates = np.asarray(uv, dtype=np.float64)
    detail = np.asarray(lod, dtype=np.float64)
    lower = np.floor(detail).astype(int)
    result = np.empty((len(coordinates), 4))
    for level in range(len(pyramid)):
        for which, part in ((lower, 1 - (detail - lower)), (lower + 1, detail - lower)):
            chosen = np.minimum(which, len(pyramid) - 1) == level
            found = part[chosen, None] * _bilinear(pyramid[level], coordinates[chosen], wrap)
            result[chosen] = found if which is lower else result[chosen] + found
    return result


def _bilinear(image: Array, uv: Floats, wrap: tuple[Wrap, Wrap]) -> Floats:
    height, width = image.shape[:2]
    left, right, across = _neighbors(uv[:, 0], width, wrap[0])
    # Rows run down, and v runs up.
    top, bottom, down = _neighbors(1 - uv[:, 1], height, wrap[1])
    across, down = across[:, None], down[:, None]
    upper = image[top, left] * (1 - across) + image[top, right] * across
    lower = image[bottom, left] * (1 - across) + image[bottom, right] * across
    return np.asarray(upper * (1 - down) + lower * down)


def _neighbors(
    place: Floats, count: int, wrap: Wrap
) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.int64], Floats]:
    """Return the two texels around places on an axis, and the part of the second one."""
    if wrap is Wrap.REPEAT:
        at = (place - np.floor(place)) * count - 0.5
        low = np.floor(at).astype(np.int64)
        return low % count, (low + 1) % count, at - low
    if wrap is Wrap.MIRROR:
        place = np.abs(place - 2 * np.round(place / 2))
    at = np.clip(place * count, 0.5, count - 0.5) - 0.5
    low = at.astype(np.int64)
    return low, np.minimum(low + 1, count - 1), at - low

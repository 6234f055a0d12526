"""The texture filter that both renderers share: premultiplied mip pyramids and a lookup rule.

A textured property P of a surface is filtered together with the texture of its coverage, and
premultiplied: (α·P, α). Filtered separately, the color of uncovered texels would bleed into covered
ones. A constant value of a material is a factor on the filtered one.

From one level to the next, a side of n texels becomes one of ⌊n/2⌋, at least 1. A new texel is the
mean of the old ones over the same area: of 2 × 2 texels if n is even. If n is odd, it is as wide as
2 + 1/⌊n/2⌋ of them, which count by the part of them that it covers.

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

from oitbench.errors import SceneError
from oitbench.scene.material import Material, Texture, Wrap
from oitbench.scene.vectors import RGB, WHITE, Array, Floats


class Images(NamedTuple):
    """Textures that are filtered together; None where the value is a constant.

    Parameters
    ----------
    color : Texture or None
        Of emission.
    coverage : Texture or None
    """

    color: Texture | None
    coverage: Texture | None

    @property
    def present(self) -> list[Texture]:
        """Those that are not None."""
        return [one for one in self if one is not None]

    @property
    def wrap(self) -> tuple[Wrap, Wrap]:
        """How they continue beyond their edges.

        Raises
        ------
        SceneError
            If they disagree.
        """
        found = {one.wrap for one in self.present}
        if len(found) > 1:
            names = " and ".join(sorted("/".join(one.value for one in pair) for pair in found))
            raise SceneError(f"material: its textures have the wraps {names}; give them one")
        return found.pop()


def images_of(material: Material) -> Images | None:
    """Return the textures of a material, or None if it has none."""
    emission, coverage = (
        value if isinstance(value, Texture) else None
        for value in (material.emission, material.coverage)
    )
    return None if emission is None and coverage is None else Images(emission, coverage)


def constants_of(material: Material) -> tuple[RGB, float]:
    """Return the factors of a material on the emission and the coverage of its textures.

    A material of constant emission and coverage has no textures, and its factors are its values.
    """
    emission: RGB = WHITE if isinstance(material.emission, Texture) else material.emission
    coverage = 1.0 if isinstance(material.coverage, Texture) else material.coverage
    return emission, coverage


def distinct_images(materials: Iterable[Material]) -> dict[Hashable, Images]:
    """Return the distinct textures of materials by `image_key`, in order of their first use."""
    found = (images_of(material) for material in materials)
    return {image_key(images): images for images in found if images is not None}


def image_key(images: Images) -> Hashable:
    """Return a key under which equal pairs of textures compare equal: by identity."""
    return tuple(map(id, images))


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
        each is the top (v = 1).
    """
    color, coverage = images
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
    return levels


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
    halved = image.astype(np.float64)
    for axis in (0, 1):
        count = halved.shape[axis]
        half = max(1, count // 2)
        texels = np.moveaxis(halved, axis, 0)
        if count % 2 == 0:
            mean = (texels[0::2] + texels[1::2]) / 2
        elif count == 1:
            mean = texels
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

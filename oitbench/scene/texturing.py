"""The texture filter that both renderers share: a premultiplied mip pyramid and a lookup rule.

Emission and coverage are filtered together and premultiplied, (α·L, α). Filtered separately, the
color of uncovered texels would bleed into covered ones. A material's constant emission or coverage
is a factor on the filtered value.

The lookup rule: let `dx` and `dy` be the derivatives of uv × size per sub-pixel, in texels. Then
`lod = clamp(½·log2(max(dx·dx, dy·dy)), 0, levels − 1)`. The lookup is bilinear in the levels ⌊lod⌋
and ⌊lod⌋ + 1, with texel centers at + ½ and coordinates clamped to the edge, and linear between the
two levels.
"""

from __future__ import annotations

from collections.abc import Hashable, Iterable

import numpy as np
import numpy.typing as npt

from oitbench.errors import SceneError
from oitbench.scene.material import Material, Texture
from oitbench.scene.vectors import RGB, WHITE, Array, Floats

Images = tuple[Texture | None, Texture | None]
"""The textures of a material's emission and coverage; None where the value is a constant."""


def images_of(material: Material) -> Images | None:
    """Return the textures of a material, or None if it has none."""
    emission, coverage = (
        value if isinstance(value, Texture) else None
        for value in (material.emission, material.coverage)
    )
    return None if emission is None and coverage is None else (emission, coverage)


def constants_of(material: Material) -> tuple[RGB, float]:
    """Return the factors of a material on the emission and the coverage of its textures.

    A material of constant emission and coverage has no textures, and its factors are its values.
    """
    emission, coverage = material.emission, material.coverage
    return (
        WHITE if isinstance(emission, Texture) else emission,
        1.0 if isinstance(coverage, Texture) else coverage,
    )


def distinct_images(materials: Iterable[Material]) -> dict[Hashable, Images]:
    """Return the pairs of textures of all materials that have some, by `image_key`."""
    found = (images_of(material) for material in materials)
    return {image_key(images): images for images in found if images is not None}


def image_key(images: Images) -> Hashable:
    """Return a key under which equal pairs of textures compare equal: by identity."""
    return tuple(map(id, images))


def premultiplied_pyramid(images: Images) -> list[Array]:
    """Combine the textures of emission and coverage into one box-filtered mip pyramid.

    Constants of a material are not in it, so that materials of other constants share it.

    Parameters
    ----------
    images : pair of Texture or None
        Of emission and of coverage; None counts as one. At least one is a texture.

    Returns
    -------
    list of array, shape (h, w, 4), float32
        α·L (linear Rec.709) and α. The levels run from the finest down to 1 × 1; the first row of
        each is the top (v = 1).

    Raises
    ------
    SceneError
        If the two textures differ in size.
    """
    emission, coverage = images
    sizes = {item.texels.shape[:2] for item in images if item is not None}
    if len(sizes) > 1:
        found = " and ".join(f"{width}x{height}" for height, width in sorted(sizes))
        raise SceneError(f"material: its textures are {found}; give emission and coverage one size")
    (size,) = sizes
    image = np.ones((*size, 4), dtype=np.float32)
    if coverage is not None:
        image[..., 3] = coverage.texels
    color = np.ones((1, 1, 3), dtype=np.float32) if emission is None else emission.texels
    image[..., :3] = (color[..., None] if color.ndim == 2 else color) * image[..., 3:]
    levels = [image]
    while levels[-1].shape[:2] != (1, 1):
        levels.append(_halve(levels[-1]))
    return levels


def _halve(image: Array) -> Array:
    """Average blocks of 2 × 2 texels, or pairs of texels if one side is already one texel."""
    height, width, channels = image.shape
    tall, wide = min(2, height), min(2, width)
    blocks = image.reshape(height // tall, tall, width // wide, wide, channels)
    halved: Array = blocks.mean(axis=(1, 3), dtype=np.float64).astype(np.float32)
    return halved


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


def lookup(pyramid: list[Array], uv: npt.ArrayLike, lod: npt.ArrayLike) -> Floats:
    """Look up a pyramid by the rule of this module; the reference for both renderers.

    Parameters
    ----------
    pyramid : list of array, shape (h, w, 4)
    uv : array, shape (n, 2)
        v = 1 is the top row.
    lod : array, shape (n,)
        From `level_of_detail`.

    Returns
    -------
    array, shape (n, 4), float64
        α·L and α.
    """
    coordinates = np.asarray(uv, dtype=np.float64)
    detail = np.asarray(lod, dtype=np.float64)
    lower = np.floor(detail).astype(int)
    result = np.empty((len(coordinates), 4))
    for index, (point, level) in enumerate(zip(coordinates, lower, strict=True)):
        fraction = detail[index] - level
        fine = _bilinear(pyramid[level], point)
        coarse = _bilinear(pyramid[min(level + 1, len(pyramid) - 1)], point)
        result[index] = (1 - fraction) * fine + fraction * coarse
    return result


def _bilinear(image: Array, uv: Floats) -> Floats:
    height, width = image.shape[:2]
    x = np.clip(uv[0] * width, 0.5, width - 0.5) - 0.5
    y = np.clip((1 - uv[1]) * height, 0.5, height - 0.5) - 0.5
    left, top = int(x), int(y)
    right, bottom = min(left + 1, width - 1), min(top + 1, height - 1)
    upper = image[top, left] * (left + 1 - x) + image[top, right] * (x - left)
    lower = image[bottom, left] * (left + 1 - x) + image[bottom, right] * (x - left)
    return np.asarray(upper * (top + 1 - y) + lower * (y - top))

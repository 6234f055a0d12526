"""Materials and textures: how a surface covers, transmits, emits and reflects light.

A new property is a field of `Material`. Both renderers must then implement it, in `oitbench/gl` and
in `oitbench/path_traced`. If it is a new effect, `model._requested_effects` must derive it.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

import numpy as np

from oitbench.scene.checks import require, require_finite, require_fractions, require_light
from oitbench.scene.vectors import BLACK, RGB, Array

LEAST_LOBE = 0.1
"""Least roughness of the lobe in which a surface reflects a beam, which would be a point to a
mirror. Half of the lobe's peak is reached 0.7° from its middle: beams look like lamps as wide."""


class Wrap(str, Enum):
    """How a texture continues beyond [0, 1] of a texture coordinate."""

    CLAMP = "clamp"
    """Its edge goes on."""
    REPEAT = "repeat"
    """It begins anew."""
    MIRROR = "mirror"
    """It begins anew, every second time mirrored."""


@dataclass(frozen=True, eq=False)
class Texture:
    """An image over the texture coordinates uv ∈ [0, 1]².

    Parameters
    ----------
    texels : array, shape (h, w) or (h, w, 3), float32
        One channel for coverage, roughness or gray light, three for colors. The first row is at
        v = 1 (top). Any size will do.
    wrap : (Wrap, Wrap)
        How it continues to the sides (u), and up and down (v).

    Raises
    ------
    SceneError
        If `texels` has a wrong shape, no texel, or a value that is not finite.
    """

    texels: Array
    wrap: tuple[Wrap, Wrap] = (Wrap.CLAMP, Wrap.CLAMP)

    def __post_init__(self) -> None:
        shape = self.texels.shape
        require(
            len(shape) == 2 or (len(shape) == 3 and shape[2] == 3),
            f"texture: texels are {shape}; give (h, w) for one channel or (h, w, 3) for colors",
        )
        require(self.texels.size > 0, f"texture: texels are {shape}; give one texel or more")
        require_finite("texture", texels=self.texels)
        known = [isinstance(wrap, Wrap) for wrap in self.wrap]
        names = ", ".join(map(str, Wrap.__members__))
        require(known == [True, True], f"texture: wrap is {self.wrap}; give two Wrap of {names}")


@dataclass(frozen=True, eq=False)
class Material:
    """How a surface covers, transmits, emits and reflects light.

    The covered part of the surface reflects by Lambert's law and by a microfacet lobe (GGX) with
    Schlick's Fresnel term F. It transmits t = T (1 − F) (1 − albedo), because reflected light is
    lost to transmission (McGuire & Mara 2017, "Phenomenological Transparency", section 4.1).

    Parameters
    ----------
    coverage : float or Texture
        Fraction α of the surface that is covered, in [0, 1]. Light passes the rest unchanged.
    transmission : RGB
        Fraction T of the light that passes the covered part at normal incidence if nothing is
        reflected, per channel in [0, 1].
    emission : RGB or Texture
        Radiance L that leaves the covered part, W·sr⁻¹·m⁻² on the scene's arbitrary scale.
    albedo : RGB
        Diffuse reflectance under the scene's lights, on the visible side, per channel in [0, 1].
    specular : float, optional
        Reflectance F₀ of the microfacet lobe at normal incidence, in [0, 1]. Default: that of the
        refractive index, ((N − 1)/(N + 1))².
    roughness : float
        Roughness of the microfacet lobe, in [0, 1]: the square root of GGX's α. At 0 the surface is
        a mirror. Directional and spot lights are reflected with `LEAST_LOBE` or more.
    index : float
        Refractive index N of the inside, at least 1; 1 does not refract. A thin sheet uses it only
        for its reflectance and does not refract.
    collimation : float
        c in [0, 1]: 1 passes light in a beam, 0 spreads all of it.
    solid : bool
        True for the boundary of a closed solid with outward normals, False for a thin sheet.
    isotropic : bool
        True for particles, which have no normal: they scatter light equally to all sides
        (albedo / 4π) instead of by Lambert's law.
    binary_coverage : bool
        True for foliage whose unfiltered coverage is 0 or 1 and that transmits nothing.

    Raises
    ------
    SceneError
        If a value is not finite or out of range.
    """

    coverage: float | Texture = 1.0
    transmission: RGB = BLACK
    emission: RGB | Texture = BLACK
    albedo: RGB = BLACK
    specular: float | None = None
    roughness: float = 1.0
    index: float = 1.0
    collimation: float = 1.0
    solid: bool = False
    isotropic: bool = False
    binary_coverage: bool = False

    def __post_init__(self) -> None:
        coverage = self.coverage.texels if isinstance(self.coverage, Texture) else self.coverage
        emission = self.emission.texels if isinstance(self.emission, Texture) else self.emission
        require_light("material", emission=emission)
        require_finite("material", index=self.index)
        require_fractions(
            "material", coverage=coverage, transmission=self.transmission, albedo=self.albedo,
            specular=self.reflectance, roughness=self.roughness, collimation=self.collimation,
        )  # fmt: skip
        require(np.ndim(coverage) in (0, 2), "material: coverage has colors; give texels (h, w)")
        require(self.index >= 1, f"material: index is {self.index}; it must be at least 1 (vacuum)")

    @property
    def opaque(self) -> bool:
        """Whether no light passes: coverage is the number one, not a texture, and T is zero."""
        return self.coverage == 1.0 and self.transmission == BLACK

    @property
    def reflectance(self) -> float:
        """Reflectance F₀ of the microfacet lobe at normal incidence."""
        if self.specular is not None:
            return self.specular
        return ((self.index - 1) / (self.index + 1)) ** 2

    @property
    def tints(self) -> bool:
        """Whether the transmitted fraction differs between channels."""
        red, green, blue = (
            t * (1 - k) for t, k in zip(self.transmission, self.albedo, strict=True)
        )
        return not red == green == blue

    @property
    def refracts(self) -> bool:
        """Whether transmitted light changes its direction, as at the boundary of a solid."""
        return self.solid and self.index != 1

"""Materials and textures: how a surface covers, transmits, emits and reflects light.

A new property is a field of `Material`. Both renderers must then implement it, in `oitbench/gl` and
in `oitbench/path_traced`. If it is a new effect, `model._requested_effects` must derive it.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from functools import cached_property

import numpy as np

from oitbench.scene.checks import require, require_finite, require_fractions, require_light
from oitbench.scene.vectors import BLACK, RGB, Array

LEAST_LOBE = 0.1
"""Least roughness of the lobe in which a surface reflects a beam, which would be a point to a
mirror. Half of the lobe's peak is reached 0.7° from its middle: beams look like lamps as wide."""


TEXTURED = ("emission", "coverage", "albedo", "transmission", "roughness")
"""Fields of a material that may be textures."""


class Wrap(str, Enum):
    """How a texture continues beyond [0, 1] of a texture coordinate."""

    CLAMP = "clamp"
    """Its edge goes on."""
    REPEAT = "repeat"
    """It begins anew."""
    MIRROR = "mirror"
    """It begins anew, every second time mirrored."""


WRAPS = tuple(Wrap)
"""By their numbers in the tables of both renderers."""


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
    transmission : RGB or Texture
        Fraction T of the light that passes the covered part at normal incidence if nothing is
        reflected, per channel in [0, 1].
    emission : RGB or Texture
        Radiance L that leaves the covered part, W·sr⁻¹·m⁻² on the scene's arbitrary scale.
    albedo : RGB or Texture
        Diffuse reflectance under the scene's lights, on the visible side, per channel in [0, 1].
    specular : float, optional
        Reflectance F₀ of the microfacet lobe at normal incidence, in [0, 1]. Default: that of the
        refractive index, ((N − 1)/(N + 1))².
    roughness : float or Texture
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
    cutoff : float, optional
        In (0, 1]: filtered coverage below it counts as 0, and as 1 from there on. Default: coverage
        counts as it is.
    culled : bool
        True for surfaces without a back: seen from there, nothing is drawn, and all light passes.

    Raises
    ------
    SceneError
        If a value is not finite or out of range, textures do not go with that of coverage, or a
        refracting solid varies or has holes.
    """

    coverage: float | Texture = 1.0
    transmission: RGB | Texture = BLACK
    emission: RGB | Texture = BLACK
    albedo: RGB | Texture = BLACK
    specular: float | None = None
    roughness: float | Texture = 1.0
    index: float = 1.0
    collimation: float = 1.0
    solid: bool = False
    isotropic: bool = False
    binary_coverage: bool = False
    cutoff: float | None = None
    culled: bool = False

    def __post_init__(self) -> None:
        values = {
            name: value.texels if isinstance(value, Texture) else value
            for name in TEXTURED
            for value in [getattr(self, name)]
        }
        require_light("material", emission=values.pop("emission"))
        require_finite("material", index=self.index)
        require_fractions(
            "material", **values, specular=self.reflectance, collimation=self.collimation,
            cutoff=1.0 if self.cutoff is None else self.cutoff,
        )  # fmt: skip
        for name in ("coverage", "roughness"):
            gray = np.ndim(values[name]) in (0, 2)
            require(gray, f"material: {name} has colors; give texels (h, w)")
        require(self.index >= 1, f"material: index is {self.index}; it must be at least 1 (vacuum)")
        require(self.cutoff != 0, "material: cutoff is 0, which all coverage reaches; leave it out")
        if isinstance(self.coverage, Texture):
            for name in TEXTURED:
                other = getattr(self, name)
                alike = not isinstance(other, Texture) or other.wrap == self.coverage.wrap
                require(alike, f"material: coverage and {name} wrap differently; let them agree")
        if self.refracts and not self.opaque:
            self.require_even("material")

    def require_even(self, owner: str) -> None:
        """Raise `SceneError` if a refracting solid of this material would vary or have holes."""
        whole = self.cutoff is None and not self.culled
        require(whole, f"{owner}: a refracting solid has cutoff or culled; leave them out")
        even = not any(isinstance(one, Texture) for one in (self.albedo, self.transmission))
        require(even, f"{owner}: a refracting solid is even; give one albedo and transmission")

    @property
    def opaque(self) -> bool:
        """Whether no light passes the surface where it is.

        T is the number zero, and coverage is the number one, or has a cutoff: through the holes of
        such a surface light passes beside it.
        """
        covers = self.cutoff is not None or self.coverage == 1.0
        return covers and self.transmission == BLACK

    @property
    def diffuse(self) -> bool:
        """Whether it may reflect light diffusely."""
        return isinstance(self.albedo, Texture) or any(self.albedo)

    @property
    def reflectance(self) -> float:
        """Reflectance F₀ of the microfacet lobe at normal incidence."""
        if self.specular is not None:
            return self.specular
        return ((self.index - 1) / (self.index + 1)) ** 2

    @cached_property
    def tints(self) -> bool:
        """Whether the transmitted fraction may differ between channels."""
        transmission, albedo = self.transmission, self.albedo
        if transmission == BLACK:
            return False
        if isinstance(transmission, Texture) or isinstance(albedo, Texture):
            return not (_is_gray(transmission) and _is_gray(albedo))
        red, green, blue = (t * (1 - k) for t, k in zip(transmission, albedo, strict=True))
        return not red == green == blue

    @property
    def refracts(self) -> bool:
        """Whether transmitted light changes its direction, as at the boundary of a solid."""
        return self.solid and self.index != 1


def _is_gray(value: RGB | Texture) -> bool:
    texels = value.texels if isinstance(value, Texture) else np.asarray(value)
    colored = not isinstance(value, Texture) or texels.ndim == 3
    return not colored or bool((texels == texels[..., :1]).all())

"""Materials and textures: how a surface covers, transmits, emits and reflects light."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from oitbench.scene.checks import require, require_finite

RGB = tuple[float, float, float]
Array = npt.NDArray[np.float32]
BLACK: RGB = (0.0, 0.0, 0.0)
WHITE: RGB = (1.0, 1.0, 1.0)


def is_grey(color: RGB) -> bool:
    """Tell whether the three channels of `color` are equal."""
    return color[0] == color[1] == color[2]


@dataclass(frozen=True, eq=False)
class Texture:
    """A picture wrapped round uv ∈ [0, 1]², clamped at its edges.

    Parameters
    ----------
    texels : array, shape (h, w) or (h, w, 3), float32
        One channel for coverage, three for radiance; the first row is at v = 1 (top). Both sides
        must be powers of two, so that every mip level halves exactly.
    """

    texels: Array

    def __post_init__(self) -> None:
        shape = self.texels.shape
        require(
            len(shape) == 2 or (len(shape) == 3 and shape[2] == 3),
            f"texture: texels are {shape}; give (h, w) for coverage or (h, w, 3) for radiance",
        )
        for side in shape[:2]:
            require(side > 0 and side & (side - 1) == 0, f"texture: side {side} is no power of two")
        require_finite("texture", texels=self.texels)


@dataclass(frozen=True, eq=False)
class Material:
    """How a surface covers, transmits, emits and reflects light.

    Where the surface is, it reflects by Lambert's law and by a microfacet lobe (GGX) with Schlick's
    Fresnel term F, and it transmits t = T (1 − F) (1 − albedo): transmission loses what reflection
    took (McGuire & Mara 2017, section 4.1).

    Parameters
    ----------
    coverage : float or Texture
        Fraction α of the surface that is there at all, in [0, 1].
    transmission : RGB
        Fraction T of the light that passes at normal incidence where the surface is and reflects
        nothing, per channel in [0, 1].
    emission : RGB or Texture
        Radiance L that leaves the covered surface, W·sr⁻¹·m⁻² on an arbitrary scale.
    albedo : RGB
        Diffuse reflectance under the scene's lights, on the side that is seen.
    specular : float, optional
        Reflectance F₀ of the microfacet lobe at normal incidence, in [0, 1]; that of the refractive
        index, ((N − 1)/(N + 1))², without.
    roughness : float
        Width of the microfacet lobe, in [0, 1]: the square root of GGX's α. At 0 the surface is a
        mirror, which shows surroundings but no light that is a point or a direction.
    index : float
        Refractive index N of the inside, 1 for none. Thin sheets reflect by it and bend nothing.
    collimation : float
        c in [0, 1]: 1 passes light in a beam, 0 spreads it all.
    solid : bool
        True for the boundary of a closed solid, with normals that point out of it; False for a thin
        sheet.
    isotropic : bool
        True for particles that scatter light to all sides alike (albedo/4π) rather than by
        Lambert's law, and so have no normal.
    binary_coverage : bool
        True for foliage whose unfiltered coverage is 0 or 1 and that transmits nothing.
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
        require_finite(
            "material", coverage=coverage, emission=emission, transmission=self.transmission,
            albedo=self.albedo, specular=self.specular, roughness=self.roughness, index=self.index,
            collimation=self.collimation,
        )  # fmt: skip
        unit = {
            "coverage": coverage,
            "transmission": self.transmission,
            "albedo": self.albedo,
            "specular": self.reflectance,
            "roughness": self.roughness,
            "collimation": self.collimation,
        }
        for name, value in unit.items():
            values = np.asarray(value)
            require(bool(((values >= 0) & (values <= 1)).all()), f"material: {name} leaves [0, 1]")
        require(bool((np.asarray(emission) >= 0).all()), "material: emission is negative")
        require(self.index >= 1, f"material: index {self.index} is below 1 (that of vacuum)")

    @property
    def opaque(self) -> bool:
        """Whether nothing passes: coverage is one everywhere and transmission zero."""
        return self.coverage == 1.0 and self.transmission == BLACK

    @property
    def reflectance(self) -> float:
        """F₀: what the microfacet lobe reflects at normal incidence."""
        if self.specular is not None:
            return self.specular
        return ((self.index - 1) / (self.index + 1)) ** 2

    @property
    def tints(self) -> bool:
        """Whether what passes differs between channels."""
        passed = [t * (1 - k) for t, k in zip(self.transmission, self.albedo, strict=True)]
        return not passed[0] == passed[1] == passed[2]

    @property
    def refracts(self) -> bool:
        """Whether light that passes leaves in another direction: at the boundary of a solid."""
        return self.solid and self.index != 1

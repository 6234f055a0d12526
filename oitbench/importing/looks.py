"""Formulas that turn materials of files into those of oitbench; CONVENTIONS.md has a table."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from oitbench.scene import RGB, Array, Floats

_GRAY = 0.02
"""Difference between the channels of a metal that counts as gray."""
METAL = (
    "metals: the part of the base color that all channels share is mirrored, the rest is diffuse"
)
"""The note on a metal that scatters what it should mirror."""
VERTICES = "metals mirror the mean of their colors at vertices"
"""The note on a metal whose vertices have several colors."""
PLASTIC = 0.04
"""Reflectance F₀ of a dielectric that states none: that of the refractive index 1.5."""


def transmission_of(passed: Array, albedo: Array) -> Array:
    """Return T of a surface of which a part of the light passes, per channel.

    A file means the transmittance bp and the albedo k = b(1 − p) of a base color b and a part p. As
    oitbench transmits T(1 − k), T is bp/(1 − k), which is never above 1.
    """
    return np.asarray(np.minimum(passed / np.maximum(1 - albedo, 1e-6), 1))


@dataclass(frozen=True, eq=False)
class Divided:
    """What becomes of the light that a base color returns.

    Parameters
    ----------
    albedo, passed : array, shape (3,) or (h, w, 3)
        The parts that are scattered, and transmitted.
    mirrored : float
        F₀ of the metallic parts.
    colored_metal : bool
        Whether a metal scatters what it should mirror.
    """

    albedo: Array
    passed: Array
    mirrored: float
    colored_metal: bool


def divided(
    base: Array, metallic: Array, passing: Array, colors: Array | Floats | None = None
) -> Divided:
    """Divide a base color b between scattering, transmission and reflection.

    A metal mirrors s, the mean of the least channel of b, and scatters the rest, max(b − s, 0),
    because F₀ is a number. What is not metallic scatters b(1 − p) and transmits bp.

    Parameters
    ----------
    base, metallic, passing : array, shape (1 or 3,) or (h, w, 1 or 3)
        Textured ones have one size. `passing` is p.
    colors : array, shape (n, 3), optional
        Colors of the vertices, which are factors on b, and on the parts that are returned.
    """
    # Pictures may have many millions of texels, so nothing is computed that is zero.
    plain = base * (1 - metallic) if metallic.any() else base
    albedo = plain
    if passing.any():
        passed = plain * passing
        albedo = plain - passed
    else:
        passed = np.zeros(3, dtype=np.float32)
    if not metallic.any():
        return Divided(albedo, passed, 0.0, False)
    if colors is None:
        least = base.min(axis=-1, keepdims=True)
        mirrored = float((metallic * least).mean() / metallic.mean())
        taken = np.array([mirrored], dtype=np.float32)
    else:
        metal = (metallic * base).reshape(-1, 3).mean(axis=0) / metallic.mean()
        mirrored = float((metal * colors).min(axis=1).mean())
        # The color of a vertex multiplies what is left, so that it is right at their mean.
        taken = np.asarray(mirrored / np.maximum(colors.mean(axis=0), 1e-6), dtype=np.float32)
    rest = np.maximum(base - taken, 0) * metallic
    return Divided(albedo + rest, passed, mirrored, bool((rest > _GRAY).any()))


def collimation_of(roughness: float, index: float) -> float:
    """Return the collimation c of a transparent surface: 1 − c = 4 (N − 1) r², at most 1.

    A microfacet surface of GGX's α = r² tilts light by (N − 1) times the slope of its facets. The
    path tracer gives a solid of collimation c facets of α = (1 − c) / (4 (N − 1)), and a thin sheet
    a blur of the same variance as a slab with two such faces.
    """
    return float(np.clip(1 - 4 * max(index - 1, 0.0) * roughness**2, 0, 1))


def roughness_of_exponent(exponent: float) -> float:
    """Return the roughness of a lobe cosⁿ about the half vector: α² = 2/(n + 2), r = √α."""
    return float(np.clip((2 / (max(exponent, 0.0) + 2)) ** 0.25, 0, 1))


def color(values: object) -> RGB:
    """Return three numbers as a color."""
    red, green, blue = (float(value) for value in np.asarray(values, dtype=np.float64))
    return red, green, blue

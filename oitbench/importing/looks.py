"""Formulas that turn materials of files into those of oitbench; CONVENTIONS.md has a table."""

from __future__ import annotations

import numpy as np

from oitbench.scene import RGB, Array

PLASTIC = 0.04
"""Reflectance F₀ of a dielectric that states none: that of the refractive index 1.5."""


def transmission_of(base: Array, part: Array) -> Array:
    """Return T and that a surface scatters the rest: of the base color b, the part p passes.

    A file means the transmittance b·p and the albedo k = b·(1 − p), per channel. As oitbench
    transmits T·(1 − k), T is b·p / (1 − b·(1 − p)), which is never above 1.
    """
    scattered = base * (1 - part)
    return np.asarray(np.minimum(base * part / np.maximum(1 - scattered, 1e-6), 1))


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


def reflectance_of(index: float) -> float:
    """Return F₀ of a refractive index."""
    return ((index - 1) / (index + 1)) ** 2


def color(values: object) -> RGB:
    """Return three numbers as a color."""
    red, green, blue = (float(value) for value in np.asarray(values, dtype=np.float64))
    return red, green, blue

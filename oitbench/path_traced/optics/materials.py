"""Physical quantities that the path tracer derives from the materials of a scene.

A scene states the transmission and the collimation of a surface. Refracting solids need an
absorption coefficient and a microfacet roughness instead; frosted sheets need a spread of
directions.
"""

from __future__ import annotations

import math

from oitbench.scene import RGB, Material, Object
from oitbench.scene.solids import mean_chord
from oitbench.scene.texturing import constant

HALF_SPREAD = 0.25
"""k₀ of McGuire & Mara 2017, equation 7, in meters."""
SPREAD_DISTANCE = 0.5
"""k₁ of the same equation, in meters."""
LEAST_BEND = 0.02
"""Smallest N − 1 that enters the roughness of an interface, which is inversely proportional to
it."""
LEAST_TRANSMISSION = 1e-6
"""Smaller transmissions count as this one, so that the absorption coefficient is finite."""


def spread(collimation: float) -> float:
    """Return the radius, as a slope, of the uniform disk into which a frosted sheet scatters light.

    Equation 7 of McGuire & Mara 2017 blurs a point at the distance Δz behind a layer. At the layer,
    the radius of the blur is k₀ (1 − c) (1 − k₁/(k₁ + Δz)). At contact, it grows at the rate
    k₀ (1 − c) / k₁ with Δz. This rate is the slope returned.
    """
    return HALF_SPREAD / SPREAD_DISTANCE * (1 - collimation)


def interface_roughness(material: Material) -> float:
    """Return the roughness α of the Beckmann microfacets of a solid's surface; 0 if smooth.

    A facet tilted by a slope m deflects light by (N − 1) m, and m has the variance α²/2 along an
    axis. Entering and leaving the solid together spread light by (N − 1)² α². This is set to R²/4,
    the variance along an axis of a sheet's disk of radius R (see `spread`).
    """
    if material.collimation == 1:
        return 0.0
    return min(1.0, spread(material.collimation) / 2 / max(material.index - 1, LEAST_BEND))


def absorption(item: Object) -> RGB:
    """Return the absorption coefficient σ of a refracting solid, m⁻¹ for each channel.

    σ = −2 ln(T) / l: a path of the mean chord l loses as much as two surfaces of transmission T.
    """
    length = mean_chord(item.mesh)
    red, green, blue = (
        -2 * math.log(max(part, LEAST_TRANSMISSION)) / length
        for part in constant(item.material.transmission)
    )
    return red, green, blue

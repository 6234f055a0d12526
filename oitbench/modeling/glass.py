"""Transmission of solids of colored glass and liquids."""

from __future__ import annotations

import math

from oitbench.scene import RGB, Mesh
from oitbench.scene.checks import require, require_fractions
from oitbench.scene.solids import mean_chord


def transmission(color: RGB, distance: float, mesh: Mesh) -> RGB:
    """Return the transmission T of one surface of a solid that absorbs light.

    `Material.transmission` is that of one surface, and light crosses two: T² is the part that is
    left after the mean chord l = 4V/S, so T = color^(l / 2d). The path tracer derives the same
    absorption coefficient from it, −ln(color)/d.

    Parameters
    ----------
    color : RGB
        Part of the light that is left after `distance`, per channel in [0, 1].
    distance : float
        Attenuation distance d in the unit of `mesh`, above 0; infinite for clear glass.
    mesh : Mesh
        The closed boundary of the solid.

    Raises
    ------
    SceneError
        If a value is out of range.
    """
    require_fractions("glass", color=color)
    require(distance > 0, f"glass: its attenuation distance is {distance:g}; give one above 0")
    power = 0.0 if math.isinf(distance) else mean_chord(mesh) / (2 * distance)
    red, green, blue = (float(part) ** power for part in color)
    return red, green, blue

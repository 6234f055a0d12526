"""Lights: directional, spot and environment.

A new kind of light is a dataclass here and a member of `Light`. Both renderers must then implement
it, in `oitbench/gl/shading` and in `oitbench/path_traced`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from oitbench.scene.checks import require, require_finite, require_light
from oitbench.scene.material import Texture
from oitbench.scene.vectors import RGB, WHITE, Floats, Vector, relocated

PENUMBRA = 0.1
"""Outer fraction of a spot light's half angle over which it fades out, linearly in the angle."""


@dataclass(frozen=True)
class DirectionalLight:
    """Parallel light from infinity.

    Parameters
    ----------
    direction : Vector
        Direction in which the light travels; need not have unit length.
    irradiance : RGB
        Irradiance of a surface that faces the light, W·m⁻² on the scene's arbitrary scale.

    Raises
    ------
    SceneError
        If a value is not finite, the irradiance is negative, or the direction is zero.
    """

    direction: Vector
    irradiance: RGB = WHITE

    def __post_init__(self) -> None:
        require_finite("light", direction=self.direction)
        require_light("light", irradiance=self.irradiance)
        require(any(self.direction), "light: its direction has no length; give a nonzero vector")


@dataclass(frozen=True)
class SpotLight:
    """A point that shines into a cone.

    Parameters
    ----------
    position, target : Vector
        In the scene's unit; the axis of the cone runs from `position` to `target`.
    intensity : RGB
        Radiant intensity, W·sr⁻¹ on the scene's arbitrary scale, whatever the unit of length. It is
        constant from the axis up to 1 − `PENUMBRA` of the half angle and fades to zero over the
        rest.
    angle : float
        Full opening angle of the cone in radians, in (0, π).

    Raises
    ------
    SceneError
        If a value is not finite, the intensity is negative, `position` equals `target`, or `angle`
        is out of range.
    """

    position: Vector
    target: Vector
    intensity: RGB = WHITE
    angle: float = math.radians(40)

    def __post_init__(self) -> None:
        require_finite("light", position=self.position, target=self.target)
        require_light("light", intensity=self.intensity)
        apart = np.subtract(self.position, self.target, dtype=np.float64)
        require(any(apart), "light: position and target coincide; move one")
        require(0 < self.angle < math.pi, "light: angle must lie between 0 and π radians")

    def relocated(self, origin: Vector, scale: float) -> SpotLight:
        """Return the light relative to `origin`, in units that are `scale` times smaller."""
        return replace(
            self,
            position=relocated(self.position, origin, scale),
            target=relocated(self.target, origin, scale),
        )


@dataclass(frozen=True, eq=False)
class EnvironmentLight:
    """Radiance that arrives from all directions; also the background that the camera sees.

    Parameters
    ----------
    radiance : RGB or Texture
        Radiance in W·sr⁻¹·m⁻² on the scene's arbitrary scale: one color for all directions, or a
        latitude-longitude map of shape (h, w, 3), or (h, w) in gray. The first row of the map is
        straight up (+y), its middle column straight ahead (−z), and columns run to the right (+x).

    Raises
    ------
    SceneError
        If the radiance is negative or not finite.
    """

    radiance: RGB | Texture = WHITE

    def __post_init__(self) -> None:
        light = self.radiance
        require_light("light", radiance=light.texels if isinstance(light, Texture) else light)

    @property
    def texels(self) -> Floats:
        """The map of all directions, shape (h, w, 3); one color gives a map of 2 × 4 texels."""
        if not isinstance(self.radiance, Texture):
            return np.broadcast_to(np.asarray(self.radiance, dtype=np.float64), (2, 4, 3))
        texels = self.radiance.texels.astype(np.float64)
        return np.repeat(texels[..., None], 3, axis=2) if texels.ndim == 2 else texels


Light = DirectionalLight | SpotLight | EnvironmentLight

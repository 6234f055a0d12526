"""What lights a scene, and the medium that may fill it."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from oitbench.scene.checks import require, require_finite
from oitbench.scene.material import RGB, WHITE, Array, Texture

PENUMBRA = 0.1
"""Part of a spot light's half angle over which it fades out, linear in the angle."""


@dataclass(frozen=True)
class DirectionalLight:
    """Light from infinity: the direction it travels, and its irradiance on a facing surface."""

    direction: RGB
    irradiance: RGB = WHITE

    def __post_init__(self) -> None:
        require_finite("light", direction=self.direction, irradiance=self.irradiance)
        require(any(self.direction), "light: its direction has no length")


@dataclass(frozen=True)
class SpotLight:
    """A point that shines into a cone.

    Parameters
    ----------
    position, target : RGB
        Metres; the cone's axis runs from one to the other.
    intensity : RGB
        W·sr⁻¹ on the axis and up to the last `PENUMBRA` of the half angle, where it fades to zero.
    angle : float
        The full cone in radians, below π.
    """

    position: RGB
    target: RGB
    intensity: RGB = WHITE
    angle: float = math.radians(40)

    def __post_init__(self) -> None:
        require_finite("light", position=self.position, target=self.target)
        require_finite("light", intensity=self.intensity)
        require(self.position != self.target, "light: position and target coincide")
        require(0 < self.angle < math.pi, "light: angle must lie between 0 and π radians")


@dataclass(frozen=True, eq=False)
class EnvironmentLight:
    """Radiance from all directions; it is also what the camera sees where no surface is.

    Parameters
    ----------
    radiance : RGB or Texture
        One value, or a map of latitude and longitude, (h, w, 3): its first row is straight up (+y),
        its middle column straight ahead (−z), and columns run to the right (+x).
    """

    radiance: RGB | Texture = WHITE


Light = DirectionalLight | SpotLight | EnvironmentLight


@dataclass(frozen=True, eq=False)
class Medium:
    """A participating medium that fills an axis-aligned box.

    Parameters
    ----------
    extinction : float
        σ_t in m⁻¹ where the density is one.
    low, high : RGB
        Corners of the box, metres.
    albedo : RGB
        Single-scattering albedo Λ.
    anisotropy : float
        g of Henyey & Greenstein, in (−1, 1); positive scatters forward.
    collimation : float
        c in [0, 1] for methods that blur what lies behind the medium; 1 passes light in a beam.
    density : array, shape (nz, ny, nx), float32, optional
        Factor on the extinction, in [0, 1], at the centers of equal cells of the box, linear
        between them; one everywhere without.
    """

    extinction: float
    low: RGB
    high: RGB
    albedo: RGB = WHITE
    anisotropy: float = 0.0
    collimation: float = 1.0
    density: Array | None = None

    def __post_init__(self) -> None:
        require_finite("medium", extinction=self.extinction, low=self.low, high=self.high)
        require_finite("medium", albedo=self.albedo, density=self.density)
        require(self.extinction >= 0, "medium: extinction is negative")
        require(-1 < self.anisotropy < 1, "medium: anisotropy must lie between -1 and 1")
        require(0 <= self.collimation <= 1, "medium: collimation leaves [0, 1]")
        require(
            all(low < high for low, high in zip(self.low, self.high, strict=True)),
            "medium: its box is empty; low must be below high on every axis",
        )
        density = self.density
        if density is not None:
            require(density.ndim == 3, f"medium: density is {density.shape}; give (nz, ny, nx)")
            inside = bool(((density >= 0) & (density <= 1)).all())
            require(inside, "medium: density leaves [0, 1]")


def sample_density(
    function: Callable[[npt.NDArray[np.float64]], npt.ArrayLike],
    low: RGB,
    high: RGB,
    cells: tuple[int, int, int],
) -> Array:
    """Return `function`, of points (..., 3) in metres, at the centers of nx × ny × nz cells.

    Returns
    -------
    array, shape (nz, ny, nx), float32
        Clipped to [0, 1], for `Medium.density`.
    """
    axes = [
        first + (np.arange(count) + 0.5) / count * (last - first)
        for first, last, count in zip(low, high, cells, strict=True)
    ]
    z, y, x = np.meshgrid(*axes[::-1], indexing="ij")
    values = np.asarray(function(np.stack([x, y, z], axis=-1)), dtype=np.float64)
    return np.clip(values, 0, 1).astype(np.float32)

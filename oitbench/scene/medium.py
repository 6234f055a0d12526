"""The participating medium that may fill a scene: fog, of uniform or varying density."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from oitbench.scene.checks import require, require_finite, require_fractions, require_light
from oitbench.scene.vectors import RGB, WHITE, Array, Floats, Vector, relocated


@dataclass(frozen=True, eq=False)
class Medium:
    """A participating medium that fills an axis-aligned box.

    Parameters
    ----------
    extinction : float
        Extinction coefficient σ_t where the density is one, per unit of length of the scene.
    low, high : Vector
        Opposite corners of the box, in the scene's unit.
    albedo : RGB
        Single-scattering albedo Λ.
    anisotropy : float
        Asymmetry parameter g of the Henyey-Greenstein phase function, in (−1, 1). Positive values
        scatter forward.
    collimation : float
        c in [0, 1]: 1 passes light in a beam, 0 spreads all of it. Used by methods that blur what
        lies behind a medium.
    ambient : RGB, optional
        Radiance that arrives in the medium from all sides and is not a beam, linear. It belongs to
        the scene: a fog in a brown room is lit by brown walls. Default: None, the mean radiance of
        the environment.
    density : array, shape (nz, ny, nx), float32, optional
        Factor on the extinction, in [0, 1], at the centers of the cells of a regular grid in the
        box; linear in between. Default: one everywhere.

    Raises
    ------
    SceneError
        If a value is not finite or out of range, the box is empty, or `density` has a wrong shape.
    """

    extinction: float
    low: Vector
    high: Vector
    albedo: RGB = WHITE
    anisotropy: float = 0.0
    collimation: float = 1.0
    ambient: RGB | None = None
    density: Array | None = None

    def __post_init__(self) -> None:
        require_finite("medium", extinction=self.extinction, low=self.low, high=self.high)
        require_fractions("medium", albedo=self.albedo, collimation=self.collimation)
        require(self.extinction >= 0, "medium: extinction is negative; give 0 or more")
        require(-1 < self.anisotropy < 1, "medium: anisotropy must lie between -1 and 1")
        require(
            all(low < high for low, high in zip(self.low, self.high, strict=True)),
            "medium: its box is empty; low must be below high on every axis",
        )
        if self.ambient is not None:
            require_light("medium", ambient=self.ambient)
        density = self.density
        if density is not None:
            require(density.ndim == 3, f"medium: density is {density.shape}; give (nz, ny, nx)")
            require_fractions("medium", density=density)

    def relocated(self, origin: Vector, scale: float) -> Medium:
        """Return the medium relative to `origin`, in units that are `scale` times smaller."""
        return replace(
            self,
            extinction=self.extinction / scale,
            low=relocated(self.low, origin, scale),
            high=relocated(self.high, origin, scale),
        )


def sample_density(
    function: Callable[[Floats], npt.ArrayLike],
    low: Vector,
    high: Vector,
    cells: tuple[int, int, int],
) -> Array:
    """Return samples of a density at the centers of a grid of cells, for `Medium.density`.

    Parameters
    ----------
    function : callable
        Maps points in meters, shape (..., 3), to densities, shape (...).
    low, high : Vector
        Opposite corners of the medium's box, meters.
    cells : tuple of int
        Number of cells (nx, ny, nz).

    Returns
    -------
    array, shape (nz, ny, nx), float32
        Clipped to [0, 1].
    """
    axes = [
        first + (np.arange(count) + 0.5) / count * (last - first)
        for first, last, count in zip(low, high, cells, strict=True)
    ]
    z, y, x = np.meshgrid(*axes[::-1], indexing="ij")
    values = np.asarray(function(np.stack([x, y, z], axis=-1)), dtype=np.float64)
    return np.clip(values, 0, 1).astype(np.float32)

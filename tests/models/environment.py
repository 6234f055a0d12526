"""Light that surfaces gather from an environment map, by quadrature in double precision."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from oitbench.scene import Floats, Texture, unit


def sky() -> Texture:
    """Return a map that is linear in height but for a bright green patch to the right (+x)."""
    y = np.cos((np.arange(64) + 0.5) / 64 * math.pi)
    texels = np.repeat((1 + 0.5 * y)[:, None, None] * np.array([1.0, 0.5, 2.0]), 128, axis=1)
    texels[24:36, 90:102, 1] = 6.0
    return Texture(texels.astype(np.float32))


def around(texture: Texture, count: int = 256) -> tuple[Floats, Floats, Floats]:
    """Return directions (n, 3), their radiance (n, 3) without interpolation, and solid angles."""
    texels = texture.texels.astype(np.float64)
    polar = (np.arange(count) + 0.5) / count * math.pi
    longitude = ((np.arange(2 * count) + 0.5) / count - 1) * math.pi
    up, across = np.meshgrid(polar, longitude, indexing="ij")
    sine = np.sin(up)
    d = np.stack([sine * np.sin(across), np.cos(up), -sine * np.cos(across)], axis=-1)
    solid = sine * (math.pi / count) ** 2
    factors = count // texels.shape[0], 2 * count // texels.shape[1]
    radiance = texels.repeat(factors[0], axis=0).repeat(factors[1], axis=1)
    return d.reshape(-1, 3), radiance.reshape(-1, 3), solid.ravel()


def irradiance(texture: Texture, n: npt.ArrayLike) -> Floats:
    """Return the irradiance of a surface with the unit normal `n`, shape (3,)."""
    d, radiance, solid = around(texture)
    return np.asarray((np.maximum(d @ np.asarray(n), 0) * solid) @ radiance)


def lobe(
    n: npt.ArrayLike, v: npt.ArrayLike, d: Floats, reflectance: float, roughness: float
) -> Floats:
    """Return the microfacet lobe of GGX times the cosine of `d`, shape (len(d),)."""
    n, v, a2 = np.asarray(n), np.asarray(v), roughness**4
    half = unit(v + d)
    nl, nv, nh, hv = np.maximum(d @ n, 0), v @ n, half @ n, (half * v).sum(axis=-1)
    density = a2 / (math.pi * (nh**2 * (a2 - 1) + 1) ** 2)
    shared = nl * np.sqrt(nv**2 * (1 - a2) + a2) + nv * np.sqrt(nl**2 * (1 - a2) + a2)
    fresnel = reflectance + (1 - reflectance) * (1 - hv) ** 5
    return np.asarray(np.where(nl > 0, density * 0.5 / shared * fresnel * nl, 0))


def mirrored(
    texture: Texture, n: npt.ArrayLike, v: npt.ArrayLike, reflectance: float, roughness: float
) -> Floats:
    """Return the radiance that the lobe of a surface reflects toward `v`, shape (3,)."""
    d, radiance, solid = around(texture)
    return np.asarray((lobe(n, v, d, reflectance, roughness) * solid) @ radiance)

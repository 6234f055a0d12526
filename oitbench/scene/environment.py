"""Means of the radiance of an environment light, which renderers look up by direction.

A mean is weighted by the cosine (irradiance over π), by a microfacet lobe, or not at all. Tables
are computed in double precision, when a scene is uploaded.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence

import numpy as np

from oitbench.scene.material import Material, Texture
from oitbench.scene.model import Scene
from oitbench.scene.vectors import Floats

PATCHES = 128
"""Rows of the patches of the sphere over which radiance is integrated; twice as many columns."""
NODES = 65
"""Rows of a table of means, from straight up to straight down."""
INCIDENCES = 64
"""Nodes of the table of `lobe_fit`, from grazing to normal incidence."""
GRADES = 8
"""Steps of roughness between which a texture of roughness is interpolated."""
_SAMPLES = 4096
_STEPS = 0.7548776662466927, 0.5698402909980532
"""Steps of the R₂ sequence, which covers the unit square evenly (Roberts 2018)."""


def even_points(count: int) -> Floats:
    """Return points that cover the unit square evenly, shape (count, 2)."""
    return np.asarray((0.5 + np.arange(count)[:, None] * np.array(_STEPS)) % 1)


def mean_radiance(texels: Floats) -> Floats:
    """Return the mean of a map over all directions, shape (3,)."""
    return np.asarray(_flux(texels).sum(axis=(0, 1)) / (4 * math.pi))


def ambient_of_medium(scene: Scene) -> Floats:
    """Return the radiance from all sides that lights the medium of a scene, shape (3,)."""
    if scene.medium is not None and scene.medium.ambient is not None:
        return np.array(scene.medium.ambient, dtype=np.float64)
    return np.zeros(3) if scene.environment is None else mean_radiance(scene.environment.texels)


def weighted_means(texels: Floats, weight: Callable[[Floats], Floats]) -> Floats:
    """Return the means of a map around the directions of a table.

    Parameters
    ----------
    texels : array, shape (h, w, 3)
        Radiance by latitude and longitude, as in `EnvironmentLight.texels`; bilinear in between.
    weight : callable
        Maps the cosine between the middle of the mean and a direction to a weight, not negative.

    Returns
    -------
    array, shape (NODES, 2 (NODES − 1), 3)
        Rows run from straight up to straight down, both included. Columns begin straight ahead (−z)
        and run to the right.
    """
    return np.asarray(tables_of_means(texels, [weight])[0])


def tables_of_means(texels: Floats, weights: Iterable[Callable[[Floats], Floats]]) -> Floats:
    """Return the tables of `weighted_means` for several weights, shape (number, …)."""
    if (texels == texels[0, 0]).all():
        nodes = NODES, 2 * (NODES - 1), 3
        return np.asarray([np.broadcast_to(texels[0, 0], nodes) for _ in weights])
    flux = _flux(texels)
    return np.asarray(np.stack([_table_of_means(flux, weight) for weight in weights]))


def _table_of_means(flux: Floats, weight: Callable[[Floats], Floats]) -> Floats:
    (polar, longitude), columns = _middles(PATCHES), 2 * PATCHES
    top = np.linspace(0, math.pi, NODES)
    # Rotation about the vertical axis: the sum over longitudes is a circular convolution.
    turn = np.arange(columns) / columns * 2 * math.pi - longitude[0]
    spectrum = np.fft.rfft(flux, axis=1)
    area = np.diff(-np.cos(np.linspace(0, math.pi, PATCHES + 1))) * (2 * math.pi / columns)
    rows = []
    for angle in top:
        level = np.cos(angle) * np.cos(polar)[:, None]
        kernel = weight(level + np.sin(angle) * np.sin(polar)[:, None] * np.cos(turn))
        product = (np.fft.rfft(kernel, axis=1)[..., None] * spectrum).sum(axis=0)
        found = np.fft.irfft(product, columns, axis=0)[:: columns // (2 * (NODES - 1))]
        rows.append(found / (kernel * area[:, None]).sum())
    return np.asarray(np.maximum(np.stack(rows), 0))


def cosine_weight(cosine: Floats) -> Floats:
    """Return the weight of a direction in the irradiance of a surface."""
    return np.asarray(np.maximum(cosine, 0))


def lobe_weight(roughness: float) -> Callable[[Floats], Floats]:
    """Return the weights of a microfacet lobe that is seen along the normal: D·G₂/G₁ of GGX."""
    a2 = roughness**4

    def weight(cosine: Floats) -> Floats:
        nl = np.clip(cosine, 0, 1)
        density = a2 / ((1 + nl) / 2 * (a2 - 1) + 1) ** 2
        masking = 2 * nl / (nl + np.sqrt(nl * nl * (1 - a2) + a2))
        return np.asarray(np.where(cosine > 0, density * masking, 0))

    return weight


def lobe_fit(roughness: float) -> Floats:
    """Return how a microfacet lobe reflects even light, by the cosine n·v of incidence.

    Returns
    -------
    array, shape (INCIDENCES, 4)
        Rows run from n·v = 0 to 1. E[G₂/G₁ (1 − (1 − h·v)⁵)] and E[G₂/G₁ (1 − h·v)⁵] over visible
        normals h: with F₀ times the first, their sum is the light that is reflected. Then p and q:
        p·r + q·n points in the mean direction of the reflected light, with the mirror direction r
        and the normal n.

    References
    ----------
    Karis 2013, "Real shading in Unreal Engine 4" (the split sum). Heitz 2018, "Sampling the GGX
    distribution of visible normals".
    """
    a = roughness**2
    nv = np.maximum(np.linspace(0, 1, INCIDENCES), 1e-3)[:, None]
    nv[-1] = 1 - 1e-6  # r and n must differ
    v = np.stack([np.sqrt(1 - nv * nv), np.zeros_like(nv), nv], axis=-1)
    h = _visible_normals(a, v[:, 0], even_points(_SAMPLES))
    hv = np.clip((h * v).sum(axis=-1), 0, 1)
    out = 2 * hv[..., None] * h - v
    nl = np.maximum(out[..., 2], 0)
    sl, sv = (np.sqrt(c * c * (1 - a * a) + a * a) for c in (nl, nv))
    masking = nl * (nv + sv) / np.maximum(nl * sv + nv * sl, 1e-12)
    fifth = (1 - hv) ** 5
    scale, bias = (masking * (1 - fifth)).mean(axis=1), (masking * fifth).mean(axis=1)
    mean = (masking[..., None] * out).mean(axis=1)
    p = -mean[:, 0] / v[:, 0, 0]
    return np.stack([scale, bias, p, mean[:, 2] - p * nv[:, 0]], axis=1)


def rough_lobes(materials: Iterable[Material]) -> tuple[float, ...]:
    """Return the roughness of all lobes that a scene needs.

    First come the distinct constants, in order. If any material has a texture of roughness, the
    `GRADES` steps between which it is interpolated follow.
    """
    values = [one.roughness for one in materials if _mirrors_roughly(one)]
    graded = any(isinstance(value, Texture) for value in values)
    steps = [(k + 1) / GRADES for k in range(GRADES)] if graded else []
    return (*sorted({value for value in values if not isinstance(value, Texture)}), *steps)


def lobe_number(material: Material, lobes: Sequence[float]) -> int:
    """Return the place of a material's lobe in `rough_lobes`, from 1; 0 if it has none.

    A texture of roughness has that of the first step, negated.
    """
    if not _mirrors_roughly(material):
        return 0
    if isinstance(material.roughness, Texture):
        return GRADES - len(lobes) - 1
    return 1 + lobes.index(material.roughness)


def _mirrors_roughly(material: Material) -> bool:
    rough = isinstance(material.roughness, Texture) or material.roughness > 0
    return rough and material.reflectance > 0 and not material.isotropic


def _visible_normals(a: float, v: Floats, points: Floats) -> Floats:
    """Return normals that are visible from `v`, shape (len(v), len(points), 3) (Heitz 2018)."""
    stretched = v * np.array([a, a, 1.0])
    axis = stretched / np.linalg.norm(stretched, axis=1, keepdims=True)
    across = np.cross([0.0, 0.0, 1.0], axis)
    across /= np.linalg.norm(across, axis=1, keepdims=True)
    along = np.cross(axis, across)
    radius, angle = np.sqrt(points[:, 0]), 2 * math.pi * points[:, 1]
    x, y = radius * np.cos(angle), radius * np.sin(angle)
    part = (1 + axis[:, 2:]) / 2
    y = (1 - part) * np.sqrt(1 - x * x) + part * y
    z = np.sqrt(np.maximum(1 - x * x - y * y, 0))
    h = x[:, None] * across[:, None] + y[..., None] * along[:, None] + z[..., None] * axis[:, None]
    h = h * np.array([a, a, 1.0])
    return np.asarray(h / np.linalg.norm(h, axis=-1, keepdims=True))


def _middles(rows: int) -> tuple[Floats, Floats]:
    """Return polar angle and longitude of the middles of patches in rows and columns."""
    polar = (np.arange(rows) + 0.5) / rows * math.pi
    return polar, ((np.arange(2 * rows) + 0.5) / rows - 1) * math.pi


def _flux(texels: Floats) -> Floats:
    """Return radiance times solid angle of each patch, shape (PATCHES, 2 PATCHES, 3)."""
    rows, columns = PATCHES, 2 * PATCHES
    fine = []
    for count, side in zip((rows, columns), texels.shape[:2], strict=True):
        cells = side if side >= 4 * count else 2 * side  # the middles of many texels are enough
        fine.append(count * math.ceil(cells / count))
    polar, longitude = ((np.arange(count) + 0.5) / count for count in fine)
    radiance = bilinear(texels, polar, longitude)
    edges = np.cos(np.linspace(0, math.pi, fine[0] + 1))
    flux = radiance * ((edges[:-1] - edges[1:]) * (2 * math.pi / fine[1]))[:, None, None]
    down, across = fine[0] // rows, fine[1] // columns
    return np.asarray(flux.reshape(rows, down, columns, across, 3).sum(axis=(1, 3)))


def bilinear(texels: Floats, polar: Floats, longitude: Floats) -> Floats:
    """Return texels between their centers: clamped in latitude, wrapped in longitude.

    Places are fractions of the map.
    """
    for axis, places in ((0, polar), (1, longitude)):
        count = texels.shape[axis]
        at = places * count - 0.5
        at = np.clip(at, 0, count - 1) if axis == 0 else at
        low = np.floor(at).astype(int)
        shape = [-1 if axis == one else 1 for one in range(3)]
        part = (at - low).reshape(shape)
        high = np.minimum(low + 1, count - 1) if axis == 0 else low + 1
        one, other = (np.take(texels, index % count, axis=axis) for index in (low, high))
        texels = one + part * (other - one)
    return texels

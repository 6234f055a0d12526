"""Parallel planes that fill the view, so that all pixels hold the same layers.

Parameters
----------
detail : float
    Factor on the number of triangles; the picture stays the same.
count : int
    Number of planes.
alpha : float
    Coverage α of each plane, in [0, 1].
palette : str
    Colors L, repeated from front to back.
radiance : float
    Factor on the colors, for high dynamic range.
transmission : str
    "none" for t = 0, "gray" for t = `clarity`, "colored" for t = `clarity` times the color.
clarity : float
    In [0, 1].
first, spacing, near : float
    View distance of the nearest plane, distance between planes (0 for exact ties), and near plane
    of the camera, meters.
background : float
    Radiance C₀ of the background, the same in all channels.
order : str
    Order of submission.
seed : int
    Seed of the shuffled order.

With the layers ordered from near to far, the picture has the closed form

    Σ αᵢ Lᵢ Π τⱼ + C₀ Π τ,    τ = 1 − α + α t,

where the first product is over the layers in front of layer i. Each plane is an object of its own
and perpendicular to the view axis, so that sorting objects by distance is exact. The planes fill
views of aspect ratios up to 4:1.
"""

from __future__ import annotations

import math

import numpy as np

from oitbench.errors import UsageError
from oitbench.modeling.detail import DETAIL, divisions
from oitbench.modeling.mesh import grid
from oitbench.parameters import Parameter
from oitbench.scene import RGB, WHITE, Camera, Material, Object, Scene

PALETTES: dict[str, tuple[RGB, ...]] = {
    "spectrum": (
        (0.90, 0.16, 0.12),
        (0.95, 0.55, 0.10),
        (0.55, 0.80, 0.14),
        (0.10, 0.62, 0.52),
        (0.16, 0.34, 0.88),
        (0.58, 0.22, 0.76),
    ),
    "red_blue": ((0.90, 0.10, 0.10), (0.10, 0.10, 0.90)),
    "blue_red": ((0.10, 0.10, 0.90), (0.90, 0.10, 0.10)),
    "red_white": ((1.0, 0.0, 0.0), WHITE),
    "gray": ((0.5, 0.5, 0.5),),
    "white": (WHITE,),
}
WIDEST_ASPECT = 4.0

subject = "layers"
parameters = {
    "detail": DETAIL,
    "count": Parameter(6, low=1, high=4096, help="number of planes"),
    "alpha": Parameter(0.5, low=0.0, high=1.0, help="coverage of each plane"),
    "palette": Parameter(
        "spectrum", choices=tuple(PALETTES), help="colors, repeated from front to back"
    ),
    "radiance": Parameter(1.0, low=0.0, help="factor on the colors, for high dynamic range"),
    "transmission": Parameter(
        "none", choices=("none", "gray", "colored"), help="kind of transmission t"
    ),
    "clarity": Parameter(0.6, low=0.0, high=1.0, help="t if gray; factor on the color if colored"),
    "first": Parameter(2.0, low=0.001, help="view distance of the nearest plane, m"),
    "spacing": Parameter(0.5, low=0.0, help="distance between planes, m; 0 makes exact ties"),
    "near": Parameter(0.1, low=0.0001, help="near plane of the camera, m"),
    "background": Parameter(0.25, low=0.0, help="radiance C₀ of the background, gray"),
    "order": Parameter(
        "shuffled", choices=("shuffled", "near_first", "far_first"), help="order of submission"
    ),
    "seed": Parameter(1, low=0, help="seed of the shuffled order"),
}


def build(
    *,
    name: str,
    detail: float,
    count: int,
    alpha: float,
    palette: str,
    radiance: float,
    transmission: str,
    clarity: float,
    first: float,
    spacing: float,
    near: float,
    background: float,
    order: str,
    seed: int,
) -> Scene:
    """Return the stack in the chosen order of submission."""
    if first <= near:
        raise UsageError(f"{name}: first is {first:g} m; it must lie beyond near = {near:g} m")
    camera = Camera(position=(0, 0, 0), target=(0, 0, -1), near=near)
    cells = divisions(1, detail)
    colors = PALETTES[palette]
    planes = []
    for index in range(count):
        color = colors[index % len(colors)]
        material = Material(
            coverage=alpha,
            transmission=_transmission(transmission, clarity, color),
            emission=_scaled(color, radiance),
        )
        distance = first + index * spacing
        half = 1.1 * distance * math.tan(camera.fov_y / 2)
        mesh = grid((0, 0, -distance), (WIDEST_ASPECT * half, 0, 0), (0, half, 0), cells, cells)
        planes.append(Object(f"plane {index}", mesh, material))
    return Scene(
        name=name,
        camera=camera,
        objects=tuple(planes[index] for index in _submission(order, count, seed)),
        background=(background, background, background),
    )


def _transmission(kind: str, clarity: float, color: RGB) -> RGB:
    """Return t of a plane of this color."""
    if kind == "none":
        return (0.0, 0.0, 0.0)
    return (clarity, clarity, clarity) if kind == "gray" else _scaled(color, clarity)


def _scaled(color: RGB, factor: float) -> RGB:
    """Return the color times a factor."""
    return (factor * color[0], factor * color[1], factor * color[2])


def _submission(order: str, count: int, seed: int) -> list[int]:
    """Return the indices of the planes, counted from the nearest, in order of submission."""
    if order == "shuffled":
        return [int(index) for index in np.random.default_rng(seed).permutation(count)]
    return list(range(count)) if order == "near_first" else list(reversed(range(count)))

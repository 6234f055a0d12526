"""Two crossed grids of colored glass bars in front of checkered paper.

Arranged as figure 7 of McGuire & Mara 2017, "Phenomenological Transparency".

Parameters
----------
detail : float
    Factor on the number of triangles.
reflection : float
    Largest radiance that a bar adds.
near : float
    Distance of the near plane from the camera, m. The bars hang at 4.3 to 5.3 m.

Each bar is an object and a thin sheet that covers fully, transmits one saturated color and reflects
almost nothing. Bars of one grid never overlap, and all bars of one grid are nearer than all of the
other. Sorting by object is therefore exact, and only colored transmission is tested.
"""

from __future__ import annotations

import math

import numpy as np

from oitbench.modeling.baking import with_radiance
from oitbench.modeling.detail import DETAIL, divisions
from oitbench.modeling.mesh import grid
from oitbench.modeling.placement import frames, scatter
from oitbench.parameters import Parameter
from oitbench.scene import RGB, WHITE, Camera, Floats, Material, Mesh, Object, Scene

# Transmission of one bar. No channel is zero, so that crossings of opposite colors are not black.
GLASS: dict[str, RGB] = {
    "red": (0.90, 0.07, 0.07),
    "amber": (0.95, 0.52, 0.05),
    "yellow": (0.93, 0.86, 0.10),
    "green": (0.10, 0.74, 0.18),
    "cyan": (0.08, 0.78, 0.88),
    "blue": (0.08, 0.16, 0.90),
    "magenta": (0.86, 0.10, 0.72),
}
PITCH, WIDTH, LENGTH = 0.36, 0.24, 2.8  # of the bars, meters
FRONT, BACK, PAPER = 0.35, -0.35, -1.1  # z of both grids and of the paper, meters

subject = "glass"
near = 3.8
crops = {"crossings": (0.38, 0.26, 0.26, 0.26)}
parameters = {
    "detail": DETAIL,
    "reflection": Parameter(0.05, low=0.0, high=1.0, help="largest radiance that a bar adds"),
}


def build(*, name: str, detail: float, reflection: float) -> Scene:
    """Return the paper and the two grids: upright bars in front, level bars behind."""
    offsets = PITCH * (np.arange(len(GLASS)) - (len(GLASS) - 1) / 2)
    cells = (divisions(8, detail, 2), divisions(24, detail, 2))
    bars = []
    for number, (color, transmission) in enumerate(GLASS.items()):
        material = Material(
            coverage=1.0,
            transmission=transmission,
            emission=(reflection, reflection, reflection),
        )
        # The rows take every second offset, so that neighbors contrast in both grids.
        row = float(offsets[(2 * number + 1) % len(GLASS)])
        upright = grid(
            (float(offsets[number]), 0, FRONT), (WIDTH / 2, 0, 0), (0, LENGTH / 2, 0), *cells
        )
        level = grid((0, row, BACK), (0, -WIDTH / 2, 0), (LENGTH / 2, 0, 0), *cells)
        bars.append(Object(f"upright {color}", _streaked(upright), material))
        bars.append(Object(f"level {color}", _streaked(level), material))
    paper = Object("paper", _paper(detail), Material(emission=WHITE))
    camera = Camera(position=(-1.0, 0.66, 4.9), target=(0, 0, -0.1), fov_y=math.radians(36))
    return Scene(
        name=name,
        camera=camera,
        objects=(paper, *bars),
        background=(0.62, 0.58, 0.52),
        views={"plan": Camera(position=(0, 0, 4), target=(0, 0, 0), height=3.0)},
    )


def _streaked(bar: Mesh) -> Mesh:
    """Return `bar` with the reflection of a window, brightest along a line left of its middle."""
    assert bar.uvs is not None
    across, along = bar.uvs[:, 0].astype(np.float64), bar.uvs[:, 1].astype(np.float64)
    streak = np.exp(-(((across - 0.3) / 0.13) ** 2)) * (0.55 + 0.45 * np.sin(5 * along + 0.6))
    rim = (2 * across - 1) ** 6
    return with_radiance(bar, (0.12 + 0.7 * streak + 0.18 * rim)[:, None].repeat(3, axis=1))


def _paper(detail: float) -> Mesh:
    """Return a checkered sheet beyond the edges of the view, lit softly from the upper left."""
    cells = divisions(3, detail)
    columns, rows, side = 56, 24, 0.22
    column, row = (axis.ravel() for axis in np.meshgrid(np.arange(columns), np.arange(rows)))
    centers = np.stack(
        [
            (column - (columns - 1) / 2) * side,
            (row - (rows - 1) / 2) * side,
            np.full(column.shape, PAPER),
        ],
        axis=1,
    )
    edge = np.full((len(centers), 1), side / 2)
    placed = frames(centers, edge * [1.0, 0.0, 0.0], edge * [0.0, 1.0, 0.0])
    tile = grid((0, 0, 0), (1, 0, 0), (0, 1, 0), cells, cells)
    sheet = scatter(tile, placed)
    dark = np.repeat((column + row) % 2 == 1, len(tile.positions))
    ink = np.where(dark[:, None], (0.70, 0.72, 0.76), (0.95, 0.92, 0.87))
    return with_radiance(sheet, ink * _lamp(sheet.positions.astype(np.float64)))


def _lamp(positions: Floats) -> Floats:
    """Return a factor on radiance that falls with the distance from the lamp, shape (n, 1)."""
    distance = np.hypot(positions[:, 0] + 0.5, positions[:, 1] - 0.6)
    return (0.62 + 0.38 / (1 + (distance / 2.2) ** 2))[:, None]

"""Wire fences as coverage textures."""

from __future__ import annotations

import numpy as np

from oitbench.scene import Texture

SIDE, _BORDER, _SUBSAMPLES = 256, 4, 4
MESHES = 18
"""Diamonds along a side of a panel."""
_THICKNESS = 0.085
"""Width of a wire, in widths of a diamond."""


def mesh_fence() -> Texture:
    """Return the coverage of a panel of chain-link fence, inside an empty border."""
    samples = SIDE * _SUBSAMPLES
    line = (np.arange(samples) + 0.5) / samples
    u, v = np.meshgrid(line * MESHES, line * MESHES)
    bow = 0.06 * np.sin(2 * np.pi * (u - v))
    rising, falling = ((u + v + bow) % 1, (u - v + bow) % 1)
    wires = np.minimum(np.minimum(rising, 1 - rising), np.minimum(falling, 1 - falling))
    inside = wires < _THICKNESS * np.sqrt(2) / 2
    edge = _BORDER * _SUBSAMPLES
    inside[:edge] = inside[-edge:] = False
    inside[:, :edge] = inside[:, -edge:] = False
    blocks = inside.reshape(SIDE, _SUBSAMPLES, SIDE, _SUBSAMPLES)
    return Texture(blocks.mean(axis=(1, 3)).astype(np.float32))

"""Images of one color."""

from __future__ import annotations

import numpy as np

from oitbench.image.files import Image
from oitbench.scene import RGB


def constant(color: RGB, side: int = 24) -> Image:
    """Return an image of one color, shape (side, side, 3)."""
    return np.full((side, side, 3), color, dtype=np.float32)

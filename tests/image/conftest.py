"""An image of random colors."""

from __future__ import annotations

import numpy as np
import pytest

from oitbench.image.files import Image


@pytest.fixture
def picture() -> Image:
    return np.random.default_rng(7).random((24, 32, 3), dtype=np.float32)

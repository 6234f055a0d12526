"""Made-up references, for tests of how they are stored."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from oitbench.fingerprints.scene import scene_fingerprint
from oitbench.path_traced.references import storage
from oitbench.path_traced.references.storage import Reference, Rendering
from oitbench.path_traced.version import TRACER
from oitbench.scene import Camera, Material, Mesh, Object, Scene, Texture

SIZE = (12, 8)
LABEL = "window[seed=2]"
KEY = "window[seed=2]@12x8"


def make_scene(coverage: float | Texture = 0.5, exposure: float = 0.0) -> Scene:
    corners = np.array([(-1.0, -1.0, 0.0), (1.0, -1.0, 0.0), (1.0, 1.0, 0.0), (-1.0, 1.0, 0.0)])
    mesh = Mesh(
        corners,
        np.array([(0, 1, 2), (0, 2, 3)], dtype=np.uint32),
        (corners[:, :2] / 2 + 0.5).astype(np.float32),
    )
    film = Object("film", mesh, Material(coverage, emission=(1.0, 0.25, 0.0)))
    return Scene(
        LABEL, Camera((0.0, 0.0, 4.0)), (film,), background=(0.1, 0.2, 0.3), exposure=exposure
    )


def make_reference(scene: Scene, seed: int = 7) -> Reference:
    random = np.random.default_rng(seed)
    return Reference(
        Rendering(LABEL, SIZE, 2, 16, seed, TRACER, "3.9.1", scene_fingerprint(scene)),
        {"flip_ldr@67ppd": 0.001, "rmse_lin": None},
        mean=random.random((SIZE[1], SIZE[0], 3)).astype(np.float32),
        variance=(1e-9 * random.random((SIZE[1], SIZE[0], 3))).astype(np.float32),
    )


def read_back(folder: Path) -> Reference:
    found = storage.read(folder, LABEL, SIZE)
    assert found is not None
    return found

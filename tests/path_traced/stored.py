"""Made-up references, for tests of how they are stored."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import Any

import msgspec
import numpy as np

from oitbench.fingerprints.scene import scene_fingerprint
from oitbench.path_traced.references import storage
from oitbench.path_traced.references.storage import Reference, Rendering
from oitbench.path_traced.references.wanted import Wanted
from oitbench.path_traced.version import TRACER
from oitbench.scene import Camera, Material, Mesh, Object, Scene, Texture
from oitbench.truths import FULL

SIZE = (12, 8)
LABEL = "window[seed=2]"
KEY = "window[seed=2]@12x8.full"


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


def wanted(scene: Scene, truth: str = FULL, **fields: Any) -> Wanted:
    return dataclasses.replace(Wanted(scene, LABEL, SIZE, 2, truth), **fields)


def make_reference(scene: Scene, seed: int = 7) -> Reference:
    random = np.random.default_rng(seed)
    return Reference(
        Rendering(
            LABEL, "full", ["COVERAGE"], [], SIZE, 2, 16, 1, seed, TRACER, "3.9.1",
            scene_fingerprint(scene),
        ),
        {"flip_ldr@67ppd": 0.001, "rmse_lin": None},
        1.5,
        (random.random((SIZE[1], SIZE[0], 3)).astype(np.float32),),
        (1e-9 * random.random((SIZE[1], SIZE[0], 3))).astype(np.float32),
    )  # fmt: skip


def make_matched(scene: Scene, parts: int = 8) -> Reference:
    known = make_reference(scene)
    how = msgspec.structs.replace(known.rendering, truth="matched", parts=parts)
    random = np.random.default_rng(3)
    images = (random.random((SIZE[1], SIZE[0], 3)).astype(np.float32) for _ in range(parts))
    return Reference(how, {"flip_ldr@67ppd": 0.01}, 2.0, tuple(images))


def read_back(folder: Path, key: str = KEY) -> Reference:
    found = storage.read(folder, key)
    assert found is not None
    return found

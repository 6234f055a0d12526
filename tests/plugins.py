"""A collection of plugins that fail in different ways."""

from __future__ import annotations

from pathlib import Path

from tests.helpers import write_method

_SCENE = '''"""A scene for tests."""
import os
import time

import numpy as np

from oitbench import Parameter
from oitbench.scene import Camera, FragmentLists, Scene

parameters = {{"count": Parameter(3, low=1)}}


def build(*, name: str, count: int) -> Scene:
    {before}
    random = np.random.default_rng(count)
    shape = (count, 4, 4)
    lists = FragmentLists(
        random.uniform(1, 9, shape).astype(np.float32),
        random.random(shape, dtype=np.float32),
        random.random((*shape, 3), dtype=np.float32),
        np.zeros((*shape, 3), np.float32),
    )
    return Scene(name, Camera((0, 0, 0), (0, 0, -1)), lists=lists)
'''
_DRAW = "void gather(Fragment fragment) {{\n    color = vec4({0});\n}}\n"


def misbehaving(folder: Path) -> Path:
    """Write the collection into `folder`."""
    scenes = {
        "calm": "pass",
        "restless": "pass",
        "sleeper": "time.sleep(600)",
        "crasher": "os._exit(7)",
        "raiser": "raise ValueError('the scene is unwell')",
        "poisoned": "return Scene(name, Camera((0, 0, 9)), background=(float('nan'),) * 3)",
    }
    (folder / "scenes").mkdir(parents=True)
    for name, before in scenes.items():
        (folder / "scenes" / f"{name}.py").write_text(_SCENE.format(before=before))
    for name, value, requires in (
        ("broken", "nowhere", ()),
        ("demanding", "1.0", ("no_such_thing",)),
        ("unstable", "sqrt(-fragment.z)", ()),
    ):
        write_method(
            folder / "methods" / name,
            '(Gather("draw.glsl", writes={"color": ADD}),)',
            members=f"expresses = Effect.COVERAGE\nrequires = {requires}",
            draw=_DRAW.format(value),
        )
    return folder

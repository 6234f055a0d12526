"""Default numbers of samples of full pictures."""

from __future__ import annotations

from pathlib import Path

from oitbench.path_traced.trace.samples import MEDIUM, OTHER, SAMPLES, default_samples
from oitbench.scene import Camera, Material, Medium, Object, Scene
from tests.path_traced.test_render import SQUARE

SCENES = Path(__file__).parents[2] / "scenes"


def test_listed_scenes_exist() -> None:
    assert set(SAMPLES) <= {path.stem for path in SCENES.glob("*.py")}


def test_variants_count_as_their_scene_and_others_by_their_content() -> None:
    square = Object("square", SQUARE, Material())
    camera = Camera((0.0, 0.0, 4.0))
    for name in ("chess", "chess[detail=2]"):
        assert default_samples(Scene(name, camera, (square,))) == SAMPLES["chess"]
    assert default_samples(Scene("own", camera, (square,))) == OTHER
    fog = Medium(1.0, (-1.0, -1.0, -1.0), (1.0, 1.0, 1.0))
    assert default_samples(Scene("own", camera, (square,), medium=fog)) == MEDIUM

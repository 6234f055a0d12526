"""Default numbers of samples of full pictures."""

from __future__ import annotations

from dataclasses import replace

from oitbench.fingerprints.scene import scene_fingerprint
from oitbench.path_traced.trace.samples import MEDIUM, OTHER, PARTICLES, default_samples
from oitbench.scene import Camera, Material, Medium, Object, Scene
from tests.path_traced.test_render import SQUARE


def test_a_scene_states_its_samples_or_they_follow_from_its_content() -> None:
    square = Object("square", SQUARE, Material())
    scene = Scene("own", Camera((0.0, 0.0, 4.0)), (square,))
    fog = Medium(1.0, (-1.0, -1.0, -1.0), (1.0, 1.0, 1.0))
    assert default_samples(scene) == OTHER
    assert default_samples(replace(scene, medium=fog)) == MEDIUM
    cloud = replace(square, particles=True)
    assert default_samples(replace(scene, objects=(cloud,))) == PARTICLES
    assert default_samples(replace(scene, medium=fog, full_samples=3)) == 3


def test_samples_are_no_part_of_what_a_scene_looks_like() -> None:
    scene = Scene("own", Camera((0.0, 0.0, 4.0)), (Object("square", SQUARE, Material()),))
    assert scene_fingerprint(scene) == scene_fingerprint(replace(scene, full_samples=3))

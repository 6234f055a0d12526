"""The far end of a process that builds the scenes of a suite and finds their references."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from msgspec import Struct

from oitbench.effects import names
from oitbench.fingerprints.scene import scene_fingerprint
from oitbench.path_traced.references.lookup import find
from oitbench.path_traced.references.wanted import Wanted
from oitbench.places import Places
from oitbench.plugins import Collection
from oitbench.suites.digests import pixel_digest
from oitbench.truths import ranking_truth
from oitbench.workers.messages import Step
from oitbench.workers.serve import OnStep, serve

_BUILDING = Step("building the scene")


class Settings(Struct, frozen=True):
    """The folders of all collections."""

    collections: list[Path]


class DescribeScene(Struct, frozen=True, tag=True):
    """Asks for a view of a scene, with its stored references of some truths."""

    scene: str
    view: str
    size: tuple[int, int]
    ssaa: int
    truths: list[str]


class SceneDescribed(Struct, frozen=True, tag=True):
    """What `SuiteScene` holds; `missing` says why there is no reference, by truth."""

    label: str
    fingerprint: str
    effects: list[str]
    ranked_by: str
    exposure: float
    triangles: int
    references: dict[str, str]
    missing: dict[str, str]
    truth: str


def _begin(settings: Settings, on_step: OnStep) -> Callable[[DescribeScene], SceneDescribed]:
    collection = Collection(Places(settings.collections))

    def answer(request: DescribeScene) -> SceneDescribed:
        on_step(_BUILDING)
        scene = collection.build_scene(request.scene).from_view(request.view)
        references, missing = {}, {}
        for truth in request.truths:
            wanted = Wanted(
                scene, request.scene, request.size, request.ssaa, truth, view=request.view
            )
            found = find(wanted, collection.folders)
            if found.reference is None:
                missing[truth] = found.message or f"{wanted.key} is not stored"
            else:
                references[truth] = pixel_digest(found.reference.mean)
        return SceneDescribed(
            request.scene,
            scene_fingerprint(scene),
            names(scene.effects),
            ranking_truth(scene.effects),
            scene.exposure,
            sum(len(item.mesh.triangles) for item in scene.objects),
            references,
            missing,
            collection.truth().label,
        )

    return answer


def main() -> None:
    """Serve the process that started this one."""
    serve(Settings, DescribeScene, _begin)

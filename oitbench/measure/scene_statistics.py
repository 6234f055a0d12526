"""Statistics of a scene on the device: geometry, fragments and depth complexity.

Fragments are counted once for a size (`UploadedScene.fragment_counts`); methods allocate by the
same counts.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
import numpy.typing as npt

from oitbench.effects import Effect
from oitbench.gl.uploaded_scene import UploadedScene
from oitbench.results.statistics import DepthComplexity, SceneStatistics
from oitbench.scene import Mesh, Object, Scene
from oitbench.views import MAIN


def measure(
    uploaded: UploadedScene, size: tuple[int, int], effects: Effect = Effect.NONE
) -> SceneStatistics:
    """Return the statistics of a frame of the scene's camera.

    Parameters
    ----------
    uploaded : UploadedScene
    size : (int, int)
        Width and height in pixels; one sample per pixel.
    effects : Effect
        Running effects: ambient occlusion makes some fragments opaque.
    """
    geometry = uploaded.geometry
    counts = uploaded.fragment_counts(size, effects)
    scene = geometry.scene
    return SceneStatistics(
        objects=len(scene.objects),
        transparent_objects=len(scene.transparent),
        triangles=_triangles(scene.objects),
        transparent_triangles=_triangles(scene.transparent),
        draws=len(geometry.opaque.units) + len(geometry.transparent.units),
        fragments=int(counts.sum()),
        covered_pixels=int(np.count_nonzero(counts)),
        complexity=describe(counts),
    )


def views_of(scene: Scene) -> dict[str, Scene]:
    """Return the scene as each of its views shows it, by the name of the view.

    The eyes of a stereo pair see much the same as the view between them, and are left out.
    """
    return {name: scene.from_view(name) for name in (MAIN, *scene.views)}


def describe(counts: npt.NDArray[np.int64]) -> DepthComplexity:
    """Return the depth complexity of a frame.

    Parameters
    ----------
    counts : array, shape (h, w)
        Transparent fragments at each pixel.
    """
    covered = counts[counts > 0]
    values, pixels = np.unique(counts, return_counts=True)
    return DepthComplexity(
        mean=float(covered.mean()) if covered.size else None,
        median=float(np.median(covered)) if covered.size else None,
        worst=int(counts.max()),
        histogram=list(zip(values.tolist(), pixels.tolist(), strict=True)),
    )


def _triangles(objects: Iterable[Object]) -> int:
    meshes = [item.mesh for item in objects]
    # The scene on the device has no mesh that depends on the view any more.
    return sum(len(mesh.triangles) for mesh in meshes if isinstance(mesh, Mesh))
